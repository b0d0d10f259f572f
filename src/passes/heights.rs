//! A host's heights of the surfaces that keep rain off, in an image of its own that it renews with each frame
//! (`glsl/heights.comp`, `glsl/heights_level.comp`). They become the frame's height map on the device, and nothing is read back.
//!
//! An engine that keeps rain out of its houses draws its scene's depth from above, by an orthographic camera. That depth is
//! taken as it is, by the camera's matrix; so are heights in scene units. A texel of the image is one of the map, so the
//! camera's right points along ±x or ±z, and nothing is filtered: the map is bit for bit that of a file with these heights.
//! Then each level of the map has the largest heights of the level before, and the last one goes to the constants as the
//! largest of all. Cost: each texel is read twice and written 1.33 times.

use std::sync::Arc;

use glam::{DMat4, DVec2, IVec2};

use super::shelter::ShelterMap;
use crate::abi::HeightsPush;
use crate::gpu::sets::{group, heights as slot, heights_level as level_slot};
use crate::gpu::{
    Bindings, ComputePipeline, Device, HostImage, Recorder, Resource, Use, copy_to_buffer,
    image_barrier, image_discard, memory_barrier, shaders,
};
use crate::picture::heights::NOTHING;
use crate::scene::matrices::ClipSpace;
use crate::{Error, Result};

/// Invocations of a workgroup, of each pass.
const GROUP: [u32; 3] = group::HEIGHTS_COMP;
const _: () = assert!(GROUP[0] == group::HEIGHTS_LEVEL_COMP[0] && GROUP[0] == GROUP[1]);
/// A matrix may be off by so much that float32 rounds it, as a part of what it should be.
const ROUNDED: f64 = 1e-5;

/// Heights of the highest surfaces in a frame, in a host's image.
#[derive(Clone, Copy, Debug)]
pub struct HostShelter {
    /// The image: a height or a depth in the first component of each texel.
    pub image: HostImage,
    /// x and z of the outer corners of its first texel and of its last. Either may be the larger.
    pub corners: [DVec2; 2],
    /// Whether its columns run along z and its rows along x; else its columns run along x.
    pub is_turned: bool,
    /// Height of what is stored as 0 and of what is stored as 1, in scene units.
    pub heights: [f64; 2],
    /// What is stored where no surface is, beside what is not finite.
    pub empty: f32,
}

impl HostShelter {
    /// An image of heights in scene units. Its columns run from the x of `from` to that of `to`, its rows from z to z; a
    /// number that is not finite or not within ±10⁹ is no surface.
    pub fn of_heights(image: HostImage, from: DVec2, to: DVec2) -> Self {
        Self { image, corners: [from, to], is_turned: false, heights: [0.0, 1.0], empty: NOTHING }
    }

    /// The depth that a camera sees from above: orthographic, looking along -y, with its right along ±x or ±z. `matrix` takes
    /// the rain's world to clip space, whose depth from 0 to 1 may be reversed. What is at the far plane is no surface.
    ///
    /// # Errors
    /// [`Error::Scene`], one line, for a matrix of another camera.
    pub fn from_above(image: HostImage, matrix: DMat4, clip_space: ClipSpace) -> Result<Self> {
        let refuse = |problem: &str| Err(Error::scene("the shelter's matrix", problem));
        if !matrix.is_finite() {
            return refuse("it holds a number that is not finite");
        }
        let [x, y, z, w] = matrix.transpose().to_cols_array_2d(); // by row
        if w != [0.0, 0.0, 0.0, 1.0] {
            return refuse(
                "its last row is not 0, 0, 0, 1: give an orthographic projection times the view",
            );
        }
        // Whether a row is of this axis alone.
        let is_along = |row: [f64; 4], axis: usize| {
            let others = (0..3).filter(|other| *other != axis);
            row[axis] != 0.0
                && others.map(|other| row[other].abs()).fold(0.0, f64::max)
                    <= ROUNDED * row[axis].abs()
        };
        let is_turned = is_along(x, 2) && is_along(y, 0);
        if !(is_along(z, 1) && (is_turned || is_along(x, 0) && is_along(y, 2))) {
            return refuse(
                "the camera must look straight down, with its right along x or z of the rain's world",
            );
        }
        let down = match clip_space {
            ClipSpace::YDown => 1.0,
            ClipSpace::YUp => -1.0,
        };
        let at = |row: [f64; 4], axis: usize, clip: f64| (clip - row[3]) / row[axis];
        let corner = |side: f64| match is_turned {
            true => DVec2::new(at(y, 0, down * side), at(x, 2, side)),
            false => DVec2::new(at(x, 0, side), at(y, 2, down * side)),
        };
        Ok(Self {
            image,
            corners: [corner(-1.0), corner(1.0)],
            is_turned,
            heights: [at(z, 1, 0.0), at(z, 1, 1.0)],
            // Depth grows from the near plane, which is the higher one, to the far plane.
            empty: if z[1] < 0.0 { 1.0 } else { 0.0 },
        })
    }

    /// Refuses what cannot be read as a map of so many columns and rows.
    pub(crate) fn check(&self, [columns, rows]: [u32; 2]) -> Result<()> {
        let name = "the shelter";
        let Self { corners: [from, to], heights, .. } = self;
        let refuse = |problem: String| Err(Error::scene(name, problem));
        if !(from.is_finite() && to.is_finite() && from.cmpne(*to).all()) {
            return refuse(format!(
                "it is from {from} to {to}: take finite corners, apart along x and z"
            ));
        }
        let [zero, one] = heights;
        if !(zero.is_finite() && one.is_finite() && zero != one) {
            return refuse(format!(
                "a stored 0 is {zero} high, a 1 {one}: take two finite heights"
            ));
        }
        let size = if self.is_turned { (rows, columns) } else { (columns, rows) };
        self.image.check(name, size, true)
    }

    /// x and z of the map's first corner and of its last, which is over it.
    pub(crate) fn sorted(&self) -> [[f64; 2]; 2] {
        let [from, to] = self.corners;
        [from.min(to).to_array(), from.max(to).to_array()]
    }

    /// How texels of a map of so many columns and rows become heights.
    fn push(&self, size: [u32; 2]) -> HeightsPush {
        let [from, to] = self.corners;
        let axes = if self.is_turned { [IVec2::Y, IVec2::X] } else { [IVec2::X, IVec2::Y] };
        let mut first = IVec2::ZERO;
        let mut steps = axes;
        for (number, runs_back) in [from.x > to.x, from.y > to.y].into_iter().enumerate() {
            if runs_back {
                first += (size[number] as i32 - 1) * axes[number];
                steps[number] = -axes[number];
            }
        }
        let [zero, one] = self.heights;
        HeightsPush {
            first: first.to_array(),
            per_column: steps[0].to_array(),
            per_row: steps[1].to_array(),
            base: zero as f32,
            slope: (one - zero) as f32,
            empty: self.empty,
        }
    }
}

/// The passes.
pub(crate) struct Heights {
    finest: (Bindings, ComputePipeline),
    /// One for each level after the finest.
    levels: Vec<Bindings>,
    /// None for a map of one texel.
    largest: Option<ComputePipeline>,
}

impl Heights {
    /// The passes for a map that the host renews, with so many frames under way.
    ///
    /// # Errors
    /// [`Error::Vulkan`] if the driver refuses.
    pub fn new(device: &Arc<Device>, map: &ShelterMap, frames: usize) -> Result<Self> {
        let image = &map.heights;
        let slots = [
            // A frame fills it with the host's; nothing is dispatched before.
            (slot::HOST_HEIGHTS, Resource::Sampled(image, &map.nearest)),
            (slot::FINEST, Resource::Storage(image, 0)),
        ];
        let bindings = Bindings::all(device, "heights", &slots, frames as u32)?;
        let push = size_of::<HeightsPush>() as u32;
        let finest = ComputePipeline::new(device, shaders::HEIGHTS_COMP, &bindings, push, &[])?;
        let level = |number| {
            let slots = [
                (level_slot::FINE, Resource::Storage(image, number - 1)),
                (level_slot::COARSE, Resource::Storage(image, number)),
            ];
            Bindings::of(device, "level of heights", &slots)
        };
        let levels = (1..image.levels).map(level).collect::<Result<Vec<_>>>()?;
        let shader = shaders::HEIGHTS_LEVEL_COMP;
        let largest = levels.first().map(|of| ComputePipeline::new(device, shader, of, 0, &[]));
        Ok(Self { finest: (bindings, finest), levels, largest: largest.transpose()? })
    }

    /// Takes a host's image, which [`HostShelter::check`] lets pass, in descriptor set `set`.
    ///
    /// # Errors
    /// See [`Bindings::write`].
    ///
    /// # Safety
    /// The set is not in use, and the image stays until it is not again.
    pub unsafe fn set_image(
        &self,
        set: usize,
        map: &ShelterMap,
        shelter: &HostShelter,
    ) -> Result<()> {
        let resource = Resource::SampledView(shelter.image.view, &map.nearest);
        // SAFETY: by contract.
        unsafe { self.finest.0.write(set, slot::HOST_HEIGHTS, &resource) }
    }

    /// Records the map from the image of a descriptor set, after its constants. A barrier from transfers to uniforms must follow.
    pub fn record(
        &self,
        device: &Device,
        commands: Recorder<'_>,
        set: usize,
        map: &ShelterMap,
        shelter: &HostShelter,
    ) {
        let image = &map.heights;
        let groups = |level| {
            let (columns, rows) = image.level_size(level);
            [columns.div_ceil(GROUP[0]), rows.div_ceil(GROUP[1]), 1]
        };
        shelter.image.take(device, commands, Use::ComputeRead);
        let before = [Use::ComputeRead, Use::TransferRead];
        image_discard(device, commands, image, &before, Use::ComputeWrite);
        let push = shelter.push([image.width, image.height]);
        let (bindings, pass) = &self.finest;
        pass.dispatch(commands, bindings, set, bytemuck::bytes_of(&push), groups(0));
        shelter.image.give_back(device, commands, Use::ComputeRead);
        if let Some(pass) = &self.largest {
            for (level, bindings) in (1..).zip(&self.levels) {
                memory_barrier(device, commands, &[Use::ComputeWrite], &[Use::ComputeWrite]);
                pass.dispatch(commands, bindings, 0, &[], groups(level));
            }
        }
        // The constants were updated, and have the largest height now.
        memory_barrier(device, commands, &[Use::TransferWrite], &[Use::TransferWrite]);
        image_barrier(device, commands, image, Use::ComputeWrite, Use::TransferRead);
        let last = image.levels - 1;
        copy_to_buffer(device, commands, (image, last), (&map.constants, ShelterMap::HIGHEST_AT));
        image_barrier(device, commands, image, Use::TransferRead, Use::ComputeRead);
    }
}
