//! egui's triangles over the picture (`glsl/overlay.{vert,frag}`).
//!
//! Shaders read vertices and indices from storage buffers, so the pass needs no vertex layout of its
//! own. Colours are premultiplied and blended in linear light, as the attachment encodes sRGB.

use std::sync::Arc;

use ash::vk;
use egui::epaint::{ClippedPrimitive, ImageDelta, Primitive, Vertex};
use egui::{ImageData, TextureId, TexturesDelta};

use super::{attachment, rendering};
use crate::Result;
use crate::gpu::sets::overlay as slot;
use crate::gpu::{
    Alpha, Bindings, Buffer, Commands, Device, GraphicsPipeline, GraphicsState, Image, ImageInfo,
    Memory, Recorder, Resource, Sampler, Use, copy_to_image, image_barrier, shaders,
};

/// Words of a vertex in the buffer: x, y, u, v, colour.
const VERTEX_WORDS: usize = 5;

/// The buffers of one frame under way, and the set with them.
struct Mesh {
    indices: Buffer,
    vertices: Buffer,
    bindings: Bindings,
}

impl Mesh {
    /// With room for so many bytes of each.
    fn new(device: &Arc<Device>, atlas: Resource<'_>, bytes: [u64; 2]) -> Result<Self> {
        let make = |name, bytes: u64| {
            let usage = vk::BufferUsageFlags::STORAGE_BUFFER;
            Buffer::new(device, name, bytes.next_power_of_two(), usage, Memory::Upload)
        };
        let (indices, vertices) =
            (make("overlay indices", bytes[0])?, make("overlay vertices", bytes[1])?);
        let slots = [
            (slot::ATLAS, atlas),
            (slot::INDICES, Resource::Buffer(&indices)),
            (slot::VERTICES, Resource::Buffer(&vertices)),
        ];
        let bindings = Bindings::of(device, "overlay", &slots)?;
        Ok(Self { indices, vertices, bindings })
    }

    fn size(&self) -> [u64; 2] {
        [self.indices.size, self.vertices.size]
    }
}

/// The pass.
pub struct Overlay {
    pipeline: GraphicsPipeline,
    sampler: Sampler,
    atlas: Image,
    meshes: Vec<Mesh>,
    device: Arc<Device>,
}

impl Overlay {
    /// A pipeline into attachments of `format`, for `frames` frames under way, one at least.
    ///
    /// # Errors
    /// [`crate::Error::Memory`] or [`crate::Error::Vulkan`]: what the driver says.
    pub fn new(device: &Arc<Device>, format: vk::Format, frames: usize) -> Result<Self> {
        let clamp = vk::SamplerAddressMode::CLAMP_TO_EDGE;
        let sampler = Sampler::linear(device, "font atlas", clamp, clamp)?;
        let atlas = make_atlas(device, [1, 1])?;
        let mesh = |_| Mesh::new(device, Resource::Sampled(&atlas, &sampler), [0; 2]);
        let meshes: Vec<_> = (0..frames).map(mesh).collect::<Result<_>>()?;
        let state =
            GraphicsState { alpha: Alpha::Premultiplied, ..GraphicsState::triangles(format) };
        let stages = [shaders::OVERLAY_VERT, shaders::OVERLAY_FRAG];
        let push_bytes = size_of::<[f32; 2]>() as u32;
        let bindings = &meshes[0].bindings;
        let pipeline = GraphicsPipeline::new(device, stages, bindings, push_bytes, &[], &state)?;
        Ok(Self { pipeline, sampler, atlas, meshes, device: device.clone() })
    }

    /// Takes over what egui changed in its font atlas, the only texture that the overlay uses.
    ///
    /// # Errors
    /// [`crate::Error::Limit`] if the atlas is over the device's limit for images;
    /// [`crate::Error::Memory`] if there is no room for it; [`crate::Error::Vulkan`] if a call fails, as
    /// for a lost device.
    pub fn update_atlas(&mut self, delta: &TexturesDelta) -> Result<()> {
        for (id, change) in &delta.set {
            if *id == TextureId::default() {
                self.upload(change)?;
            }
        }
        Ok(())
    }

    fn upload(&mut self, change: &ImageDelta) -> Result<()> {
        let ImageData::Color(image) = &change.image;
        let device = &*self.device;
        let [x, y] = change.pos.unwrap_or_default();
        let before = match change.pos {
            Some(_) => Use::GraphicsRead,
            None => {
                // Frames under way go on with the old one.
                self.atlas = make_atlas(&self.device, image.size)?;
                for mesh in &mut self.meshes {
                    let atlas = Resource::Sampled(&self.atlas, &self.sampler);
                    *mesh = Mesh::new(&self.device, atlas, mesh.size())?;
                }
                Use::Nothing
            }
        };
        let texels: Vec<[u8; 4]> = image.pixels.iter().map(|texel| texel.to_array()).collect();
        let usage = vk::BufferUsageFlags::TRANSFER_SRC;
        let staging = Buffer::upload(&self.device, "font atlas", &texels, usage)?;
        let region = [self
            .atlas
            .level_copy(0, 0)
            .image_offset(vk::Offset3D { x: x as i32, y: y as i32, z: 0 })
            .image_extent(vk::Extent3D {
                width: image.size[0] as u32,
                height: image.size[1] as u32,
                depth: 1,
            })];
        Commands::once(&self.device, "font atlas", |commands| {
            image_barrier(device, commands, &self.atlas, before, Use::TransferWrite);
            copy_to_image(device, commands, &staging, &self.atlas, &region);
            image_barrier(device, commands, &self.atlas, Use::TransferWrite, Use::GraphicsRead);
        })
    }

    /// Records the pass over `target`, a colour attachment whose content is kept. The last use of
    /// frame `frame` must be done; `points_px` is the size of a point in pixels.
    ///
    /// # Errors
    /// [`crate::Error::Limit`] if the triangles do not fit in one binding; [`crate::Error::Memory`] if
    /// there is no room for them; [`crate::Error::Vulkan`] if the driver refuses.
    pub fn record(
        &mut self,
        commands: Recorder<'_>,
        frame: usize,
        target: &Image,
        primitives: &[ClippedPrimitive],
        points_px: f32,
    ) -> Result<()> {
        let mut indices: Vec<u32> = Vec::new();
        let mut vertices: Vec<[u32; VERTEX_WORDS]> = Vec::new();
        let mut draws = Vec::new();
        for ClippedPrimitive { clip_rect, primitive } in primitives {
            // Nothing here asks for callbacks, the other kind of primitive.
            let Primitive::Mesh(mesh) = primitive else { continue };
            let scissor = scissor(*clip_rect, points_px, target);
            let (first, base) = (indices.len() as u32, vertices.len() as u32);
            indices.extend(mesh.indices.iter().map(|index| base + index));
            vertices.extend(mesh.vertices.iter().map(words));
            draws.push((scissor, first, mesh.indices.len() as u32));
        }
        let bytes = [size_of_val(&indices[..]) as u64, size_of_val(&vertices[..]) as u64];
        let mesh = &mut self.meshes[frame];
        if mesh.indices.size < bytes[0] || mesh.vertices.size < bytes[1] {
            let atlas = Resource::Sampled(&self.atlas, &self.sampler);
            *mesh = Mesh::new(&self.device, atlas, bytes)?;
        }
        mesh.indices.write(0, &indices);
        mesh.vertices.write(0, &vertices);

        let device = &*self.device;
        let color = attachment(target, vk::AttachmentLoadOp::LOAD);
        let size = (target.width, target.height);
        let push = [size.0 as f32 / points_px, size.1 as f32 / points_px];
        rendering(device, commands, color, None, size, 0.0, || {
            self.pipeline.bind(commands, &mesh.bindings, bytemuck::cast_slice(&push));
            for (scissor, first, count) in draws {
                // SAFETY: within a rendering, with everything bound; the scissor is in the target.
                unsafe {
                    device.raw().cmd_set_scissor(commands.raw(), 0, &[scissor]);
                    device.raw().cmd_draw(commands.raw(), count, 1, first, 0);
                }
            }
        });
        Ok(())
    }
}

fn words(vertex: &Vertex) -> [u32; VERTEX_WORDS] {
    let Vertex { pos, uv, color } = vertex;
    let color = u32::from_le_bytes(color.to_array());
    [pos.x.to_bits(), pos.y.to_bits(), uv.x.to_bits(), uv.y.to_bits(), color]
}

fn scissor(clip: egui::Rect, points_px: f32, target: &Image) -> vk::Rect2D {
    let within =
        |points: f32, edge: u32| (points * points_px).round().clamp(0.0, edge as f32) as u32;
    let (left, top) = (within(clip.min.x, target.width), within(clip.min.y, target.height));
    let (right, bottom) = (within(clip.max.x, target.width), within(clip.max.y, target.height));
    vk::Rect2D {
        offset: vk::Offset2D { x: left as i32, y: top as i32 },
        extent: vk::Extent2D {
            width: right.saturating_sub(left),
            height: bottom.saturating_sub(top),
        },
    }
}

fn make_atlas(device: &Arc<Device>, size: [usize; 2]) -> Result<Image> {
    let (size, format) = (size.map(|edge| edge as u32), vk::Format::R8G8B8A8_UNORM);
    let usage = vk::ImageUsageFlags::SAMPLED | vk::ImageUsageFlags::TRANSFER_DST;
    Image::new(device, &ImageInfo::flat("font atlas", size, format, usage))
}
