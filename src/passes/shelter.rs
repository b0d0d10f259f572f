//! The surfaces that keep rain off, on the device: the height map with the largest heights level by level, and how drops fall
//! past it (`glsl/include/shelter.glsl`).
//!
//! `gather` leaves out sheltered drops, before anything is made of them, so that no later pass knows of a shelter. Its walks over
//! the map are exact: `src/rain/shelter.rs` has the same answer for every drop. `sky` leaves out what is sheltered of the medium
//! (`glsl/include/sheltered_medium.glsl`), pixel by pixel, as if all of it slanted as its drops do on the mean. Error: an edge in the
//! wind is sharp that should be as blurred as slow drops are carried farther than fast ones; transmittance within 0.5 % 10 m
//! under a roof's edge in a wind of 10 m/s (`tests/drawn/shelter.rs`). Without a shelter no pass is another.

use std::sync::Arc;

use ash::vk;
use glam::DVec3;

use crate::Result;
use crate::abi::Shelter;
use crate::gpu::{
    Buffer, Device, Image, ImageInfo, Memory, Recorder, Resource, Sampler, Slot, Upload,
    update_buffer,
};
use crate::picture::heights::{HeightMap, NOTHING};
use crate::rain::cells::Lattice;
use crate::rain::classes::Class;
use crate::rain::shelter::{Falls, levels};
use crate::scene::Scene;
use crate::scene::real_rain::RealRain;

/// The map, and the frame's constants.
pub(crate) struct ShelterMap {
    pub heights: Image,
    pub nearest: Sampler,
    pub constants: Buffer,
    /// Whether a host renews it with each frame.
    pub is_of_host: bool,
    /// The largest height of a scene's own map.
    highest: f32,
    /// How the medium of real rain falls; none without.
    medium: Option<DVec3>,
}

impl ShelterMap {
    /// Where in the constants the largest height is, in bytes.
    pub const HIGHEST_AT: u64 = (std::mem::offset_of!(Shelter, origin) + 3 * 4) as u64;

    /// The map of a scene, or room for that of a host; none if it has none.
    ///
    /// # Errors
    /// [`crate::Error::Limit`] if an edge is over the device's limit for images; [`crate::Error::Memory`] if the device has no
    /// room for it; [`crate::Error::Vulkan`] if the driver refuses.
    pub fn new(device: &Arc<Device>, scene: &Scene) -> Result<Option<Self>> {
        let own = scene.shelter.as_ref().and_then(|shelter| shelter.map());
        let heights = match (own, scene.host_shelter()) {
            (Some(map), _) => upload(device, map)?,
            (None, Some(size)) => of_host(device, size)?,
            (None, None) => return Ok(None),
        };
        use vk::BufferUsageFlags as Usage;
        let name = "constants of the shelter";
        let usage = Usage::UNIFORM_BUFFER | Usage::TRANSFER_DST;
        let bytes = size_of::<Shelter>() as u64;
        Ok(Some(Self {
            heights,
            is_of_host: own.is_none(),
            highest: own.map_or(NOTHING, |map| map.highest()),
            nearest: Sampler::nearest(device, "height map")?,
            constants: Buffer::new(device, name, bytes, usage, Memory::Device)?,
            medium: scene.real_rain().map(|rain| mean_slant(&rain)),
        }))
    }

    /// Whether the medium is another in each frame, with a host's map.
    pub fn renews_medium(&self) -> bool {
        self.is_of_host && self.medium.is_some()
    }

    /// Records how the drops of `scene`, whose real rain has these lattices, fall past its own map; a barrier to compute must
    /// follow.
    pub fn record(
        &self,
        device: &Device,
        commands: Recorder<'_>,
        scene: &Scene,
        lattices: &[Lattice],
    ) {
        if let Some(shelter) = scene.shelter.as_ref().filter(|_| !self.is_of_host) {
            let corners = [shelter.from, shelter.to];
            self.record_at(device, commands, scene, lattices, corners);
        }
    }

    /// Does what [`Self::record`] does, for a map from corner to corner.
    pub fn record_at(
        &self,
        device: &Device,
        commands: Recorder<'_>,
        scene: &Scene,
        lattices: &[Lattice],
        corners: [[f64; 2]; 2],
    ) {
        // Drops in boxes, or the lattices' classes and the medium.
        let classes = lattices.iter().map(|class| class.velocity / scene.metres);
        let boxes = scene.populations().into_iter().map(|rain| rain.velocity);
        let kinds = boxes.chain(classes).chain(self.medium);
        let (columns, rows) = (self.heights.width, self.heights.height);
        let Falls { origin, scale: [x, z], lines } =
            Falls::past(scene, corners, [columns as usize, rows as usize], kinds);
        let mut constants = Shelter {
            origin: [origin.x, origin.y, origin.z, self.highest],
            scale: [x, z, columns as f32, rows as f32],
            ..Shelter::default()
        };
        let all = constants.lines.iter_mut();
        let kinds = lines.iter().take(lines.len() - usize::from(self.medium.is_some()));
        for (line, of_kind) in all.zip(kinds) {
            *line = *of_kind;
        }
        constants.medium = lines.last().copied().unwrap_or_default();
        update_buffer(device, commands, &self.constants, 0, bytemuck::bytes_of(&constants));
    }

    /// What is bound for passes that ask for it.
    pub fn slots(&self, [heights, constants]: [Slot; 2]) -> [(Slot, Resource<'_>); 2] {
        [
            (heights, Resource::Sampled(&self.heights, &self.nearest)),
            (constants, Resource::Buffer(&self.constants)),
        ]
    }
}

/// The velocity by which drops of real rain slant as they do on the mean by what they block.
fn mean_slant(rain: &RealRain) -> DVec3 {
    let law = rain.law();
    let of_class = |class: &Class| {
        let velocity = rain.wind - class.speed * DVec3::Y;
        let blocked = law.moment_between(2.0, class.from, class.to);
        (blocked * velocity / -velocity.y, blocked)
    };
    let (slants, blocked): (Vec<DVec3>, Vec<f64>) = rain.classes().iter().map(of_class).unzip();
    slants.into_iter().sum::<DVec3>() / blocked.into_iter().sum::<f64>()
}

/// An image of a host's map with all its levels, which `src/passes/heights.rs` fills.
fn of_host(device: &Arc<Device>, size: [u32; 2]) -> Result<Image> {
    use vk::ImageUsageFlags as Usage;
    let usage = Usage::SAMPLED | Usage::STORAGE | Usage::TRANSFER_SRC;
    let flat = ImageInfo::flat("a host's height map", size, vk::Format::R32_SFLOAT, usage);
    let levels = 1 + size[0].max(size[1]).ilog2();
    Image::new(device, &ImageInfo { levels, ..flat })
}

/// An image of the map with all its levels, ready to be sampled.
fn upload(device: &Arc<Device>, map: &Arc<HeightMap>) -> Result<Image> {
    let usage = vk::ImageUsageFlags::SAMPLED | vk::ImageUsageFlags::TRANSFER_DST;
    let size = [map.columns as u32, map.rows as u32];
    let flat = ImageInfo::flat("height map", size, vk::Format::R32_SFLOAT, usage);
    let coarse = levels(map);
    let image = Image::new(device, &ImageInfo { levels: 1 + coarse.len() as u32, ..flat })?;
    let mut upload = Upload::new(device, "height map upload", &image)?;
    for (level, map) in (0..).zip(std::iter::once(&**map).chain(&coarse)) {
        upload.level(level, &map.heights, |height| *height)?;
    }
    upload.end()?;
    Ok(image)
}
