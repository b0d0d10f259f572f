//! A frame records and does nothing else: every call into the driver is counted.

use std::ffi::{CStr, c_void};
use std::sync::atomic::{AtomicUsize, Ordering::SeqCst};

use raindrops::device::{Device, requirements};
use raindrops::renderer::{FrameInput, ViewInfo};
use raindrops::scene::model::Preset;

use crate::common;
use crate::embedded::{Embedded, scene, wanted};
use crate::host::Host;

/// Calls that a frame must not make, and its host must not see; each with a counter.
macro_rules! counted {
    ($($name:ident)*) => {
        $(#[allow(non_snake_case)]
        mod $name {
            use super::*;
            pub static REAL: AtomicUsize = AtomicUsize::new(0);
            pub unsafe extern "system" fn hook(a: usize, b: usize, c: usize, d: usize, e: usize, f: usize) -> usize {
                CALLS.fetch_add(1, SeqCst);
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
                _ => None,
            }
        }
    };
}

static CALLS: AtomicUsize = AtomicUsize::new(0);

counted! {
    vkQueueSubmit vkQueueSubmit2 vkQueueWaitIdle vkDeviceWaitIdle vkGetDeviceQueue vkGetDeviceQueue2
    vkWaitForFences vkWaitSemaphores vkCreateFence vkCreateSemaphore vkGetSemaphoreCounterValue
    vkAllocateMemory vkFreeMemory vkMapMemory vkCreateBuffer vkCreateBufferView vkCreateImage vkCreateImageView
    vkCreateSampler vkCreateShaderModule vkCreateComputePipelines vkCreateGraphicsPipelines vkCreatePipelineLayout
    vkCreateDescriptorSetLayout vkCreateDescriptorPool vkAllocateDescriptorSets vkUpdateDescriptorSets
    vkCreateQueryPool vkCreateCommandPool vkAllocateCommandBuffers vkBeginCommandBuffer vkEndCommandBuffer
    vkResetCommandPool vkDestroyBuffer vkDestroyImage vkDestroyDevice
}

#[test]
fn a_frame_records_and_does_nothing_else() {
    let entry = common::hooks::entry(hook_of);
    let host = Host::new(entry, &requirements(Preset::Fast), true, wanted().as_deref());
    // SAFETY: as in `on_host`.
    let device = unsafe { Device::import(host.lent(), &requirements(Preset::Fast)) };
    let device = device.expect("a device");
    let mut scene = scene(Preset::Fast);
    let before_set_up = CALLS.load(SeqCst);
    let mut embedded = Embedded::new(&host, &device, &scene, &ViewInfo::default());
    // The control: set-up makes many.
    assert!(CALLS.load(SeqCst) - before_set_up > 100, "{}", CALLS.load(SeqCst) - before_set_up);
    let fences = [host.fence(), host.fence()];
    for number in 0..6 {
        let slot = number % 2;
        scene.time += 0.01;
        scene.camera.target.x += 0.1;
        let (commands, output) = (embedded.commands[slot], embedded.output());
        if number > 1 {
            host.wait(fences[slot]);
        }
        let before = CALLS.load(SeqCst);
        // SAFETY: the slot's fence was signalled, or it was never recorded.
        let report = unsafe { embedded.view.retired(slot) }.expect("a report");
        assert_eq!(CALLS.load(SeqCst), before, "frame {number} retired");
        assert_eq!(report.is_some(), number > 1);
        host.begin(commands);
        let before = CALLS.load(SeqCst);
        let input = FrameInput::new(&scene, output);
        // SAFETY: the image is as described; the frames are submitted in order.
        unsafe { embedded.view.record(commands, slot, &input) }.expect("a recording");
        assert_eq!(CALLS.load(SeqCst), before, "frame {number}");
        host.end(commands);
        host.submit(commands, fences[slot]);
    }
    for fence in fences {
        host.wait(fence);
        host.destroy_fence(fence);
    }
    // Slots that have not retired keep what they use, and dropping waits for nothing.
    let waits = [&vkDeviceWaitIdle::REAL, &vkDestroyDevice::REAL].map(|real| real.load(SeqCst));
    assert!(waits.iter().all(|real| *real != 0));
    host.destroy_image(embedded.target);
    drop(embedded.view);
    drop(device);
    host.once(|_| ());
    assert_eq!(host.messages(), Vec::<String>::new());
}
