//! Functions of `glsl/include` called with values of the test's own, by shaders in `tests/glsl` that are compiled
//! here and not shipped.

use std::path::Path;
use std::sync::Arc;

use ash::vk;
use raindrops::gpu::{
    Binding, Bindings, Buffer, Commands, ComputePipeline, Device, Memory, Resource, Shader, Slot,
    Specialization, Use, memory_barrier,
};
use raindrops::passes::frame::{Frame, FrameBuffer};

use crate::common::glsl;

/// SPIR-V of a shader in `tests/glsl`, which may include what is in `glsl/include`.
pub fn compile(name: &str) -> Vec<u32> {
    use shaderc::{CompileOptions, Compiler, EnvVersion, ResolvedInclude, ShaderKind, TargetEnv};
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/glsl").join(name);
    let source = std::fs::read_to_string(&path).expect("the test's shader");
    let mut options = CompileOptions::new().expect("shaderc");
    options.set_target_env(TargetEnv::Vulkan, EnvVersion::Vulkan1_3 as u32);
    options.set_include_callback(|name, _, _, _| {
        let content = match name {
            "constants.glsl" => Ok(raindrops::abi::glsl()),
            _ => std::fs::read_to_string(glsl().join("include").join(name)),
        };
        let content = content.map_err(|error| format!("{name}: {error}"))?;
        Ok(ResolvedInclude { resolved_name: name.into(), content })
    });
    Compiler::new()
        .expect("shaderc")
        .compile_into_spirv(&source, ShaderKind::Compute, name, "main", Some(&options))
        .unwrap_or_else(|error| panic!("{error}"))
        .as_binary()
        .to_vec()
}

/// Runs a shader of workgroups of 64 invocations, one for each of `input`, which it finds at binding 1; at binding
/// 2 it leaves `outputs` vectors for each.
pub fn run(
    device: &Arc<Device>,
    name: &'static str,
    constants: &Frame,
    input: &[[f32; 4]],
    outputs: usize,
) -> Vec<[f32; 4]> {
    run_with(device, name, constants, &[], input, outputs)
}

/// [`run`] with specialization constants.
pub fn run_with(
    device: &Arc<Device>,
    name: &'static str,
    constants: &Frame,
    specialization: Specialization<'_>,
    input: &[[f32; 4]],
    outputs: usize,
) -> Vec<[f32; 4]> {
    // SAFETY: the compiler made it, for these bindings.
    let shader = unsafe { Shader::new(name, None, compile(name).leak()) };
    let usage = vk::BufferUsageFlags::STORAGE_BUFFER;
    let frame = FrameBuffer::new(device).expect("a uniform buffer");
    let given = Buffer::upload(device, "input", input, usage).expect("a buffer");
    let bytes = (input.len() * outputs * size_of::<[f32; 4]>()) as u64;
    let found = Buffer::new(device, "output", bytes, usage, Memory::Readback).expect("a buffer");
    let slots = [
        (Slot::new(0, Binding::UNIFORM_BUFFER), Resource::Buffer(&frame.buffer)),
        (Slot::new(1, Binding::STORAGE_BUFFER), Resource::Buffer(&given)),
        (Slot::new(2, Binding::STORAGE_BUFFER), Resource::Buffer(&found)),
    ];
    let bindings = Bindings::of(device, name, &slots).expect("a set");
    let pipeline =
        ComputePipeline::new(device, &shader, &bindings, 0, specialization).expect("a pipeline");
    let groups = [(input.len() as u32).div_ceil(64), 1, 1];
    Commands::once(device, name, |commands| {
        frame.record(device, commands, constants);
        memory_barrier(device, commands, &[Use::TransferWrite], &[Use::Uniform]);
        pipeline.dispatch(commands, &bindings, 0, &[], groups);
        memory_barrier(device, commands, &[Use::ComputeWrite], &[Use::HostRead]);
    })
    .expect("a dispatch");
    found.read(input.len() * outputs)
}
