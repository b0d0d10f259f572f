//! The host's own scene: a ground and boxes, one of them moving, under a sky with a sun; rasterised with reversed,
//! infinite depth. `ground.glsl` holds both shaders.

#![allow(dead_code, reason = "the example and a test use a part of this each")]

use ash::vk;
use glam::{DMat4, DVec3, DVec4, Mat4, Vec3, Vec4};
use raindrops::device::ImageState;

use super::host::{Host, Texture};

pub const COLOR: vk::Format = vk::Format::R16G16B16A16_SFLOAT;
pub const DEPTH: vk::Format = vk::Format::D32_SFLOAT;
/// Nearest that is drawn.
pub const NEAR: f64 = 0.05;
const GLSL: &str = include_str!("ground.glsl");

/// The sky's light from a direction, as `ground.glsl` has it; the sun is some 3° across.
pub fn sky(d: DVec3) -> Vec3 {
    let sun = DVec3::new(0.5, 0.55, -0.67).normalize();
    if d.dot(sun) > 0.9997 {
        return Vec3::splat(900.0);
    }
    let up = d.y.clamp(-1.0, 1.0) as f32;
    if up < 0.0 {
        return Vec3::new(0.16, 0.15, 0.13) * (1.0 + 0.5 * up);
    }
    Vec3::new(0.85, 0.9, 1.0).lerp(Vec3::new(0.22, 0.42, 0.9), up.sqrt())
}

/// A box: middle, half of its edges, colour.
pub type Block = (Vec3, Vec3, Vec3);

/// Everything that is drawn at a time in seconds: the last box moves.
pub fn blocks(time: f64) -> [Block; 4] {
    let moving = Vec3::new((2.0 * (1.4 * time).sin()) as f32, 0.6, -3.2);
    [
        (Vec3::new(0.0, -0.5, 0.0), Vec3::new(60.0, 0.5, 60.0), Vec3::new(0.5, 0.48, 0.44)),
        (Vec3::new(-1.6, 0.9, -4.5), Vec3::new(0.6, 0.9, 0.6), Vec3::new(0.75, 0.25, 0.18)),
        (Vec3::new(1.9, 0.5, -2.2), Vec3::new(0.5, 0.5, 0.5), Vec3::new(0.2, 0.5, 0.3)),
        (moving, Vec3::new(0.35, 0.35, 0.35), Vec3::new(0.9, 0.75, 0.2)),
    ]
}

/// From world space to the eye's, which looks along -z.
pub fn view(eye: DVec3, target: DVec3) -> DMat4 {
    let forward = (target - eye).normalize();
    let right = forward.cross(DVec3::Y).normalize();
    let to_world = glam::DMat3::from_cols(right, right.cross(forward), -forward);
    DMat4::from_mat3(to_world.transpose()) * DMat4::from_translation(-eye)
}

/// A perspective with reversed, infinite depth, moved by a part of a pixel.
pub fn projection(vertical_fov: f64, (width, height): (u32, u32), jitter: [f64; 2]) -> DMat4 {
    let (width, height) = (f64::from(width), f64::from(height));
    let focal = 1.0 / (0.5 * vertical_fov.to_radians()).tan();
    DMat4::from_cols(
        DVec4::new(focal * height / width, 0.0, 0.0, 0.0),
        DVec4::new(0.0, -focal, 0.0, 0.0),
        DVec4::new(-2.0 * jitter[0] / width, -2.0 * jitter[1] / height, 0.0, -1.0),
        DVec4::new(0.0, 0.0, NEAR, 0.0),
    )
}

/// To the clip space of a face of a cube map around a point, in Vulkan's order of faces.
pub fn to_face(middle: DVec3, face: usize) -> DMat4 {
    use glam::DVec3 as V;
    let (right, down, along) = [
        (V::NEG_Z, V::NEG_Y, V::X),
        (V::Z, V::NEG_Y, V::NEG_X),
        (V::X, V::Z, V::Y),
        (V::X, V::NEG_Z, V::NEG_Y),
        (V::X, V::NEG_Y, V::Z),
        (V::NEG_X, V::NEG_Y, V::NEG_Z),
    ][face];
    let rows =
        [right.extend(0.0), down.extend(0.0), DVec4::new(0.0, 0.0, 0.0, NEAR), along.extend(0.0)];
    DMat4::from_cols(rows[0], rows[1], rows[2], rows[3]).transpose()
        * DMat4::from_translation(-middle)
}

/// Push constants of `ground.glsl`.
#[repr(C)]
#[derive(Clone, Copy, bytemuck::Pod, bytemuck::Zeroable)]
struct Push {
    to_clip: Mat4,
    middle: Vec4,
    half: Vec4,
    color: Vec4,
}

/// The host's pipeline.
pub struct Ground {
    layout: vk::PipelineLayout,
    pipeline: vk::Pipeline,
}

/// SPIR-V of a shader; `define`: the macro that tells it from others of its text.
pub fn compiled(text: &str, kind: shaderc::ShaderKind, define: Option<&str>) -> Vec<u32> {
    let compiler = shaderc::Compiler::new().expect("a compiler");
    let mut options = shaderc::CompileOptions::new().expect("options");
    if let Some(define) = define {
        options.add_macro_definition(define, None);
    }
    let made = compiler.compile_into_spirv(text, kind, "the host's", "main", Some(&options));
    made.expect("the host's shaders").as_binary().to_vec()
}

impl Ground {
    pub fn new(host: &Host) -> Self {
        let device = &host.device;
        let shaders = [
            (shaderc::ShaderKind::Vertex, "VERTEX", vk::ShaderStageFlags::VERTEX),
            (shaderc::ShaderKind::Fragment, "FRAGMENT", vk::ShaderStageFlags::FRAGMENT),
        ];
        let ranges = [vk::PushConstantRange::default()
            .stage_flags(vk::ShaderStageFlags::VERTEX | vk::ShaderStageFlags::FRAGMENT)
            .size(size_of::<Push>() as u32)];
        let info = vk::PipelineLayoutCreateInfo::default().push_constant_ranges(&ranges);
        // SAFETY: valid infos, which outlive the calls.
        unsafe {
            let layout = device.create_pipeline_layout(&info, None).expect("a layout");
            let stages = shaders.map(|(kind, define, stage)| {
                let code = compiled(GLSL, kind, Some(define));
                let info = vk::ShaderModuleCreateInfo::default().code(&code);
                let module = device.create_shader_module(&info, None).expect("a module");
                vk::PipelineShaderStageCreateInfo::default()
                    .stage(stage)
                    .module(module)
                    .name(c"main")
            });
            let vertices = vk::PipelineVertexInputStateCreateInfo::default();
            let assembly = vk::PipelineInputAssemblyStateCreateInfo::default()
                .topology(vk::PrimitiveTopology::TRIANGLE_LIST);
            let viewport =
                vk::PipelineViewportStateCreateInfo::default().viewport_count(1).scissor_count(1);
            let raster = vk::PipelineRasterizationStateCreateInfo::default().line_width(1.0);
            let samples = vk::PipelineMultisampleStateCreateInfo::default()
                .rasterization_samples(vk::SampleCountFlags::TYPE_1);
            let depth = vk::PipelineDepthStencilStateCreateInfo::default()
                .depth_test_enable(true)
                .depth_write_enable(true)
                .depth_compare_op(vk::CompareOp::GREATER_OR_EQUAL);
            let attachments = [vk::PipelineColorBlendAttachmentState::default()
                .color_write_mask(vk::ColorComponentFlags::RGBA)];
            let blend = vk::PipelineColorBlendStateCreateInfo::default().attachments(&attachments);
            let dynamic = [vk::DynamicState::VIEWPORT, vk::DynamicState::SCISSOR];
            let dynamic = vk::PipelineDynamicStateCreateInfo::default().dynamic_states(&dynamic);
            let colors = [COLOR];
            let mut rendering = vk::PipelineRenderingCreateInfo::default()
                .color_attachment_formats(&colors)
                .depth_attachment_format(DEPTH);
            let info = [vk::GraphicsPipelineCreateInfo::default()
                .stages(&stages)
                .vertex_input_state(&vertices)
                .input_assembly_state(&assembly)
                .viewport_state(&viewport)
                .rasterization_state(&raster)
                .multisample_state(&samples)
                .depth_stencil_state(&depth)
                .color_blend_state(&blend)
                .dynamic_state(&dynamic)
                .layout(layout)
                .push_next(&mut rendering)];
            let made = device.create_graphics_pipelines(vk::PipelineCache::null(), &info, None);
            for stage in stages {
                device.destroy_shader_module(stage.module, None);
            }
            Self { layout, pipeline: made.expect("a pipeline")[0] }
        }
    }

    /// Draws blocks under the sky into a colour and a depth view, both attachments.
    pub fn draw(
        &self,
        host: &Host,
        commands: vk::CommandBuffer,
        [color, depth]: [vk::ImageView; 2],
        (width, height): (u32, u32),
        (to_clip, eye): (DMat4, DVec3),
        blocks: &[Block],
    ) {
        let area =
            vk::Rect2D { offset: Default::default(), extent: vk::Extent2D { width, height } };
        let attachment = |view, layout| {
            vk::RenderingAttachmentInfo::default()
                .image_view(view)
                .image_layout(layout)
                .load_op(vk::AttachmentLoadOp::CLEAR)
                .store_op(vk::AttachmentStoreOp::STORE)
        };
        let colors = [attachment(color, vk::ImageLayout::COLOR_ATTACHMENT_OPTIMAL)];
        // Cleared to 0, which is infinitely far.
        let depth = attachment(depth, vk::ImageLayout::DEPTH_ATTACHMENT_OPTIMAL);
        let info = vk::RenderingInfo::default()
            .render_area(area)
            .layer_count(1)
            .color_attachments(&colors)
            .depth_attachment(&depth);
        let viewport = vk::Viewport {
            width: width as f32,
            height: height as f32,
            max_depth: 1.0,
            ..Default::default()
        };
        // The sky is a box around the eye, infinitely far.
        let sky = (eye.as_vec3(), Vec3::splat(10.0), Vec3::ZERO, 1.0);
        let blocks = blocks.iter().map(|&(middle, half, color)| (middle, half, color, 0.0));
        let device = &host.device;
        // SAFETY: the command buffer is being recorded; the images are in these layouts.
        unsafe {
            device.cmd_begin_rendering(commands, &info);
            device.cmd_set_viewport(commands, 0, &[viewport]);
            device.cmd_set_scissor(commands, 0, &[area]);
            device.cmd_bind_pipeline(commands, vk::PipelineBindPoint::GRAPHICS, self.pipeline);
            for (middle, half, color, is_sky) in std::iter::once(sky).chain(blocks) {
                let push = Push {
                    to_clip: to_clip.as_mat4(),
                    middle: middle.extend(is_sky),
                    half: half.extend(0.0),
                    color: color.extend(1.0),
                };
                let stages = vk::ShaderStageFlags::VERTEX | vk::ShaderStageFlags::FRAGMENT;
                device.cmd_push_constants(
                    commands,
                    self.layout,
                    stages,
                    0,
                    bytemuck::bytes_of(&push),
                );
                device.cmd_draw(commands, 36, 1, 0, 0);
            }
            device.cmd_end_rendering(commands);
        }
    }

    pub fn destroy(self, host: &Host) {
        // SAFETY: nothing uses them.
        unsafe {
            host.device.destroy_pipeline(self.pipeline, None);
            host.device.destroy_pipeline_layout(self.layout, None);
        }
    }
}

/// Fills an image that comes as `before` and goes as a target of copies.
pub fn clear(
    host: &Host,
    commands: vk::CommandBuffer,
    texture: &Texture,
    before: ImageState,
    value: f32,
) {
    barrier(host, commands, texture, [before, ImageState::COPY_TARGET]);
    let layout = vk::ImageLayout::TRANSFER_DST_OPTIMAL;
    let value = vk::ClearColorValue { float32: [value; 4] };
    let range = vk::ImageSubresourceRange::default()
        .aspect_mask(texture.aspect)
        .level_count(1)
        .layer_count(1);
    // SAFETY: the command buffer is being recorded, outside of any rendering.
    unsafe {
        host.device.cmd_clear_color_image(commands, texture.image, layout, &value, &[range]);
    }
}

/// A barrier of a host's image.
pub fn barrier(
    host: &Host,
    commands: vk::CommandBuffer,
    texture: &Texture,
    [before, after]: [ImageState; 2],
) {
    let range = vk::ImageSubresourceRange::default()
        .aspect_mask(texture.aspect)
        .level_count(1)
        .layer_count(texture.layers);
    let barriers = [vk::ImageMemoryBarrier2::default()
        .src_stage_mask(before.stages)
        .src_access_mask(before.access)
        .dst_stage_mask(after.stages)
        .dst_access_mask(after.access)
        .old_layout(before.layout)
        .new_layout(after.layout)
        .image(texture.image)
        .subresource_range(range)];
    let info = vk::DependencyInfo::default().image_memory_barriers(&barriers);
    // SAFETY: the command buffer is being recorded, outside of any rendering.
    unsafe { host.device.cmd_pipeline_barrier2(commands, &info) };
}
