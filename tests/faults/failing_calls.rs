//! Every Vulkan call that can fail, failing once: a clean error, everything freed, not a word from the
//! validation layer. And a device that is lost.
//!
//! A call that is to fail never reaches the layer, let alone the driver.

use std::ffi::{CStr, c_void};
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering::SeqCst};
use std::sync::{Arc, Mutex, PoisonError};

use ash::vk::{self, Handle as _};
use glam::Vec3;
use raindrops::environment::Environment;
use raindrops::gpu::disk_cache::KeptDevice;
use raindrops::gpu::{Device, Instance};
use raindrops::plan::{Output, plan};
use raindrops::renderer::Renderer;
use raindrops::scene::model::Preset;
use raindrops::scene::{ImageSize, Scene};

/// Failures tried of each preset in an ordinary run; `RAINDROPS_FAULTS=all` tries every one.
const TRIED: usize = 24;

static CALLS: AtomicUsize = AtomicUsize::new(0);
/// The number of the call that fails; 0: none.
static FAILS: AtomicUsize = AtomicUsize::new(0);
/// The call that fails loses the device: every one after it fails as well.
static LOSES: AtomicBool = AtomicBool::new(false);
static LAST: Mutex<&str> = Mutex::new("");
/// A function whose next call fails; empty: none.
static NEXT: Mutex<&str> = Mutex::new("");

/// Whether this call fails, and with what.
fn fault(name: &'static str, waits: bool) -> Option<vk::Result> {
    let mut next = NEXT.lock().unwrap_or_else(PoisonError::into_inner);
    if *next == name {
        *next = "";
        return Some(vk::Result::ERROR_OUT_OF_HOST_MEMORY);
    }
    drop(next);
    let number = CALLS.fetch_add(1, SeqCst) + 1;
    let fails = FAILS.load(SeqCst);
    if LOSES.load(SeqCst) {
        // Only from what the specification lets a lost device return it.
        let is_lost = waits && fails > 0 && number >= fails;
        if is_lost {
            idle();
        }
        return is_lost.then_some(vk::Result::ERROR_DEVICE_LOST);
    }
    if number != fails {
        return None;
    }
    *LAST.lock().unwrap_or_else(PoisonError::into_inner) = name;
    Some(vk::Result::ERROR_OUT_OF_DEVICE_MEMORY)
}

/// Declares a module a function: the real one, and one in its place that may fail before it. With a
/// `null` the named result is cleared, as the specification has it.
macro_rules! fallible {
    ($($name:ident ($($arg:ident: $type:ty),*) $(waits $waits:literal)? $(null $null:ident[$count:ident])?;)*) => {
        $(#[allow(non_snake_case)]
        mod $name {
            use super::*;
            pub static REAL: AtomicUsize = AtomicUsize::new(0);
            pub unsafe extern "system" fn hook($($arg: $type),*) -> vk::Result {
                #[allow(unused_mut, unused_assignments)]
                let mut waits = false;
                $(waits = $waits;)?
                if let Some(result) = fault(stringify!($name), waits) {
                    $(
                        // SAFETY: the caller has room for so many handles.
                        unsafe { std::ptr::write_bytes($null.cast::<u64>(), 0, $count as usize) };
                    )?
                    return result;
                }
                // SAFETY: the driver's function of this name, which has this signature.
                unsafe {
                    let real: unsafe extern "system" fn($($type),*) -> vk::Result =
                        std::mem::transmute(REAL.load(SeqCst));
                    real($($arg),*)
                }
            }
        })*

        /// What stands in for a function, and where its real address belongs.
        fn hook_of(name: &CStr) -> Option<(*const c_void, &'static AtomicUsize)> {
            match name.to_str().ok()? {
                $(stringify!($name) => Some(($name::hook as *const c_void, &$name::REAL)),)*
                _ => None,
            }
        }
    };
}

type In = *const c_void;
type Out = *mut c_void;

fallible! {
    vkCreateDevice(a: vk::PhysicalDevice, b: In, c: In, d: Out);
    vkAllocateMemory(a: vk::Device, b: In, c: In, d: Out);
    vkMapMemory(a: vk::Device, b: u64, c: u64, d: u64, e: u32, f: Out);
    vkBindBufferMemory(a: vk::Device, b: u64, c: u64, d: u64);
    vkBindImageMemory(a: vk::Device, b: u64, c: u64, d: u64);
    vkCreateBuffer(a: vk::Device, b: In, c: In, d: Out);
    vkCreateImage(a: vk::Device, b: In, c: In, d: Out);
    vkCreateImageView(a: vk::Device, b: In, c: In, d: Out);
    vkCreateSampler(a: vk::Device, b: In, c: In, d: Out);
    vkCreateDescriptorSetLayout(a: vk::Device, b: In, c: In, d: Out);
    vkCreateDescriptorPool(a: vk::Device, b: In, c: In, d: Out);
    vkCreatePipelineLayout(a: vk::Device, b: In, c: In, d: Out);
    vkCreatePipelineCache(a: vk::Device, b: In, c: In, d: Out);
    vkGetPipelineCacheData(a: vk::Device, b: u64, c: Out, d: Out);
    vkCreateShaderModule(a: vk::Device, b: In, c: In, d: Out);
    vkCreateCommandPool(a: vk::Device, b: In, c: In, d: Out);
    vkCreateSemaphore(a: vk::Device, b: In, c: In, d: Out);
    vkCreateQueryPool(a: vk::Device, b: In, c: In, d: Out);
    vkAllocateDescriptorSets(a: vk::Device, b: In, c: Out);
    vkAllocateCommandBuffers(a: vk::Device, b: In, c: Out);
    vkCreateComputePipelines(a: vk::Device, b: u64, n: u32, d: In, e: In, f: Out) null f[n];
    vkCreateGraphicsPipelines(a: vk::Device, b: u64, n: u32, d: In, e: In, f: Out) null f[n];
    vkBeginCommandBuffer(a: vk::CommandBuffer, b: In);
    vkEndCommandBuffer(a: vk::CommandBuffer);
    vkResetCommandPool(a: vk::Device, b: u64, c: u32);
    vkQueueSubmit2(a: vk::Queue, b: u32, c: In, d: u64) waits true;
    vkWaitSemaphores(a: vk::Device, b: In, c: u64) waits true;
    vkDeviceWaitIdle(a: vk::Device) waits true;
    vkGetQueryPoolResults(a: vk::Device, b: u64, c: u32, d: u32, e: usize, f: Out, g: u64, h: u32) waits true;
}

/// Waits for the device, which is not truly lost, before anything is freed.
fn idle() {
    let real = vkDeviceWaitIdle::REAL.load(SeqCst);
    // SAFETY: the driver's function, and the device whose functions were asked for last.
    unsafe {
        let wait: vk::PFN_vkDeviceWaitIdle = std::mem::transmute(real);
        let _ = wait(vk::Device::from_raw(crate::common::hooks::DEVICE.load(SeqCst)));
    }
}

/// An instance under validation whose devices' functions can fail.
fn instance() -> Arc<Instance> {
    crate::common::hooks::instance(hook_of)
}

fn scene(preset: Preset) -> Scene {
    let mut scene = Scene::default();
    scene.model.preset = preset;
    scene.model.mask_size = 4;
    scene.rain.get_or_insert_default().count = 200;
    scene.image = ImageSize { width: 16, height: 16 };
    scene
}

/// All that a command does with a device, and everything freed again.
fn work(instance: &Arc<Instance>, preset: Preset) -> raindrops::Result<()> {
    let folder = tempfile::tempdir().expect("a folder");
    let path = Some(folder.path().to_path_buf());
    let device = KeptDevice::open(instance, crate::common::chosen(instance), path, |_| ())?;
    let outcome = frames(&device, preset);
    assert_eq!(Arc::strong_count(&device), 1, "something outlives its owner");
    outcome
}

fn frames(device: &Arc<Device>, preset: Preset) -> raindrops::Result<()> {
    let scene = scene(preset);
    let environment = Environment::constant(Vec3::ONE);
    let plan = plan(&scene, &environment, Output::Display)?;
    let mut renderer = Renderer::new(device, &scene, &environment, &plan)?;
    for _ in 0..3 {
        renderer.submit(&scene)?;
    }
    renderer.finish()?;
    renderer.read_radiance()?;
    renderer.read_display()?;
    Ok(())
}

/// Runs the work with its `number`th fallible call failing.
fn with_fault(instance: &Arc<Instance>, preset: Preset, number: usize) -> raindrops::Result<()> {
    CALLS.store(0, SeqCst);
    FAILS.store(number, SeqCst);
    let outcome = work(instance, preset);
    FAILS.store(0, SeqCst);
    outcome
}

#[test]
fn every_call_that_can_fail_fails_cleanly() {
    // The counters are the process's, too.
    let _alone = crate::common::layer::alone();
    LOSES.store(false, SeqCst);
    let instance = instance();
    let all = std::env::var("RAINDROPS_FAULTS").is_ok_and(|value| value == "all");
    for preset in [Preset::Paper, Preset::Fast] {
        with_fault(&instance, preset, 0).expect("without a fault all is well");
        let calls = CALLS.load(SeqCst);
        assert!(calls > 100, "only {calls} calls seen");
        let step = if all { 1 } else { calls.div_ceil(TRIED) };
        let (mut refused, mut survived) = (0, Vec::new());
        for number in (1..=calls).step_by(step) {
            let outcome = with_fault(&instance, preset, number);
            let name = *LAST.lock().unwrap_or_else(PoisonError::into_inner);
            match outcome {
                Err(error) => {
                    let line = error.to_string();
                    assert!(!line.contains('\n') && line.len() < 300, "{name}: {line}");
                    refused += 1;
                }
                // What may fail without harm: a wait while all is torn down, a cache.
                Ok(()) => survived.push(name),
            }
            instance.expect_silence().unwrap_or_else(|e| panic!("{name}, call {number}: {e}"));
        }
        println!("{preset}: of {calls} calls {refused} failed cleanly, without harm: {survived:?}");
        let harmless = [
            "vkDeviceWaitIdle",
            "vkWaitSemaphores",
            "vkGetPipelineCacheData",
            "vkCreatePipelineCache",
        ];
        assert!(survived.iter().all(|name| harmless.contains(name)), "{survived:?}");
    }
}

#[test]
fn a_lost_device_is_an_error_and_frees_everything() {
    let _alone = crate::common::layer::alone();
    let instance = instance();
    LOSES.store(false, SeqCst);
    with_fault(&instance, Preset::Fast, 0).expect("without a fault all is well");
    let calls = CALLS.load(SeqCst);
    LOSES.store(true, SeqCst);
    let step = calls.div_ceil(8);
    for number in (1..calls).step_by(step) {
        let Err(error) = with_fault(&instance, Preset::Fast, number) else {
            panic!("call {number} of {calls} lost the device, and all went well")
        };
        let line = error.to_string();
        println!("{line}");
        assert!(line.contains("lost") && !line.contains('\n'), "{line}");
    }
    LOSES.store(false, SeqCst);
    instance.expect_silence().expect("nothing was freed in use");
}

/// Commands that are recorded and thrown away leave nothing behind: no sky of a view that was never drawn, no
/// timestamps that are waited for, no report.
#[test]
fn a_frame_that_is_not_submitted_changes_nothing() {
    let _alone = crate::common::layer::alone();
    LOSES.store(false, SeqCst);
    let instance = instance();
    let device = Device::open(&instance, crate::common::chosen(&instance)).expect("a device");
    let environment = crate::common::painted(64, |d| (2.0 * d).as_vec3().exp());
    for preset in [Preset::Fast, Preset::Paper] {
        let first = scene(preset);
        let mut turned = first.clone();
        turned.camera.target = glam::DVec3::new(1.0, 0.3, -0.5);
        let plan = plan(&first, &environment, Output::Display).expect("a plan");
        let make = || Renderer::new(&device, &first, &environment, &plan).expect("a renderer");
        let mut fresh = make();
        fresh.submit(&turned).expect("a frame");
        let expected = fresh.read_radiance().expect("radiance");
        let mut renderer = make();
        for _ in 0..2 {
            renderer.submit(&first).expect("a frame");
            let report = renderer.finish().expect("a report");
            *NEXT.lock().unwrap_or_else(PoisonError::into_inner) = "vkQueueSubmit2";
            assert!(renderer.submit(&turned).is_err(), "{preset}: it was submitted");
            let again = renderer.finish().expect("a report");
            assert_eq!(again.counts, report.counts, "{preset}: the last frame's report stays");
            renderer.submit(&turned).expect("a frame");
            assert!(renderer.read_radiance().expect("radiance") == expected, "{preset}");
        }
        // The control.
        renderer.submit(&first).expect("a frame");
        assert!(renderer.read_radiance().expect("radiance") != expected);
    }
    drop(device);
    instance.expect_silence().expect("silence");
}

/// A driver is there, but not its card: the same advice as without a driver.
#[cfg(target_os = "linux")]
#[test]
fn a_driver_without_its_card_gives_advice() {
    let folder = crate::common::folder();
    let at = |name: &str| folder.path().join(name);
    let mut rustc = std::process::Command::new("rustc");
    rustc.args(["--edition", "2024", "--crate-type", "cdylib", "-o"]).arg(at("cardless.so"));
    rustc.arg(concat!(env!("CARGO_MANIFEST_DIR"), "/tests/drivers/cardless.rs"));
    assert!(rustc.status().expect("rustc").success(), "the driver does not compile");
    let manifest = serde_json::json!({ "file_format_version": "1.0.0",
        "ICD": { "library_path": "./cardless.so", "api_version": "1.3.0" } });
    std::fs::write(at("cardless.json"), manifest.to_string()).expect("a manifest");
    for arguments in [&["devices"][..], &["render", "-o", "a.png"], &["bench", "--drops", "9"]] {
        let mut command = crate::common::raindrops();
        command.current_dir(folder.path()).args(arguments);
        command.env("VK_DRIVER_FILES", at("cardless.json"));
        command.env("VK_ICD_FILENAMES", at("cardless.json"));
        let line = crate::common::said::failure(&crate::common::outcome(&mut command), 2);
        assert!(line.contains("no Vulkan device") && line.contains("VK_DRIVER_FILES"), "{line}");
        for words in ["vkEnumeratePhysicalDevices", "mesa-vulkan-drivers", "scripts/setup.sh"] {
            assert!(line.contains(words), "{words}: {line}");
        }
    }
    assert!(!at("a.png").exists());
}

/// A driver over another interface, such as MoltenVK, says so in its manifest, and the loader hides it from whoever does not
/// ask: here the CPU's, whose manifest says so too.
#[test]
fn portability_drivers_are_found() {
    let folders = ["/usr/share/vulkan/icd.d", "/etc/vulkan/icd.d", ".setup/lavapipe-backports"];
    let files = folders.iter().filter_map(|folder| std::fs::read_dir(folder).ok()).flatten();
    let paths = files.filter_map(|file| Some(file.ok()?.path()));
    let of_cpu = |path: &std::path::PathBuf| path.to_string_lossy().contains("lvp_icd");
    let path = paths.into_iter().find(of_cpu).expect("lavapipe's manifest");
    let text = std::fs::read_to_string(path).expect("a manifest");
    let mut manifest: serde_json::Value = serde_json::from_str(&text).expect("JSON");
    manifest["ICD"]["is_portability_driver"] = true.into();
    manifest["file_format_version"] = "1.0.1".into();
    let folder = crate::common::folder();
    let at = |name: &str| folder.path().join(name);
    std::fs::write(at("portable.json"), manifest.to_string()).expect("a manifest");
    for arguments in [&["devices"][..], &["render", "--size", "64x48", "-o", "a.png"]] {
        let mut command = crate::common::raindrops();
        command.current_dir(folder.path()).args(arguments);
        command.env("VK_DRIVER_FILES", at("portable.json"));
        command.env("VK_ICD_FILENAMES", at("portable.json"));
        let ran = crate::common::outcome(&mut command);
        assert!(ran.status.success(), "{}", String::from_utf8_lossy(&ran.stderr));
    }
    assert!(at("a.png").exists());
}
