//! The commands of two tile frames as they are recorded: between any two passes of which one uses what the other
//! wrote stands a barrier for it.
//!
//! The validation layer of 2023 does not see hazards between dispatches that write by atomics, as most of the
//! tiles' do; so here every pass waits for every one before it, in one frame and from frame to frame, but for
//! the pairs that are known to be independent. The control takes each barrier away in turn.

mod common;

use std::collections::HashMap;
use std::ffi::{CStr, c_void};
use std::sync::atomic::{AtomicUsize, Ordering::SeqCst};
use std::sync::{LazyLock, Mutex, MutexGuard, PoisonError};

use ash::vk::{self, AccessFlags2 as Access, Handle as _, PipelineStageFlags2 as Stage};
use glam::{DVec3, Vec3};
use raindrops::environment::Environment;
use raindrops::gpu::Device;
use raindrops::plan::{Output, plan};
use raindrops::renderer::Renderer;
use raindrops::scene::model::Preset;
use raindrops::scene::{ImageSize, PlacedDrop, RainSettings, Scene};

/// A command that matters to the order.
#[derive(Clone, Debug, PartialEq)]
enum Command {
    /// A memory barrier: stages and accesses before, and after.
    Barrier((Stage, Access), (Stage, Access)),
    /// A dispatch of a pipeline. Is its workgroups' number read from a buffer, and is it left out if that is 0?
    Dispatch { pipeline: u64, name: String, indirect: bool, on_condition: bool },
    /// A fill or an update of a buffer.
    Fill,
    /// A copy of a buffer, for the host to read.
    Copy,
    /// A rendering.
    Draw,
}

#[derive(Default)]
struct Recording {
    commands: Vec<Command>,
    names: HashMap<u64, String>,
    bound: u64,
    on_condition: bool,
}

static RECORDING: LazyLock<Mutex<Recording>> = LazyLock::new(Mutex::default);

fn recording() -> MutexGuard<'static, Recording> {
    RECORDING.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Declares a module a function: its stand-in notes the call and goes on to the real one.
macro_rules! noted {
    ($($name:ident ($($arg:ident: $type:ty),*) $(-> $result:ty)? $note:block)*) => {
        $(#[allow(non_snake_case)]
        mod $name {
            use super::*;
            pub static REAL: AtomicUsize = AtomicUsize::new(0);
            pub unsafe extern "system" fn hook($($arg: $type),*) $(-> $result)? {
                $note
                // SAFETY: the layer's function of this name, which has this signature.
                unsafe {
                    let real: unsafe extern "system" fn($($type),*) $(-> $result)? =
                        std::mem::transmute(REAL.load(SeqCst));
                    real($($arg),*)
                }
            }
        })*

        fn hook_of(name: &CStr) -> Option<(*const c_void, &'static AtomicUsize)> {
            match name.to_str().ok()? {
                $(stringify!($name) => Some(($name::hook as *const c_void, &$name::REAL)),)*
                _ => None,
            }
        }
    };
}

type Info = *const vk::DependencyInfo<'static>;
type Condition = *const vk::ConditionalRenderingBeginInfoEXT<'static>;
type NameInfo = *const vk::DebugUtilsObjectNameInfoEXT<'static>;

noted! {
    vkSetDebugUtilsObjectNameEXT(device: vk::Device, info: NameInfo) -> vk::Result {
        // SAFETY: the caller's structure, with a string that ends.
        let (handle, name) = unsafe { ((*info).object_handle, CStr::from_ptr((*info).p_object_name)) };
        recording().names.insert(handle, name.to_string_lossy().into_owned());
    }
    vkCmdBindPipeline(commands: vk::CommandBuffer, point: vk::PipelineBindPoint, pipeline: vk::Pipeline) {
        recording().bound = pipeline.as_raw();
    }
    vkCmdPipelineBarrier2(commands: vk::CommandBuffer, info: Info) {
        // SAFETY: the caller's structure, with so many barriers. (Those of images order images alone.)
        let barriers = unsafe {
            let count = (*info).memory_barrier_count as usize;
            if count == 0 { &[] } else { std::slice::from_raw_parts((*info).p_memory_barriers, count) }
        };
        for barrier in barriers {
            recording().commands.push(Command::Barrier(
                (barrier.src_stage_mask, barrier.src_access_mask),
                (barrier.dst_stage_mask, barrier.dst_access_mask),
            ));
        }
    }
    vkCmdBeginConditionalRenderingEXT(commands: vk::CommandBuffer, info: Condition) {
        recording().on_condition = true;
    }
    vkCmdEndConditionalRenderingEXT(commands: vk::CommandBuffer) {
        recording().on_condition = false;
    }
    vkCmdDispatch(commands: vk::CommandBuffer, x: u32, y: u32, z: u32) {
        note_dispatch(false);
    }
    vkCmdDispatchIndirect(commands: vk::CommandBuffer, buffer: vk::Buffer, offset: u64) {
        note_dispatch(true);
    }
    vkCmdFillBuffer(commands: vk::CommandBuffer, buffer: vk::Buffer, offset: u64, size: u64, value: u32) {
        recording().commands.push(Command::Fill);
    }
    vkCmdUpdateBuffer(commands: vk::CommandBuffer, buffer: vk::Buffer, offset: u64, size: u64, data: *const c_void) {
        recording().commands.push(Command::Fill);
    }
    vkCmdCopyBuffer(commands: vk::CommandBuffer, from: vk::Buffer, to: vk::Buffer, count: u32, regions: *const c_void) {
        recording().commands.push(Command::Copy);
    }
    vkCmdBeginRendering(commands: vk::CommandBuffer, info: *const c_void) {
        recording().commands.push(Command::Draw);
    }
}

fn note_dispatch(indirect: bool) {
    let mut recording = recording();
    let pipeline = recording.bound;
    let name = recording.names.get(&pipeline).cloned().unwrap_or_default();
    let on_condition = recording.on_condition;
    recording.commands.push(Command::Dispatch { pipeline, name, indirect, on_condition });
}

/// What is done while the first pass is still at work: neither touches what the other does.
const INDEPENDENT: [(&str, &str); 6] = [
    ("sort_clusters.comp", "sky.comp"),
    ("sort_clusters.comp", "appearance.comp"),
    ("sort_clusters.comp", "flat_light.comp"),
    ("appearance.comp", "flat_light.comp"),
    ("sort_clusters.comp", "splat_table.comp"),
    ("splat_table.comp", "sky.comp"),
];

/// Does it read buffers through texels? The second dispatch of `composite.comp`, an indirect one, does not.
fn reads_texels(name: &str, indirect: bool) -> bool {
    name == "blocks.comp" || name == "composite.comp" && !indirect
}

/// A command before, and what barriers have made ready for it since: stages that wait for it, and accesses that
/// see what it wrote.
struct Before<'a> {
    command: &'a Command,
    waits: Stage,
    sees: Access,
}

/// Stages and accesses of what a command leaves behind that others must wait for.
fn leaves(command: &Command) -> (Stage, Access) {
    match command {
        Command::Barrier(..) => (Stage::NONE, Access::NONE),
        Command::Dispatch { .. } => (Stage::COMPUTE_SHADER, Access::SHADER_STORAGE_WRITE),
        Command::Fill | Command::Copy => (Stage::TRANSFER, Access::TRANSFER_WRITE),
        // It reads buffers, and writes an image, which has barriers of its own.
        Command::Draw => (Stage::FRAGMENT_SHADER, Access::NONE),
    }
}

/// What a command must be waited for and seen by, of one that is before it.
fn needs(command: &Command, before: &Command, before_is_last_other: bool) -> (Stage, Access) {
    let wrote = !matches!(before, Command::Draw | Command::Copy);
    match command {
        Command::Barrier(..) => (Stage::NONE, Access::NONE),
        Command::Dispatch { name, indirect, on_condition, .. } => {
            let mut needs = (Stage::COMPUTE_SHADER, Access::NONE);
            if matches!(before, Command::Fill) {
                // Counters and heads of lists, and the frame's constants.
                needs.1 |= Access::SHADER_STORAGE_READ | Access::UNIFORM_READ;
            } else if wrote {
                needs.1 |= Access::SHADER_STORAGE_READ;
            }
            if wrote && reads_texels(name, *indirect) {
                needs.1 |= Access::SHADER_SAMPLED_READ;
            }
            if *indirect && before_is_last_other {
                needs.0 |= Stage::DRAW_INDIRECT;
                needs.1 |= Access::INDIRECT_COMMAND_READ;
            }
            if *on_condition && before_is_last_other {
                needs.0 |= Stage::CONDITIONAL_RENDERING_EXT;
                needs.1 |= Access::CONDITIONAL_RENDERING_READ_EXT;
            }
            needs
        }
        Command::Fill => {
            (Stage::TRANSFER, if wrote { Access::TRANSFER_WRITE } else { Access::NONE })
        }
        Command::Copy => {
            (Stage::TRANSFER, if wrote { Access::TRANSFER_READ } else { Access::NONE })
        }
        Command::Draw if wrote => {
            (Stage::FRAGMENT_SHADER, Access::SHADER_STORAGE_READ | Access::SHADER_SAMPLED_READ)
        }
        Command::Draw => (Stage::NONE, Access::NONE),
    }
}

fn pipeline_of(command: &Command) -> Option<u64> {
    match command {
        Command::Dispatch { pipeline, .. } => Some(*pipeline),
        _ => None,
    }
}

fn name_of(command: &Command) -> &str {
    match command {
        Command::Dispatch { name, .. } => name,
        Command::Barrier(..) => "barrier",
        Command::Fill => "fill",
        Command::Copy => "copy",
        Command::Draw => "draw",
    }
}

/// The first two commands of which the second does not wait for the first, or does not see what it wrote.
fn hazard(commands: &[Command]) -> Option<String> {
    let mut all: Vec<Before> = Vec::new();
    for command in commands {
        if let Command::Barrier((from_stages, from_accesses), (to_stages, to_accesses)) = command {
            for before in &mut all {
                let (stage, access) = leaves(before.command);
                // What waits for it already hands the wait on.
                let chains = from_stages.intersects(before.waits);
                let is_source = from_stages.contains(stage)
                    && (from_accesses.contains(access) || matches!(before.command, Command::Copy));
                if is_source || chains {
                    before.waits |= *to_stages;
                    before.sees |= *to_accesses;
                }
            }
            continue;
        }
        // Whose numbers of workgroups an indirect dispatch reads: those of the pipeline that came before its own.
        let last_other = all
            .iter()
            .rev()
            .filter_map(|before| pipeline_of(before.command))
            .find(|other| Some(*other) != pipeline_of(command));
        for before in &all {
            let pair = (name_of(before.command), name_of(command));
            let both = [pair.0, pair.1];
            // Each has a buffer of its own, but for what the last frame copies and draws from.
            let apart = both.iter().all(|name| ["fill", "copy", "draw"].contains(name))
                && !matches!(pair, ("copy" | "draw", "fill"));
            if INDEPENDENT.contains(&pair) || apart {
                continue;
            }
            let of_args =
                pipeline_of(before.command).is_some() && pipeline_of(before.command) == last_other;
            let (stage, access) = needs(command, before.command, of_args);
            if !before.waits.contains(stage) || !before.sees.contains(access) {
                return Some(format!("{} after {} without a barrier", pair.1, pair.0));
            }
        }
        all.push(Before { command, waits: Stage::NONE, sees: Access::NONE });
    }
    None
}

/// A barrier behind each copy lets the host see it.
fn copies_reach_the_host(commands: &[Command]) -> bool {
    let copies = commands.iter().enumerate().filter(|(_, command)| **command == Command::Copy);
    let after = |at: usize| commands[at..].iter().find(|command| **command != Command::Copy);
    copies.map(|(at, _)| after(at)).all(|next| {
        matches!(next, Some(Command::Barrier((_, from), (stage, to)))
            if from.contains(Access::TRANSFER_WRITE)
                && stage.contains(Stage::HOST)
                && to.contains(Access::HOST_READ))
    })
}

fn is_barrier(command: &Command) -> bool {
    matches!(command, Command::Barrier(..))
}

#[test]
fn every_pass_waits_for_those_before_it() {
    let instance = common::hooks::instance(hook_of);
    let device = Device::open(&instance, common::chosen(&instance)).expect("a device");
    // Few tiles and many drops: several slices of depth. Drops large enough for rays.
    let mut scene = Scene {
        rain: Some(RainSettings {
            count: 20_000,
            half_extent: DVec3::splat(100.0),
            ..RainSettings::default()
        }),
        drops: vec![PlacedDrop::sphere(DVec3::new(0.0, 0.0, -3.0), 1.0)],
        image: ImageSize { width: 64, height: 64 },
        ..Scene::default()
    };
    scene.model.preset = Preset::Fast;
    let white = Environment::constant(Vec3::ONE);
    let plan = plan(&scene, &white, Output::Display).expect("a plan");
    let mut renderer = Renderer::new(&device, &scene, &white, &plan).expect("a renderer");
    // llvmpipe compiles what it dispatches, for no workgroup, too.
    let leaves_out = device.report.driver == "llvmpipe";
    recording().commands.clear();
    renderer.submit(&scene).expect("a frame");
    let first = recording().commands.len();
    scene.camera.target.x += 0.5;
    renderer.submit(&scene).expect("a frame");
    let commands = recording().commands.clone();
    renderer.finish().expect("a report");
    drop(renderer);
    drop(device);
    instance.expect_silence().expect("silence");

    let passes: Vec<&str> =
        commands[first..].iter().filter(|c| !is_barrier(c)).map(name_of).collect();
    println!("{passes:#?}");
    assert!(passes.iter().filter(|name| **name == "gather.comp").count() > 2, "{passes:?}");
    for expected in ["fill", "sky.comp", "blocks.comp", "composite.comp", "draw", "copy"] {
        assert!(passes.contains(&expected), "{expected} is not among {passes:?}");
    }
    for command in &commands {
        if let Command::Dispatch { name, indirect, on_condition, .. } = command {
            assert_eq!(*on_condition, *indirect && leaves_out, "{name}");
        }
    }
    if let Some(hazard) = hazard(&commands) {
        panic!("{hazard}: {commands:#?}");
    }
    assert!(copies_reach_the_host(&commands));

    // The control: each barrier of the second frame is needed by one of the rules.
    for (at, command) in commands.iter().enumerate().skip(first) {
        if is_barrier(command) {
            let mut without = commands.clone();
            without.remove(at);
            assert!(
                hazard(&without).is_some() || !copies_reach_the_host(&without),
                "without barrier {at}, before {:?}, nothing is missed",
                without.get(at).map(name_of)
            );
        }
    }
}
