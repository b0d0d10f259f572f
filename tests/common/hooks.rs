//! Functions of Vulkan replaced where a program gets them, in `vkGetInstanceProcAddr` and
//! `vkGetDeviceProcAddr`: a call that is replaced reaches the layer, and the driver, only through its stand-in.

use std::ffi::{CStr, c_char, c_void};
use std::sync::atomic::{AtomicU64, AtomicUsize, Ordering::SeqCst};
use std::sync::{Arc, OnceLock};

use ash::vk::{self, Handle as _};
use raindrops::gpu::{Instance, Validation};

/// What stands in for a function of a name, and where the real one's address belongs.
pub type StandIn = fn(&CStr) -> Option<(*const c_void, &'static AtomicUsize)>;

/// The device whose functions were asked for last.
pub static DEVICE: AtomicU64 = AtomicU64::new(0);
static REAL_INSTANCE_PROC: AtomicUsize = AtomicUsize::new(0);
static REAL_DEVICE_PROC: AtomicUsize = AtomicUsize::new(0);
static STAND_IN: OnceLock<StandIn> = OnceLock::new();

type Function = unsafe extern "system" fn();

/// Puts the stand-in where there is one.
fn replace(name: &CStr, real: Option<Function>) -> Option<Function> {
    let stand_in = STAND_IN.get().and_then(|of| of(name));
    let (Some(function), Some((hook, place))) = (real, stand_in) else { return real };
    place.store(function as usize, SeqCst);
    // SAFETY: a function pointer, to be cast to its own signature by whoever asked for it.
    Some(unsafe { std::mem::transmute::<*const c_void, Function>(hook) })
}

unsafe extern "system" fn device_proc(device: vk::Device, name: *const c_char) -> Option<Function> {
    DEVICE.store(device.as_raw(), SeqCst);
    // SAFETY: the loader's own function; the caller passes a device and a name.
    unsafe {
        let real: vk::PFN_vkGetDeviceProcAddr = std::mem::transmute(REAL_DEVICE_PROC.load(SeqCst));
        replace(CStr::from_ptr(name), real(device, name))
    }
}

unsafe extern "system" fn instance_proc(
    instance: vk::Instance,
    name: *const c_char,
) -> Option<Function> {
    // SAFETY: the loader's own function; the caller passes an instance and a name.
    unsafe {
        let real: vk::PFN_vkGetInstanceProcAddr =
            std::mem::transmute(REAL_INSTANCE_PROC.load(SeqCst));
        let found = real(instance, name);
        match CStr::from_ptr(name).to_bytes() {
            b"vkGetDeviceProcAddr" => {
                let function = found?;
                REAL_DEVICE_PROC.store(function as usize, SeqCst);
                let hook: vk::PFN_vkGetDeviceProcAddr = device_proc;
                Some(std::mem::transmute::<vk::PFN_vkGetDeviceProcAddr, Function>(hook))
            }
            b"vkCreateDevice" => replace(c"vkCreateDevice", found),
            _ => found,
        }
    }
}

/// A Vulkan whose devices have the stand-ins; one set of them a process.
pub fn entry(stand_in: StandIn) -> ash::Entry {
    STAND_IN.get_or_init(|| stand_in);
    // SAFETY: the system's loader.
    let real = unsafe { ash::Entry::load() }.expect("Vulkan");
    REAL_INSTANCE_PROC.store(real.static_fn().get_instance_proc_addr as usize, SeqCst);
    // Unloaded with the process: functions of it stand in statics.
    std::mem::forget(real);
    let functions = ash::StaticFn { get_instance_proc_addr: instance_proc };
    // SAFETY: it forwards to the loader's function.
    unsafe { ash::Entry::from_static_fn(functions) }
}

/// An instance under validation of that Vulkan.
pub fn instance(stand_in: StandIn) -> Arc<Instance> {
    Instance::with_entry(entry(stand_in), Validation::On).expect("an instance")
}
