//! A frame records and does nothing else: every call into the driver is counted.

use std::ffi::{CStr, c_void};
use std::sync::atomic::{AtomicUsize, Ordering::SeqCst};
use std::sync::{Arc, Mutex};

use ash::vk;
use raindrops::device::{Device, HostDevice, HostImage, ImageState, requirements};
use raindrops::plan::{Output, plan};
use raindrops::renderer::{
    FrameInput, HostEnvironment, HostMotion, Lighting, LiveInfo, RainField, View,
};
use raindrops::scene::model::Preset;

use crate::common;
use crate::embedded::{Embedded, environment, scene, wanted};
use crate::host::Host;
use crate::motion_depth::{Filled, asked};

/// Calls that a frame must not make, and its host must not see; each with a counter.
macro_rules! counted {
    ($($name:ident)*) => {
        $(#[allow(non_snake_case)]
        mod $name {
            use super::*;
            pub static REAL: AtomicUsize = AtomicUsize::new(0);
            pub static COUNT: AtomicUsize = AtomicUsize::new(0);
            pub unsafe extern "system" fn hook(a: usize, b: usize, c: usize, d: usize, e: usize, f: usize) -> usize {
                COUNT.fetch_add(1, SeqCst);
                // SAFETY: the layer's function of this name: its arguments are six words at most, none of them a float.
                unsafe {
                    let real: unsafe extern "system" fn(usize, usize, usize, usize, usize, usize) -> usize =
                        std::mem::transmute(REAL.load(SeqCst));
                    real(a, b, c, d, e, f)
                }
            }
        })*

        fn hook_of(name: &CStr) -> Option<(*const c_void, &'static AtomicUsize)> {
            match name.to_str().ok()? {
                $(stringify!($name) => Some(($name::hook as *const c_void, &$name::REAL)),)*
                "vkCreatePipelineCache" => Some((create_pipeline_cache as *const c_void, &REAL_PIPELINE_CACHE)),
                _ => None,
            }
        }

        /// Calls so far, those apart that a frame may make.
        fn calls() -> usize {
            let all: usize = [$(&$name::COUNT),*].iter().map(|count| count.load(SeqCst)).sum();
            all - allowed().iter().sum::<usize>()
        }
    };
}

/// Copies, of which a frame makes those of its counts, and descriptor sets written for a host's images.
fn allowed() -> [usize; 2] {
    [&vkCmdCopyBuffer::COUNT, &vkUpdateDescriptorSets::COUNT].map(|count| count.load(SeqCst))
}

counted! {
    vkQueueSubmit vkQueueSubmit2 vkQueueWaitIdle vkDeviceWaitIdle vkGetDeviceQueue vkGetDeviceQueue2
    vkWaitForFences vkWaitSemaphores vkCreateFence vkCreateSemaphore vkGetSemaphoreCounterValue
    vkAllocateMemory vkFreeMemory vkMapMemory vkCreateBuffer vkCreateBufferView vkCreateImage vkCreateImageView
    vkCreateSampler vkCreateShaderModule vkCreateComputePipelines vkCreateGraphicsPipelines vkCreatePipelineLayout
    vkCreateDescriptorSetLayout vkCreateDescriptorPool vkAllocateDescriptorSets vkUpdateDescriptorSets
    vkCreateQueryPool vkCreateCommandPool vkAllocateCommandBuffers vkBeginCommandBuffer vkEndCommandBuffer
    vkResetCommandPool vkDestroyBuffer vkDestroyImage vkDestroyDevice
    vkCmdCopyBuffer vkCmdCopyImage vkCmdCopyImageToBuffer vkCmdBlitImage
}

/// What pipelines began with when they were made last.
static KEPT: Mutex<Vec<u8>> = Mutex::new(Vec::new());
static REAL_PIPELINE_CACHE: AtomicUsize = AtomicUsize::new(0);

unsafe extern "system" fn create_pipeline_cache(
    device: vk::Device,
    info: *const vk::PipelineCacheCreateInfo<'_>,
    allocator: *const vk::AllocationCallbacks<'_>,
    cache: *mut vk::PipelineCache,
) -> vk::Result {
    // SAFETY: the layer's function, called as it was to be.
    unsafe {
        let (data, bytes) = ((*info).p_initial_data.cast::<u8>(), (*info).initial_data_size);
        let kept = if bytes == 0 { &[] } else { std::slice::from_raw_parts(data, bytes) };
        *KEPT.lock().expect("no panic") = kept.to_vec();
        let real: vk::PFN_vkCreatePipelineCache =
            std::mem::transmute(REAL_PIPELINE_CACHE.load(SeqCst));
        real(device, info, allocator, cache)
    }
}

/// Frames that renew their light.
const RENEWED: [bool; 6] = [true, false, true, false, false, false];

#[test]
fn a_frame_records_and_does_nothing_else() {
    let _alone = crate::common::layer::alone();
    let entry = common::hooks::entry(hook_of);
    let host = Host::new(entry, &requirements(Preset::Fast), true, wanted().as_deref());
    // SAFETY: as in `on_host`.
    let device = unsafe { Device::import(host.lent(), &requirements(Preset::Fast)) };
    let pipelines = device.expect("a device").pipelines().expect("its header at least");
    let lent = HostDevice { pipelines: pipelines.clone(), ..host.lent() };
    // SAFETY: as above.
    let device = unsafe { Device::import(lent, &requirements(Preset::Fast)) }.expect("a device");
    assert_eq!(*KEPT.lock().expect("no panic"), pipelines);
    let mut scene = scene(Preset::Fast);
    let before_set_up = calls();
    let mut embedded = Embedded::new(&host, &device, &scene, &asked());
    // Its light is renewed in some frames.
    let live = LiveInfo { height: 32, cube: false, ..LiveInfo::default() };
    let lighting = Arc::new(Lighting::live(&device, live).expect("light"));
    let plan = plan(&scene, &environment(), Output::Radiance).expect("a plan");
    let field = Arc::new(RainField::new(&device, &scene));
    embedded.view = View::new(&lighting, &field, &scene, &plan, &asked()).expect("a view");
    let usage = vk::ImageUsageFlags::SAMPLED | vk::ImageUsageFlags::TRANSFER_DST;
    let around = host.image(vk::Format::R32G32B32A32_SFLOAT, (64, 32), 1, usage);
    host.write(&around, bytemuck::cast_slice(&[0.5f32; 64 * 32 * 4]));
    let seen = HostImage {
        entry: ImageState::SAMPLED,
        exit: ImageState::SAMPLED,
        ..HostImage::color(around.image, around.view, around.format, around.size)
    };
    let motion = Filled::new(&host, vk::Format::R32G32_SFLOAT, &[0.0; 2]);
    let depth = Filled::new(&host, vk::Format::R32_SFLOAT, &[f32::INFINITY]);
    let mut camera = scene.camera;
    // The control: set-up makes many.
    assert!(calls() - before_set_up > 100, "{}", calls() - before_set_up);
    let page = include_str!("../../docs/embedding-more.md");
    let rain = plan.passes.iter().map(|(name, _)| *name);
    let every_pass: Vec<&str> =
        std::iter::once("environment").chain(rain).chain(["output", "motion and depth"]).collect();
    let fences = [host.fence(), host.fence()];
    for number in 0..6 {
        let slot = number % 2;
        scene.time += 0.01;
        scene.camera.target.x += 0.1;
        let (commands, output) = (embedded.commands[slot], embedded.output());
        if number > 1 {
            host.wait(fences[slot]);
        }
        let before = calls();
        // SAFETY: the slot's fence was signalled, or it was never recorded.
        let report = unsafe { embedded.view.retired(slot) }.expect("a report");
        assert_eq!(calls(), before, "frame {number} retired");
        assert_eq!(report.is_some(), number > 1);
        if let Some(report) = report {
            // That of the frame before the last one.
            let passes: Vec<&str> = report.passes_ms.iter().map(|(name, _)| *name).collect();
            let renewal = if RENEWED[number - 2] { 0 } else { 1 };
            assert_eq!(passes, every_pass[renewal..], "frame {}", number - 2);
            let unknown = passes.iter().find(|name| !page.contains(&format!("`{name}`")));
            assert_eq!(unknown, None, "docs/embedding-more.md names the passes");
        }
        host.begin(commands);
        let (before, [copies, sets]) = (calls(), allowed());
        // Frames follow one another on the images.
        let follows = |image: HostImage| HostImage {
            entry: if number == 0 { image.entry } else { image.exit },
            ..image
        };
        let since = HostMotion::since(camera, scene.time - 0.01, follows(motion.image()));
        let mut input =
            FrameInput::new(&scene, output).moved(since).nearest(follows(depth.image()));
        let is_renewed = RENEWED[number];
        input.environment = is_renewed.then(|| HostEnvironment::new(seen));
        camera = scene.camera;
        // SAFETY: the image is as described; the frames are submitted in order.
        unsafe { embedded.view.record(commands, slot, &input) }.expect("a recording");
        assert_eq!(calls(), before, "frame {number}");
        // A renewed environment is not read back: the same counts are copied, and no image is.
        let [copied, written] = allowed();
        assert_eq!((copied - copies, written - sets), (3, is_renewed.into()), "frame {number}");
        host.end(commands);
        host.submit(commands, fences[slot]);
    }
    for fence in fences {
        host.wait(fence);
        host.destroy_fence(fence);
    }
    // Slots that have not retired keep what they use; dropping waits for nothing, and leaves the device, which was never
    // idled.
    let idled = || [&vkDeviceWaitIdle::COUNT, &vkQueueWaitIdle::COUNT].map(|n| n.load(SeqCst));
    let waited = || [&vkWaitForFences::COUNT, &vkWaitSemaphores::COUNT].map(|n| n.load(SeqCst));
    let (before, destroyed) = (waited(), vkDestroyDevice::COUNT.load(SeqCst));
    assert!(
        [&vkDeviceWaitIdle::REAL, &vkQueueWaitIdle::REAL, &vkDestroyDevice::REAL]
            .into_iter()
            .all(|real| real.load(SeqCst) != 0)
    );
    let images = [embedded.target, motion.0, depth.0, around];
    images.into_iter().for_each(|image| host.destroy_image(image));
    drop((embedded.view, lighting, field));
    drop(device);
    assert_eq!((idled(), waited()), ([0; 2], before), "it waited");
    assert_eq!(vkDestroyDevice::COUNT.load(SeqCst), destroyed, "the host's device");
    host.once(|_| ());
    assert_eq!(host.messages(), Vec::<String>::new());
}
