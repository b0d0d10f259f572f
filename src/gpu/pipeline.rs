//! The pipelines of a device, each with the layout of its descriptor sets and made once; compute pipelines.

use std::collections::HashMap;
use std::ffi::CStr;
use std::hash::{Hash, Hasher};
use std::sync::Arc;

use ash::vk;

use super::fold::folded;
use super::graphics_pipeline::{Alpha, GraphicsState};
use super::specialize::specialize;
use super::{Bindings, Buffer, Device, Named, Promises, Recorder, Slot};
use crate::Result;

const MAIN: &CStr = c"main";

/// What tells one pipeline of a device from the others.
#[derive(PartialEq, Eq, Hash)]
pub(super) struct PipelineOf {
    pub shaders: Vec<Code>,
    /// The slots of each of its descriptor sets.
    pub slots: Vec<Vec<Slot>>,
    pub push_bytes: u32,
    pub constants: Vec<[u32; 2]>,
    pub state: Option<GraphicsState>,
}

/// A shader's SPIR-V: as it was built in, or what replaced that.
#[derive(PartialEq, Eq)]
pub(super) struct Code {
    name: &'static str,
    built_in: &'static [u32],
    replaced: Option<Arc<[u32]>>,
}

impl Hash for Code {
    /// By the name alone: to hash the words of all shaders takes longer than all else that a view asks for.
    fn hash<H: Hasher>(&self, state: &mut H) {
        self.name.hash(state);
    }
}

impl Code {
    pub(super) fn of(device: &Device, shader: &Shader) -> Self {
        let replaced = device.replaced_shader(shader);
        Self { name: shader.name, built_in: shader.words, replaced }
    }

    fn words(&self) -> &[u32] {
        self.replaced.as_deref().unwrap_or(self.built_in)
    }
}

/// A pipeline and its layout, which live as long as their device.
#[derive(Clone, Copy)]
pub(super) struct Made {
    raw: vk::Pipeline,
    layout: vk::PipelineLayout,
}

/// The pipelines of a device: each is made once, whoever asks for it.
#[derive(Default)]
pub(super) struct Pipelines {
    made: HashMap<PipelineOf, Made>,
    /// Made by two threads at once.
    twice: Vec<Made>,
}

impl Pipelines {
    /// What was asked for.
    pub(super) fn all(&self) -> impl Iterator<Item = &PipelineOf> {
        self.made.keys()
    }

    /// # Safety
    /// Nothing uses any of them any more, the device's queue included.
    pub(super) unsafe fn destroy(&mut self, device: &ash::Device) {
        for made in self.made.drain().map(|(_, made)| made).chain(self.twice.drain(..)) {
            // SAFETY: by contract.
            unsafe { made.destroy(device) };
        }
    }
}

impl Made {
    /// # Safety
    /// Nothing uses it.
    unsafe fn destroy(self, device: &ash::Device) {
        // SAFETY: by contract; null is ignored.
        unsafe {
            device.destroy_pipeline(self.raw, None);
            device.destroy_pipeline_layout(self.layout, None);
        }
    }

    /// Records that it is bound, with set `index` of `bindings` and its push constants.
    pub(super) fn bind(
        self,
        device: &Device,
        commands: Recorder<'_>,
        kind: vk::PipelineBindPoint,
        (bindings, index): (&Bindings, usize),
        push: &[u8],
    ) {
        bindings.bind(commands, kind, self.layout, index);
        // SAFETY: the set matches the layout, which has room for `push`; the command buffer is recorded.
        unsafe {
            device.raw.cmd_bind_pipeline(commands.raw(), kind, self.raw);
            if !push.is_empty() {
                let stages = vk::ShaderStageFlags::ALL;
                device.raw.cmd_push_constants(commands.raw(), self.layout, stages, 0, push);
            }
        }
    }
}

impl Device {
    /// The pipeline that `of` describes, made with a layout for `bindings` if there is none yet.
    pub(super) fn pipeline(&self, bindings: &Bindings, of: PipelineOf) -> Result<Made> {
        let name = of.name();
        if let Some(made) = self.pipelines_made().made.get(&of) {
            return Ok(*made);
        }
        // Not under the lock: drivers compile for seconds.
        let layout = of.layout(&self.raw, &bindings.layouts())?;
        if self.only_describes() {
            let made = Made { raw: vk::Pipeline::null(), layout };
            self.pipelines_made().made.insert(of, made);
            return Ok(made);
        }
        let flags = vk::PipelineCreateFlags::empty();
        let raw = of.make(&self.raw, self.report.promises, self.pipeline_cache, layout, flags);
        let made = Made { raw: *raw.as_ref().unwrap_or(&vk::Pipeline::null()), layout };
        if let Err(error) = raw {
            // SAFETY: just made, and not used.
            unsafe { made.destroy(&self.raw) };
            return Err(error);
        }
        self.name(made.raw, name);
        self.count(|counts| &mut counts.pipelines);
        let mut pipelines = self.pipelines_made();
        if let Some(first) = pipelines.made.get(&of).copied() {
            pipelines.twice.push(made);
            return Ok(first);
        }
        pipelines.made.insert(of, made);
        Ok(made)
    }
}

/// A compiled shader.
pub struct Shader {
    /// File name in `glsl/`.
    pub name: &'static str,
    /// The macro that tells variants of one file apart.
    pub define: Option<&'static str>,
    /// SPIR-V.
    words: &'static [u32],
}

impl Shader {
    /// A shader of the caller's.
    ///
    /// # Safety
    /// The words are valid SPIR-V of a shader for the pipelines, sets and push constants that it is used with.
    pub const unsafe fn new(
        name: &'static str,
        define: Option<&'static str>,
        words: &'static [u32],
    ) -> Self {
        Self { name, define, words }
    }

    /// The SPIR-V.
    pub fn words(&self) -> &'static [u32] {
        self.words
    }
}

/// Specialization constants: number, as [`super::sets`] has it, and value, 32 bits each.
pub type Specialization<'a> = &'a [[u32; 2]];

/// A shader with its constants given, which lives as long as the pipeline is made.
struct Module<'a> {
    raw: vk::ShaderModule,
    device: &'a ash::Device,
}

impl<'a> Module<'a> {
    fn new(
        device: &'a ash::Device,
        promises: Promises,
        code: &Code,
        constants: Specialization<'_>,
    ) -> Result<Self> {
        let words = folded(&specialize(code.words(), constants, promises));
        let info = vk::ShaderModuleCreateInfo::default().code(&words);
        // SAFETY: the words are SPIR-V, as whoever made the shader or replaced it has promised.
        let raw = unsafe { device.create_shader_module(&info, None) }
            .named("vkCreateShaderModule", code.name)?;
        Ok(Self { raw, device })
    }
}

impl Drop for Module<'_> {
    fn drop(&mut self) {
        // SAFETY: pipelines do not need their modules once made.
        unsafe { self.device.destroy_shader_module(self.raw, None) };
    }
}

impl PipelineOf {
    /// What it is called: by its first shader.
    pub(super) fn name(&self) -> &'static str {
        self.shaders[0].name
    }

    /// Its fragment shader, or its other one.
    pub(super) fn shader_of(&self, fragment: bool) -> &'static str {
        self.shaders[if fragment { 1 } else { 0 }].name
    }

    /// Its specialization constants.
    pub(super) fn constants(&self) -> Specialization<'_> {
        &self.constants
    }

    /// What its sets hold.
    pub(super) fn slots(&self) -> &[Vec<Slot>] {
        &self.slots
    }

    /// A layout for it, with these of its sets.
    pub(super) fn layout(
        &self,
        device: &ash::Device,
        sets: &[vk::DescriptorSetLayout],
    ) -> Result<vk::PipelineLayout> {
        let ranges = [vk::PushConstantRange {
            stage_flags: vk::ShaderStageFlags::ALL,
            offset: 0,
            size: self.push_bytes,
        }];
        let info = vk::PipelineLayoutCreateInfo::default().set_layouts(sets);
        let info = if self.push_bytes > 0 { info.push_constant_ranges(&ranges) } else { info };
        // SAFETY: `info` and all it points to outlive the call.
        unsafe { device.create_pipeline_layout(&info, None) }
            .named("vkCreatePipelineLayout", self.name())
    }

    /// Makes it on a device that promises so much, with a layout that fits.
    pub(super) fn make(
        &self,
        device: &ash::Device,
        promises: Promises,
        cache: vk::PipelineCache,
        layout: vk::PipelineLayout,
        flags: vk::PipelineCreateFlags,
    ) -> Result<vk::Pipeline> {
        use vk::ShaderStageFlags as Kind;
        let module = |code| Module::new(device, promises, code, &self.constants);
        let modules = self.shaders.iter().map(module).collect::<Result<Vec<_>>>()?;
        let stage = |stage, number: usize| {
            let raw = modules[number].raw;
            vk::PipelineShaderStageCreateInfo::default().stage(stage).module(raw).name(MAIN)
        };
        if let Some(state) = &self.state {
            let stages = [stage(Kind::VERTEX, 0), stage(Kind::FRAGMENT, 1)];
            return self.make_graphics(device, cache, layout, flags, state, &stages);
        }
        let stage = stage(Kind::COMPUTE, 0);
        let info =
            [vk::ComputePipelineCreateInfo::default().stage(stage).layout(layout).flags(flags)];
        // SAFETY: `info` and all it points to outlive the call.
        let made = unsafe { device.create_compute_pipelines(cache, &info, None) };
        Ok(made.map_err(|(_, result)| result).named("vkCreateComputePipelines", self.name())?[0])
    }

    fn make_graphics(
        &self,
        device: &ash::Device,
        cache: vk::PipelineCache,
        layout: vk::PipelineLayout,
        flags: vk::PipelineCreateFlags,
        state: &GraphicsState,
        stages: &[vk::PipelineShaderStageCreateInfo<'_>],
    ) -> Result<vk::Pipeline> {
        let vertex_bindings = [vk::VertexInputBindingDescription {
            binding: 0,
            stride: 16,
            input_rate: state.attribute.unwrap_or_default(),
        }];
        let vertex_attributes = [vk::VertexInputAttributeDescription {
            location: 0,
            binding: 0,
            format: vk::Format::R32G32B32A32_SFLOAT,
            offset: 0,
        }];
        let mut vertex_input = vk::PipelineVertexInputStateCreateInfo::default();
        if state.attribute.is_some() {
            vertex_input = vertex_input
                .vertex_binding_descriptions(&vertex_bindings)
                .vertex_attribute_descriptions(&vertex_attributes);
        }
        let assembly = vk::PipelineInputAssemblyStateCreateInfo::default().topology(state.topology);
        let viewport =
            vk::PipelineViewportStateCreateInfo::default().viewport_count(1).scissor_count(1);
        let raster = vk::PipelineRasterizationStateCreateInfo::default().line_width(1.0);
        let samples = vk::PipelineMultisampleStateCreateInfo::default()
            .rasterization_samples(state.samples.flags())
            .alpha_to_coverage_enable(state.alpha == Alpha::ToCoverage);
        let depth = vk::PipelineDepthStencilStateCreateInfo::default()
            .depth_test_enable(state.depth)
            .depth_write_enable(state.depth)
            .depth_compare_op(vk::CompareOp::GREATER);
        let attachment = [vk::PipelineColorBlendAttachmentState::default()
            .color_write_mask(vk::ColorComponentFlags::RGBA)
            .blend_enable(matches!(state.alpha, Alpha::Blended | Alpha::Premultiplied))
            .src_color_blend_factor(match state.alpha {
                Alpha::Premultiplied => vk::BlendFactor::ONE,
                _ => vk::BlendFactor::SRC_ALPHA,
            })
            .dst_color_blend_factor(vk::BlendFactor::ONE_MINUS_SRC_ALPHA)
            .src_alpha_blend_factor(vk::BlendFactor::ONE)
            .dst_alpha_blend_factor(vk::BlendFactor::ONE_MINUS_SRC_ALPHA)];
        let blend = vk::PipelineColorBlendStateCreateInfo::default().attachments(&attachment);
        let dynamic = [vk::DynamicState::VIEWPORT, vk::DynamicState::SCISSOR];
        let dynamic = vk::PipelineDynamicStateCreateInfo::default().dynamic_states(&dynamic);
        let colors = [state.color];
        let mut rendering =
            vk::PipelineRenderingCreateInfo::default().color_attachment_formats(&colors);
        if state.depth {
            rendering = rendering.depth_attachment_format(vk::Format::D32_SFLOAT);
        }
        let info = [vk::GraphicsPipelineCreateInfo::default()
            .stages(stages)
            .vertex_input_state(&vertex_input)
            .input_assembly_state(&assembly)
            .viewport_state(&viewport)
            .rasterization_state(&raster)
            .multisample_state(&samples)
            .depth_stencil_state(&depth)
            .color_blend_state(&blend)
            .dynamic_state(&dynamic)
            .layout(layout)
            .flags(flags)
            .push_next(&mut rendering)];
        // SAFETY: `info` and all it points to outlive the call.
        let made = unsafe { device.create_graphics_pipelines(cache, &info, None) };
        Ok(made.map_err(|(_, result)| result).named("vkCreateGraphicsPipelines", self.name())?[0])
    }
}

/// A compute pipeline; it lives as long as its device.
pub struct ComputePipeline {
    made: Made,
    device: Arc<Device>,
}

impl ComputePipeline {
    /// Makes the pipeline of a compute shader with the sets of `bindings`, and whose push constants
    /// take `push_bytes`.
    ///
    /// # Errors
    /// [`crate::Error::Vulkan`] if the driver refuses.
    pub fn new(
        device: &Arc<Device>,
        shader: &Shader,
        bindings: &Bindings,
        push_bytes: u32,
        specialization: Specialization<'_>,
    ) -> Result<Self> {
        let of = PipelineOf {
            shaders: vec![Code::of(device, shader)],
            slots: bindings.slots(),
            push_bytes,
            constants: specialization.to_vec(),
            state: None,
        };
        Ok(Self { made: device.pipeline(bindings, of)?, device: device.clone() })
    }

    /// Dispatches `groups` workgroups along x, y and z with set `index` of `bindings`.
    pub fn dispatch(
        &self,
        commands: Recorder<'_>,
        bindings: &Bindings,
        index: usize,
        push: &[u8],
        groups: [u32; 3],
    ) {
        if self.device.only_describes() {
            return;
        }
        let (kind, [x, y, z]) = (vk::PipelineBindPoint::COMPUTE, groups);
        self.made.bind(&self.device, commands, kind, (bindings, index), push);
        // SAFETY: everything is bound; the command buffer is recorded outside rendering.
        unsafe { self.device.raw.cmd_dispatch(commands.raw(), x, y, z) };
    }

    /// Dispatches as many workgroups as `arguments` holds at a byte offset, with the first set of `bindings`. Along x they are none
    /// where there is nothing to do.
    pub fn dispatch_indirect(
        &self,
        commands: Recorder<'_>,
        bindings: &Bindings,
        push: &[u8],
        arguments: &Buffer,
        offset: u64,
    ) {
        if self.device.only_describes() {
            return;
        }
        let (kind, raw) = (vk::PipelineBindPoint::COMPUTE, &self.device.raw);
        self.made.bind(&self.device, commands, kind, (bindings, 0), push);
        // SAFETY: as for `dispatch`; the buffer was made for indirect use.
        let dispatch =
            || unsafe { raw.cmd_dispatch_indirect(commands.raw(), arguments.raw, offset) };
        match &self.device.unless_none {
            Some(conditions) => conditions.record(commands, arguments.raw, offset, dispatch),
            None => dispatch(),
        }
    }
}
