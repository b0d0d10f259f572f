//! What is behind the drops instead of the environment: a picture, and how far away it is at each pixel
//! (`glsl/sky.comp`, `BEFORE`).
//!
//! Both are sampled images of the whole picture, a texel a pixel, whoever made them: a plate's files, uploaded here, or
//! what an engine has drawn. A [`Convention`] says what they hold. One pass turns them into what the other passes read,
//! pixel by pixel of a tile after the other: light in stored units, seen through the medium of far rain up to where the
//! pixel is, and the distance along the ray through the pixel's middle (`glsl/include/behind.glsl`).
//!
//! A drop is hidden where its ray meets it farther away: tile fragments pixel by pixel, glints each by its own ray, splats
//! (under 1.5 pixels of radius) by their centre. A drop that cuts a surface has a smooth edge there: of the pixel's part
//! of it that is covered which is nearer than the pixel's distance. Error: the distance is one a pixel, so a surface
//! that is steep within a pixel cuts by its middle.
//!
//! Without a background nothing of this is made: no buffer, no pass, and the other shaders are compiled without it.

use std::sync::Arc;

use ash::vk;
use half::f16;

use super::composite::Prepared;
use crate::Result;
use crate::abi::BackgroundPush;
use crate::gpu::sets::{background as slot, constant};
use crate::gpu::{
    Bindings, Buffer, ComputePipeline, Device, HostImage, Image, ImageInfo, Recorder, Resource,
    Sampler, Texel, Texels, Upload, Use, shaders,
};
use crate::picture::plate::Plate;
use crate::scene::background::DepthKind;
use crate::scene::matrices::ProjectedDepth;

/// What the images of a background hold.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Convention {
    /// Radiance of a 1 in the colour image; none: there is no colour image, and the environment is behind.
    pub color: Option<f32>,
    /// What the depth image holds; none: there is none, and nothing hides a drop.
    pub depth: Option<DepthConvention>,
}

/// What a depth image holds: a stored `s` is at (a s + b) / (c s + d) scene units, and where c s + d is not over 0 nothing is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DepthConvention {
    /// a, b, c, d.
    pub map: [f32; 4],
    /// Along the view axis or along the ray.
    pub kind: DepthKind,
}

impl DepthConvention {
    /// Depth in proportion to what is stored.
    pub fn linear(scene_units: f32, kind: DepthKind) -> Self {
        Self { map: [scene_units, 0.0, 0.0, 1.0], kind }
    }

    /// Depth as a perspective projection leaves it in a depth attachment of the whole range 0 to 1, reversed or not, the
    /// far plane at infinity or not: `scale` and `offset` are what the matrix makes of a view-space z (of which the camera
    /// looks along -z): depth = (scale · z + offset) / -z.
    pub fn projected(scale: f32, offset: f32) -> Self {
        // Depths are over 0; where larger ones are stored for what is farther, that is -offset / (-s - scale).
        let sign = 1f32.copysign(offset);
        Self { map: [0.0, sign * offset, sign, sign * scale], kind: DepthKind::Planar }
    }
}

impl From<ProjectedDepth> for DepthConvention {
    fn from(depth: ProjectedDepth) -> Self {
        Self::projected(-depth.a as f32, depth.b as f32)
    }
}

/// The images, and what they hold. Either may be missing.
#[derive(Default)]
pub struct BackgroundImages {
    /// Light.
    pub color: Option<Image>,
    /// Depth.
    pub depth: Option<Image>,
    /// What they hold.
    pub convention: Convention,
    /// The largest value of the colour image, where that is known; else 0.
    pub brightest: f32,
}

impl BackgroundImages {
    /// A plate on the device, ready to be sampled.
    ///
    /// # Errors
    /// [`crate::Error::Limit`] if an edge is over the device's limit for images; [`crate::Error::Memory`]
    /// if the device has no room for it; [`crate::Error::Vulkan`] if the driver refuses.
    pub fn of_plate(
        device: &Arc<Device>,
        plate: &Plate,
        (width, height): (u32, u32),
    ) -> Result<Self> {
        let image = |name, format| {
            let usage = vk::ImageUsageFlags::SAMPLED | vk::ImageUsageFlags::TRANSFER_DST;
            Image::new(device, &ImageInfo::flat(name, [width, height], format, usage))
        };
        let name = "background upload";
        let color = match plate.color() {
            None => None,
            Some(picture) => {
                let image = image("background colour", vk::Format::R32G32B32A32_SFLOAT)?;
                let mut upload = Upload::new(device, name, &image)?;
                upload.level(0, &picture.pixels, |pixel| pixel.extend(1.0).to_array())?;
                upload.end()?;
                Some(image)
            }
        };
        let depth = match plate.depth() {
            None => None,
            Some(depth) => {
                let image = image("background depth", vk::Format::R32_SFLOAT)?;
                let mut upload = Upload::new(device, name, &image)?;
                upload.level(0, &depth.values, |depth| *depth as f32)?;
                upload.end()?;
                Some(image)
            }
        };
        let convention = Convention {
            color: color.as_ref().map(|_| 1.0),
            depth: plate.depth().map(|depth| DepthConvention::linear(1.0, depth.kind)),
        };
        let brightest = plate.color().map_or(0.0, |picture| {
            picture.pixels.iter().fold(0.0, |most, pixel| pixel.max_element().max(most))
        });
        Ok(Self { color, depth, convention, brightest })
    }
}

/// Whose images are behind the drops.
#[derive(Clone)]
pub enum Behind {
    /// Ours, which stay.
    Plate(Arc<BackgroundImages>),
    /// A host's, which it names with each frame; of so many frames that may be under way at once.
    Host {
        /// Whether there is a colour image.
        color: bool,
        /// Whether there is a depth image.
        depth: bool,
        /// How many frames.
        frames: u32,
    },
}

impl Behind {
    fn has_color(&self) -> bool {
        match self {
            Self::Plate(images) => images.convention.color.is_some(),
            Self::Host { color, .. } => *color,
        }
    }

    /// Whether there is a depth that hides drops.
    pub fn has_depth(&self) -> bool {
        match self {
            Self::Plate(images) => images.convention.depth.is_some(),
            Self::Host { depth, .. } => *depth,
        }
    }
}

/// What a host has behind the drops of a frame.
#[derive(Clone, Copy, Debug, Default)]
pub struct HostBackground {
    /// Light, and the radiance of a 1.
    pub color: Option<(HostImage, f32)>,
    /// Depth, and what it holds.
    pub depth: Option<(HostImage, DepthConvention)>,
}

impl HostBackground {
    fn images(&self) -> impl Iterator<Item = &HostImage> {
        let color = self.color.iter().map(|(image, _)| image);
        color.chain(self.depth.iter().map(|(image, _)| image))
    }

    /// Makes the images ready to be read.
    pub(crate) fn take(&self, device: &Device, commands: Recorder<'_>) {
        self.images().for_each(|image| image.take(device, commands, Use::ComputeRead));
    }

    /// Hands them back.
    pub(crate) fn give_back(&self, device: &Device, commands: Recorder<'_>) {
        self.images().for_each(|image| image.give_back(device, commands, Use::ComputeRead));
    }
}

/// The largest radiance behind the drops that is stored, where a stored 1 is `radiance_scale`; what is brighter is clipped.
pub fn most_stored(radiance_scale: f32) -> f32 {
    f16::MAX.to_f32() * radiance_scale
}

/// The pass.
pub struct Background {
    /// What the frame's images hold, and which descriptor set has them.
    convention: Convention,
    set: usize,
    nearest: Sampler,
    radiance_scale: f32,
    bindings: Bindings,
    pass: ComputePipeline,
}

impl Background {
    /// The pass that reads the images `behind`, and writes `sky` and the distances of `tiles`, which must have been made for them.
    ///
    /// # Errors
    /// [`crate::Error::Vulkan`] if the driver refuses.
    pub(super) fn new(
        device: &Arc<Device>,
        Prepared { environment, splats, tiles, glints, .. }: Prepared<'_>,
        sky: &Buffer,
        behind: &Behind,
        layers: bool,
    ) -> Result<Self> {
        let nearest = Sampler::nearest(device, "background")?;
        let (images, sets) = match behind {
            Behind::Plate(images) => (Some(images), 1),
            Behind::Host { frames, .. } => (None, *frames),
        };
        let convention = images.map_or(Convention::default(), |images| images.convention);
        let [color, depth] = match images {
            Some(images) => [images.color.as_ref(), images.depth.as_ref()],
            None => [None, None],
        }
        .map(|image| match image {
            Some(image) => Resource::Sampled(image, &nearest),
            // The shader does not read it, or a host's takes its place.
            None => Resource::Sampled(&environment.image, &environment.sampler),
        });
        let splat_texels =
            Texels::new(device, "texels of splats", &splats.table, Texel::FourWords)?;
        let around = Resource::Sampled(&environment.image, &environment.sampler);
        let slots: Vec<_> = [
            (slot::COLOR_IMAGE, color),
            (slot::DEPTH_IMAGE, depth),
            (slot::SKY, Resource::Buffer(sky)),
            (slot::WHOLE_MAP, around),
            (slot::SPLAT_TABLE, Resource::Buffer(&splats.table)),
            (slot::SPLAT_TEXELS, Resource::Texels(&splat_texels)),
        ]
        .into_iter()
        .chain(tiles.shelter_slots([slot::HEIGHT_MAP, slot::SHELTER]))
        .collect();
        let bindings = Bindings::all(device, "background", &slots, sets)?.beside(&tiles.shared);
        let shader = match (tiles.has_cells(), tiles.shelter().is_some()) {
            (true, true) => shaders::SKY_COMP_MEDIUM_BEFORE_SHELTER,
            (true, false) => shaders::SKY_COMP_MEDIUM_BEFORE,
            (false, _) => shaders::SKY_COMP_BEFORE,
        };
        let push = size_of::<BackgroundPush>() as u32;
        let own = [
            [constant::HAS_COLOR, behind.has_color().into()],
            [constant::LAYERS, layers.into()],
            [constant::GLINTS, glints.count],
        ];
        let constants = [&tiles.constants[..], &own].concat();
        let pass = ComputePipeline::new(device, shader, &bindings, push, &constants)?;
        let radiance_scale = environment.radiance_scale;
        Ok(Self { convention, set: 0, nearest, radiance_scale, bindings, pass })
    }

    /// Takes a host's images for the frame that is to be recorded, in a descriptor set of its own.
    ///
    /// # Errors
    /// See [`Bindings::write`].
    ///
    /// # Safety
    /// The set is not in use, and the images stay until it is not again.
    pub(super) unsafe fn set_images(&mut self, set: usize, images: &HostBackground) -> Result<()> {
        let views =
            [images.color.map(|(image, _)| image.view), images.depth.map(|(image, _)| image.view)];
        for (view, number) in views.into_iter().zip([slot::COLOR_IMAGE, slot::DEPTH_IMAGE]) {
            let Some(view) = view else { continue };
            let resource = Resource::SampledView(view, &self.nearest);
            // SAFETY: by contract.
            unsafe { self.bindings.write(set, number, &resource)? };
        }
        self.set = set;
        self.convention = Convention {
            color: images.color.map(|(_, unit)| unit),
            depth: images.depth.map(|(_, convention)| convention),
        };
        Ok(())
    }

    /// Records it for so many workgroups, when the frame's constants are ready.
    pub(super) fn record(&self, commands: Recorder<'_>, groups: [u32; 3]) {
        let Convention { color, depth } = self.convention;
        let push = BackgroundPush {
            depth: depth.map_or([0.0; 4], |depth| depth.map),
            color_scale: color.map_or(0.0, |unit| unit / self.radiance_scale),
            depth_kind: match depth.map(|depth| depth.kind) {
                None => 0,
                Some(DepthKind::Planar) => 1,
                Some(DepthKind::Radial) => 2,
            },
        };
        self.pass.dispatch(commands, &self.bindings, self.set, bytemuck::bytes_of(&push), groups);
    }
}
