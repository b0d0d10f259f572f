//! A scene's drops on the device, as no camera and no picture changes them: shared by every view of them.

use std::sync::{Arc, Mutex, PoisonError};

use ash::vk;

use crate::Result;
use crate::gpu::{Buffer, Device};
use crate::passes::pane::{AgingDrops, PaneDrops};
use crate::rain::clusters::Clusters;
use crate::scene::pane::Pane;
use crate::scene::particles::Particles;
use crate::scene::real_rain::RealRain;
use crate::scene::{PlacedDrop, Scene};

/// The drops of a scene.
pub struct RainField {
    random: Random,
    placed: (Vec<PlacedDrop>, Option<Particles>, u32),
    clusters: Mutex<Option<Arc<SortedDrops>>>,
    pane: Option<Pane>,
    pane_drops: Mutex<AgingDrops>,
    device: Arc<Device>,
}

/// Drops in clusters, as the shaders' `box_population.glsl` has them.
pub(crate) struct SortedDrops {
    pub order: Buffer,
    pub boxes: Buffer,
    /// Places of the placed drops in their list, cluster by cluster; those that lack [`NO_DROP`].
    pub placed: Arc<[u32]>,
    /// Clusters, and those among them of random drops.
    pub counts: [u32; 2],
}

/// The scene's seed, seed and number of each population of random drops, and real rain.
type Random = (u64, Vec<(u64, u32)>, Option<RealRain>);

fn random_of(scene: &Scene) -> Random {
    let populations = scene.populations();
    let each = populations.iter().map(|rain| (rain.seed, rain.count)).collect();
    (scene.seed, each, scene.real_rain())
}

impl RainField {
    /// The drops of `scene`; what pictures need of them is made when the first asks.
    pub fn new(device: &Arc<Device>, scene: &Scene) -> Self {
        let (clusters, device) = (Mutex::default(), device.clone());
        let placed = (scene.drops.clone(), scene.particles.clone(), scene.host_particles);
        let (pane, pane_drops) = (scene.pane.clone(), Mutex::default());
        Self { random: random_of(scene), placed, clusters, pane, pane_drops, device }
    }

    /// Whether these are the drops of `scene`. Their size, box and velocity are taken from each frame's scene, as are the age of a
    /// pane and drops that are placed on it, if no rain falls there.
    pub fn is_of(&self, scene: &Scene) -> bool {
        self.random == random_of(scene)
            && self.placed.0 == scene.drops
            && self.placed.1 == scene.particles
            && self.placed.2 == scene.host_particles
            && match (&self.pane, &scene.pane) {
                (Some(pane), Some(other)) => pane.is_same_glass(other),
                (pane, other) => pane.is_none() && other.is_none(),
            }
    }

    /// The device that it is on.
    pub fn device(&self) -> &Arc<Device> {
        &self.device
    }

    /// The drops in clusters; sorted when first asked for.
    pub(crate) fn sorted(&self, scene: &Scene) -> Result<Arc<SortedDrops>> {
        let mut sorted = self.clusters.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(sorted) = &*sorted {
            return Ok(sorted.clone());
        }
        use vk::BufferUsageFlags as Usage;
        let by_texels = Usage::STORAGE_BUFFER | Usage::UNIFORM_TEXEL_BUFFER;
        let centers: Vec<_> = scene.placed().map(|drop| drop.center_at(scene.time)).collect();
        let known = scene.random_count() + scene.known_count();
        let clusters =
            Clusters::new(&scene.populations(), &centers).followed_by(known, scene.host_particles);
        self.device.count(|made| &mut made.sorts);
        let made = SortedDrops {
            order: Buffer::upload_device(&self.device, "drop order", &clusters.order, by_texels)?,
            boxes: Buffer::upload_device(&self.device, "clusters", &clusters.boxes, by_texels)?,
            placed: clusters.placed(scene.random_count()),
            counts: [clusters.count(), clusters.boxes.len() as u32],
        };
        Ok(sorted.insert(Arc::new(made)).clone())
    }

    /// The drops on the pane in `scene`, whose drops these are.
    pub(crate) fn on_pane(&self, scene: &Scene) -> Result<Arc<PaneDrops>> {
        let mut drops = self.pane_drops.lock().unwrap_or_else(PoisonError::into_inner);
        drops.of(&self.device, scene)
    }
}
