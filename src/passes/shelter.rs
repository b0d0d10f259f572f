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
    Buffer, Commands, Device, Image, ImageInfo, Memory, Recorder, Resource, Sampler, Slot, Use,
    copy_rows, copy_to_image, image_barrier, update_buffer,
};
use crate::picture::heights::HeightMap;
use crate::rain::cells::Lattice;
use crate::rain::classes::Class;
use crate::rain::shelter::{Roofs, levels};
use crate::scene::Scene;
use crate::scene::real_rain::RealRain;

/// The map, and the frame's constants.
pub(crate) struct ShelterMap {
    pub heights: Image,
    pub nearest: Sampler,
    pub constants: Buffer,
    /// How the medium of real rain falls; none without.
    medium: Option<DVec3>,
}

impl ShelterMap {
    /// The map of a scene; none if it has none.
    ///
    /// # Errors
    /// [`crate::Error::Limit`] if an edge is over the device's limit for images; [`crate::Error::Memory`] if the device has no
    /// room for it; [`crate::Error::Vulkan`] if the driver refuses.
    pub fn new(device: &Arc<Device>, scene: &Scene) -> Result<Option<Self>> {
        let Some(map) = scene.shelter.as_ref().and_then(|shelter| shelter.map()) else {
            return Ok(None);
        };
        use vk::BufferUsageFlags as Usage;
        let name = "constants of the shelter";
        let usage = Usage::UNIFORM_BUFFER | Usage::TRANSFER_DST;
        let bytes = size_of::<Shelter>() as u64;
        Ok(Some(Self {
            heights: upload(device, map)?,
            nearest: Sampler::nearest(device, "height map")?,
            constants: Buffer::new(device, name, bytes, usage, Memory::Device)?,
            medium: scene.real_rain().map(|rain| mean_slant(&rain)),
        }))
    }

    /// Records how the drops of `scene`, whose real rain has these lattices, fall past the map; a barrier to compute must follow.
    pub fn record(
        &self,
        device: &Device,
        commands: Recorder<'_>,
        scene: &Scene,
        lattices: &[Lattice],
    ) {
        let Some(roofs) = self.roofs(scene, lattices) else { return };
        let (map, [x, z], at) = (roofs.map(), roofs.scale, roofs.origin);
        let mut constants = Shelter {
            origin: [at.x, at.y, at.z, roofs.highest],
            scale: [x, z, map.columns as f32, map.rows as f32],
            ..Shelter::default()
        };
        let all = constants.lines.iter_mut();
        let kinds = roofs.lines.iter().take(roofs.lines.len() - usize::from(self.medium.is_some()));
        for (line, of_kind) in all.zip(kinds) {
            *line = *of_kind;
        }
        constants.medium = roofs.lines.last().copied().unwrap_or_default();
        update_buffer(device, commands, &self.constants, 0, bytemuck::bytes_of(&constants));
    }

    /// The surfaces over the drops of a scene: of boxes, or of the lattices' classes and the medium.
    fn roofs(&self, scene: &Scene, lattices: &[Lattice]) -> Option<Roofs> {
        let classes = lattices.iter().map(|class| class.velocity / scene.metres);
        let boxes = scene.populations().into_iter().map(|rain| rain.velocity);
        Roofs::of(scene, boxes.chain(classes).chain(self.medium))
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

/// An image of the map with all its levels, ready to be sampled.
fn upload(device: &Arc<Device>, map: &Arc<HeightMap>) -> Result<Image> {
    let name = "height map";
    let usage = vk::ImageUsageFlags::SAMPLED | vk::ImageUsageFlags::TRANSFER_DST;
    let size = [map.columns as u32, map.rows as u32];
    let flat = ImageInfo::flat(name, size, vk::Format::R32_SFLOAT, usage);
    let coarse = levels(map);
    let image = Image::new(device, &ImageInfo { levels: 1 + coarse.len() as u32, ..flat })?;
    let usage = vk::BufferUsageFlags::TRANSFER_SRC;
    let bytes = size_of_val(&map.heights[..]) as u64;
    let mut staging = Buffer::new(device, "height map upload", bytes, usage, Memory::Upload)?;
    Commands::once(device, name, |commands| {
        image_barrier(device, commands, &image, Use::Nothing, Use::TransferWrite);
    })?;
    for (level, map) in (0..).zip(std::iter::once(&**map).chain(&coarse)) {
        staging.write(0, &map.heights);
        let whole = copy_rows(&image, level, 0, map.rows as u32);
        Commands::once(device, name, |commands| {
            copy_to_image(device, commands, &staging, &image, &[whole]);
        })?;
    }
    Commands::once(device, name, |commands| {
        image_barrier(device, commands, &image, Use::TransferWrite, Use::ShaderRead);
    })?;
    Ok(image)
}
