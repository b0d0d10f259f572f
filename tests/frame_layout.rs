//! `Frame` in Rust and in GLSL are the same, member for member: marker values go through a shader
//! that reads them by name. The shader is the test's own, so it is compiled here and not shipped.

mod common;

use std::mem::offset_of;

use ash::vk;
use raindrops::gpu::{
    Binding, Bindings, Buffer, Commands, ComputePipeline, Memory, Resource, Shader, Use,
    memory_barrier,
};
use raindrops::passes::frame::{Frame, FrameBuffer};

/// Words of `tests/glsl/frame_layout.comp`, which includes the shaders' own `frame.glsl`.
fn compile() -> Vec<u32> {
    use shaderc::{CompileOptions, Compiler, EnvVersion, ResolvedInclude, ShaderKind, TargetEnv};
    let source = include_str!("glsl/frame_layout.comp");
    let mut options = CompileOptions::new().expect("shaderc");
    options.set_target_env(TargetEnv::Vulkan, EnvVersion::Vulkan1_3 as u32);
    options.set_include_callback(|name, _, _, _| match name {
        "frame.glsl" => Ok(ResolvedInclude {
            resolved_name: name.into(),
            content: include_str!("../glsl/include/frame.glsl").into(),
        }),
        _ => Err(format!("{name} is not for this test")),
    });
    let compiler = Compiler::new().expect("shaderc");
    compiler
        .compile_into_spirv(
            source,
            ShaderKind::Compute,
            "frame_layout.comp",
            "main",
            Some(&options),
        )
        .unwrap_or_else(|error| panic!("{error}"))
        .as_binary()
        .to_vec()
}

/// The members in the order of their declaration, each four words, every word different.
fn markers() -> ([[u32; 4]; 15], Frame) {
    // Floats above 1, so that no driver takes a marker for a denormal or a NaN and changes it.
    let word = |member: usize, lane: usize| 0x3f80_0000 + (member * 16 + lane) as u32;
    let words = std::array::from_fn(|member| std::array::from_fn(|lane| word(member, lane)));
    let float = |member: usize| words[member].map(f32::from_bits);
    let frame = Frame {
        right: float(0),
        up: float(1),
        back: float(2),
        units: float(3),
        camera_place: words[4],
        shift: words[5],
        seed: words[6],
        motion: float(7),
        camera_high: float(8),
        camera_low: float(9),
        extent: float(10),
        image: float(11),
        frustum: float(12),
        environment: float(13),
        tone: float(14),
    };
    (words, frame)
}

#[test]
fn offsets_are_those_of_std140() {
    let offsets = [
        offset_of!(Frame, right),
        offset_of!(Frame, up),
        offset_of!(Frame, back),
        offset_of!(Frame, units),
        offset_of!(Frame, camera_place),
        offset_of!(Frame, shift),
        offset_of!(Frame, seed),
        offset_of!(Frame, motion),
        offset_of!(Frame, camera_high),
        offset_of!(Frame, camera_low),
        offset_of!(Frame, extent),
        offset_of!(Frame, image),
        offset_of!(Frame, frustum),
        offset_of!(Frame, environment),
        offset_of!(Frame, tone),
    ];
    for (member, offset) in offsets.into_iter().enumerate() {
        assert_eq!(offset, 16 * member);
    }
    assert_eq!(size_of::<Frame>(), 16 * offsets.len());
}

#[test]
fn every_member_arrives_under_its_name() {
    let (words, markers) = markers();
    let code: &'static [u32] = compile().leak();
    common::on_device(|device| {
        let frame = FrameBuffer::new(device).expect("a uniform buffer");
        let bytes = size_of_val(&words) as u64;
        let usage = vk::BufferUsageFlags::STORAGE_BUFFER;
        let copies = Buffer::new(device, "copies", bytes, usage, Memory::Readback);
        let copies = copies.expect("a buffer");
        let slots = [
            (Binding::UNIFORM_BUFFER, Resource::Buffer(&frame.buffer)),
            (Binding::STORAGE_BUFFER, Resource::Buffer(&copies)),
        ];
        let bindings = Bindings::of(device, "frame layout", &slots).expect("a set");
        let shader = Shader { name: "frame_layout.comp", define: None, words: code };
        let pipeline = ComputePipeline::new(device, &shader, &bindings, 0, &[]);
        let pipeline = pipeline.expect("a pipeline");
        Commands::once(device, "frame layout", |commands| {
            frame.record(device, commands, &markers);
            memory_barrier(device, commands, &[Use::TransferWrite], &[Use::Uniform]);
            pipeline.dispatch(commands, &bindings, 0, &[], [1, 1, 1]);
            memory_barrier(device, commands, &[Use::ComputeWrite], &[Use::HostRead]);
        })
        .expect("a dispatch");
        let arrived: Vec<[u32; 4]> = copies.read(words.len());
        assert_eq!(arrived, words);
    });
}
