//! The host's own drops: a fountain that a compute shader of its own (`fountain.comp`) writes into a buffer in each frame, for
//! the rain's renderer to draw.

use ash::vk;
use glam::DVec3;
use raindrops::renderer::{HostParticles, ParticleCount, ParticleLayout};

use super::ground::compiled;
use super::host::{Host, Mapped};

const GLSL: &str = include_str!("fountain.comp");
/// Bytes before the drops, of which the first four are their number; and of a drop: position and radius, velocity and id.
const HEAD: u64 = 32;
pub const LAYOUT: ParticleLayout =
    ParticleLayout { stride: 32, position: 0, radius: 12, velocity: Some(16), id: Some(28) };
/// Drops of the example; with fewer they are larger, so that the picture is as full of them.
pub const DROPS: u32 = 50_000;
const RADIUS: f32 = 0.003;
/// Radius of the largest, in usual ones.
const LARGEST: f32 = 5.5;

/// The pass, and what it fills.
pub struct Fountain {
    drops: Mapped,
    count: u32,
    layout: vk::PipelineLayout,
    pipeline: vk::Pipeline,
    set_layout: vk::DescriptorSetLayout,
    pool: vk::DescriptorPool,
    set: vk::DescriptorSet,
}

/// Push constants of `fountain.comp`.
#[repr(C)]
#[derive(Clone, Copy, bytemuck::Pod, bytemuck::Zeroable)]
struct Push {
    time: f32,
    radius: f32,
    all: u32,
}

impl Fountain {
    pub fn new(host: &Host, count: u32) -> Self {
        let device = &host.device;
        let bytes = HEAD + u64::from(LAYOUT.stride) * u64::from(count);
        let drops = host.buffer(bytes, vk::BufferUsageFlags::STORAGE_BUFFER);
        let kind = vk::DescriptorType::STORAGE_BUFFER;
        let compute = vk::ShaderStageFlags::COMPUTE;
        let slots = [vk::DescriptorSetLayoutBinding::default()
            .descriptor_type(kind)
            .descriptor_count(1)
            .stage_flags(compute)];
        let sizes = [vk::DescriptorPoolSize { ty: kind, descriptor_count: 1 }];
        let ranges =
            [vk::PushConstantRange::default().stage_flags(compute).size(size_of::<Push>() as u32)];
        let code = compiled(GLSL, shaderc::ShaderKind::Compute, None);
        // SAFETY: valid infos, which outlive the calls.
        unsafe {
            let info = vk::DescriptorSetLayoutCreateInfo::default().bindings(&slots);
            let set_layout = device.create_descriptor_set_layout(&info, None).expect("a layout");
            let info = vk::DescriptorPoolCreateInfo::default().pool_sizes(&sizes).max_sets(1);
            let pool = device.create_descriptor_pool(&info, None).expect("a pool");
            let layouts = [set_layout];
            let info = vk::DescriptorSetAllocateInfo::default()
                .descriptor_pool(pool)
                .set_layouts(&layouts);
            let set = device.allocate_descriptor_sets(&info).expect("a set")[0];
            let buffers = [vk::DescriptorBufferInfo::default().buffer(drops.raw).range(bytes)];
            let write = vk::WriteDescriptorSet::default()
                .dst_set(set)
                .descriptor_type(kind)
                .buffer_info(&buffers);
            device.update_descriptor_sets(&[write], &[]);
            let info = vk::PipelineLayoutCreateInfo::default()
                .set_layouts(&layouts)
                .push_constant_ranges(&ranges);
            let layout = device.create_pipeline_layout(&info, None).expect("a layout");
            let info = vk::ShaderModuleCreateInfo::default().code(&code);
            let module = device.create_shader_module(&info, None).expect("a module");
            let stage = vk::PipelineShaderStageCreateInfo::default()
                .stage(compute)
                .module(module)
                .name(c"main");
            let info = [vk::ComputePipelineCreateInfo::default().stage(stage).layout(layout)];
            let made = device.create_compute_pipelines(vk::PipelineCache::null(), &info, None);
            device.destroy_shader_module(module, None);
            Self {
                drops,
                count,
                layout,
                pipeline: made.expect("a pipeline")[0],
                set_layout,
                pool,
                set,
            }
        }
    }

    /// Records the drops of a time in seconds, and says what the renderer is to know of them.
    pub fn record(&self, host: &Host, commands: vk::CommandBuffer, time: f64) -> HostParticles {
        let (device, compute) = (&host.device, vk::PipelineBindPoint::COMPUTE);
        let radius = RADIUS * (DROPS as f32 / self.count as f32).sqrt();
        let push = Push { time: time as f32, radius, all: self.count };
        let stages = vk::ShaderStageFlags::COMPUTE;
        // The frame before may still be reading the buffer; the renderer reads what is written now.
        use vk::{AccessFlags2 as Access, PipelineStageFlags2 as Stage};
        let read = (Stage::COMPUTE_SHADER, Access::SHADER_STORAGE_READ);
        let written = (Stage::COMPUTE_SHADER, Access::SHADER_STORAGE_WRITE);
        let wait = |(stage, access), (next_stage, next_access)| {
            let barrier = [vk::MemoryBarrier2::default()
                .src_stage_mask(stage)
                .src_access_mask(access)
                .dst_stage_mask(next_stage)
                .dst_access_mask(next_access)];
            let info = vk::DependencyInfo::default().memory_barriers(&barrier);
            // SAFETY: the command buffer is being recorded, outside of any rendering.
            unsafe { device.cmd_pipeline_barrier2(commands, &info) };
        };
        wait((read.0, Access::NONE), written);
        // SAFETY: likewise; the set matches the layout.
        unsafe {
            device.cmd_bind_pipeline(commands, compute, self.pipeline);
            device.cmd_bind_descriptor_sets(commands, compute, self.layout, 0, &[self.set], &[]);
            let push = bytemuck::bytes_of(&push);
            device.cmd_push_constants(commands, self.layout, stages, 0, push);
            device.cmd_dispatch(commands, self.count.div_ceil(64), 1, 1);
        }
        wait(written, read);
        let count = ParticleCount::OnDevice(self.drops.raw, 0);
        let within = [DVec3::new(-4.0, 0.0, -5.0), DVec3::new(4.0, 3.0, 3.0)];
        let drops = (self.drops.raw, self.drops.bytes - HEAD);
        let particles = HostParticles::new(drops, LAYOUT, count, within, LARGEST * radius);
        HostParticles { offset: HEAD, ..particles }
    }

    /// The drops' bytes, when the device is done with them.
    pub fn read(&self) -> Vec<u8> {
        self.drops.get().split_off(HEAD as usize)
    }

    pub fn destroy(self, host: &Host) {
        host.destroy_buffer(self.drops);
        // SAFETY: nothing uses them.
        unsafe {
            host.device.destroy_pipeline(self.pipeline, None);
            host.device.destroy_pipeline_layout(self.layout, None);
            host.device.destroy_descriptor_pool(self.pool, None);
            host.device.destroy_descriptor_set_layout(self.set_layout, None);
        }
    }
}
