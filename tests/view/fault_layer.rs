//! A Vulkan layer between the program and its driver that makes a call fail when told to: the file
//! that `RAINDROPS_FAULT` names holds a function and what it is to return, and is gone once it has.
//! A call that fails never reaches what is below. After the device is lost all of it is lost, until
//! another is made. For surface capabilities, 0 is a surface without an area. If the file holds `hold` and
//! a function, calls of it wait until the file is gone, and a file with the ending `held` says that one does.
//!
//! A shared library for the loader, compiled by `faults.rs`. It is unsafe throughout: what it is given
//! is the loader's, whose word on it is taken, and every function has the signature of its name.

use std::ffi::{CStr, c_char, c_void};
use std::mem::transmute;
use std::path::PathBuf;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering::SeqCst};
use std::time::Duration;

type Pointer = *mut c_void;
type Function = Option<unsafe extern "system" fn()>;
type GetFunction = unsafe extern "system" fn(Pointer, *const c_char) -> Function;

const DEVICE_LOST: i32 = -4;
/// `VkStructureType` of what the loader adds to the information for an instance and a device.
const OF_INSTANCE: i32 = 47;
const OF_DEVICE: i32 = 48;

/// The chain by which a layer finds the next one, from `vk_layer.h`.
#[repr(C)]
struct Link {
    next: *mut Link,
    instance_function: GetFunction,
    device_function: GetFunction,
}

#[repr(C)]
struct Chain {
    kind: i32,
    next: *mut Chain,
    content: i32,
    link: *mut Link,
}

#[repr(C)]
pub struct Interface {
    kind: i32,
    next: Pointer,
    version: u32,
    instance_function: GetFunction,
    device_function: GetFunction,
    physical_function: Pointer,
}

static INSTANCE_FUNCTION: AtomicUsize = AtomicUsize::new(0);
static DEVICE_FUNCTION: AtomicUsize = AtomicUsize::new(0);
static INSTANCE: AtomicUsize = AtomicUsize::new(0);
static DEVICE: AtomicUsize = AtomicUsize::new(0);
static LOST: AtomicBool = AtomicBool::new(false);

/// What this call is to return instead of being made.
fn fault(name: &str) -> Option<i32> {
    let path = std::env::var_os("RAINDROPS_FAULT")?;
    let told = std::fs::read_to_string(&path).ok()?;
    let result = told.strip_prefix(name)?.trim().parse().ok()?;
    std::fs::remove_file(path).ok()?;
    Some(result)
}

/// Keeps this call waiting as long as it is told to.
fn hold(name: &str) {
    let Some(path) = std::env::var_os("RAINDROPS_FAULT").map(PathBuf::from) else { return };
    let is_told = || {
        let told = std::fs::read_to_string(&path);
        told.is_ok_and(|told| told.strip_prefix("hold ").is_some_and(|held| held.trim() == name))
    };
    if is_told() {
        let _ = std::fs::write(path.with_extension("held"), "");
        while is_told() {
            std::thread::sleep(Duration::from_millis(2));
        }
    }
}

/// Like [`fault`], for a call of the device.
fn device_fault(name: &str) -> Option<i32> {
    if LOST.load(SeqCst) {
        return Some(DEVICE_LOST);
    }
    let result = fault(name)?;
    if result == DEVICE_LOST {
        // It is not truly lost, and is not to work on what will be freed.
        unsafe {
            let device = DEVICE.load(SeqCst) as Pointer;
            let wait: unsafe extern "system" fn(Pointer) -> i32 =
                transmute(next(&DEVICE_FUNCTION, device, c"vkDeviceWaitIdle"));
            wait(device);
        }
        LOST.store(true, SeqCst);
    }
    Some(result)
}

unsafe fn next(find: &AtomicUsize, of: Pointer, name: &CStr) -> Function {
    unsafe { transmute::<usize, GetFunction>(find.load(SeqCst))(of, name.as_ptr()) }
}

/// The link that the loader has left in the chain of `info`, which is moved on for the next layer.
unsafe fn take_link(info: *const c_void, kind: i32) -> *mut Link {
    unsafe {
        let mut chain = (*info.cast::<Chain>()).next;
        while (*chain).kind != kind || (*chain).content != 0 {
            chain = (*chain).next;
        }
        let link = (*chain).link;
        (*chain).link = (*link).next;
        link
    }
}

unsafe extern "system" fn create_instance(
    info: Pointer,
    memory: Pointer,
    out: *mut Pointer,
) -> i32 {
    unsafe {
        let link = take_link(info, OF_INSTANCE);
        INSTANCE_FUNCTION.store((*link).instance_function as usize, SeqCst);
        let real: unsafe extern "system" fn(Pointer, Pointer, *mut Pointer) -> i32 =
            transmute(next(&INSTANCE_FUNCTION, std::ptr::null_mut(), c"vkCreateInstance"));
        let result = real(info, memory, out);
        INSTANCE.store(*out as usize, SeqCst);
        result
    }
}

unsafe extern "system" fn create_device(
    physical: Pointer,
    info: Pointer,
    memory: Pointer,
    out: *mut Pointer,
) -> i32 {
    unsafe {
        let link = take_link(info, OF_DEVICE);
        DEVICE_FUNCTION.store((*link).device_function as usize, SeqCst);
        let instance = INSTANCE.load(SeqCst) as Pointer;
        let real: unsafe extern "system" fn(Pointer, Pointer, Pointer, *mut Pointer) -> i32 =
            transmute(next(&INSTANCE_FUNCTION, instance, c"vkCreateDevice"));
        let result = real(physical, info, memory, out);
        // Only one can be lost: the first, and after it the one that takes its place.
        if DEVICE.load(SeqCst) == 0 || LOST.swap(false, SeqCst) {
            DEVICE.store(*out as usize, SeqCst);
        }
        result
    }
}

unsafe extern "system" fn surface_capabilities(
    physical: Pointer,
    surface: u64,
    out: *mut u32,
) -> i32 {
    unsafe {
        let instance = INSTANCE.load(SeqCst) as Pointer;
        let name = c"vkGetPhysicalDeviceSurfaceCapabilitiesKHR";
        let real: unsafe extern "system" fn(Pointer, u64, *mut u32) -> i32 =
            transmute(next(&INSTANCE_FUNCTION, instance, name));
        let result = real(physical, surface, out);
        if let Some(fault) = fault("vkGetPhysicalDeviceSurfaceCapabilitiesKHR") {
            // After the numbers of images, the current width and height.
            out.add(2).write(0);
            out.add(3).write(0);
            return fault;
        }
        result
    }
}

/// Functions of a device that may fail.
macro_rules! fallible {
    ($($name:ident($($arg:ident: $type:ty),*);)*) => {
        $(#[allow(non_snake_case)]
        mod $name {
            use super::*;
            pub static REAL: AtomicUsize = AtomicUsize::new(0);
            pub unsafe extern "system" fn hook($($arg: $type),*) -> i32 {
                hold(stringify!($name));
                if let Some(result) = device_fault(stringify!($name)) {
                    return result;
                }
                unsafe {
                    let real: unsafe extern "system" fn($($type),*) -> i32 =
                        transmute(REAL.load(SeqCst));
                    real($($arg),*)
                }
            }
        })*

        unsafe extern "system" fn device_function(device: Pointer, name: *const c_char) -> Function {
            unsafe {
                let name = CStr::from_ptr(name);
                let real = next(&DEVICE_FUNCTION, device, name)?;
                match name.to_str() {
                    $(Ok(stringify!($name)) => {
                        $name::REAL.store(real as usize, SeqCst);
                        transmute($name::hook as *const c_void)
                    })*
                    _ => Some(real),
                }
            }
        }
    };
}

fallible! {
    vkQueueSubmit2(a: Pointer, b: u32, c: Pointer, d: u64);
    vkQueuePresentKHR(a: Pointer, b: Pointer);
    vkAcquireNextImageKHR(a: Pointer, b: u64, c: u64, d: u64, e: u64, f: Pointer);
    vkWaitSemaphores(a: Pointer, b: Pointer, c: u64);
    vkDeviceWaitIdle(a: Pointer);
    vkCreateComputePipelines(a: Pointer, b: u64, c: u32, d: Pointer, e: Pointer, f: Pointer);
}

unsafe extern "system" fn instance_function(instance: Pointer, name: *const c_char) -> Function {
    unsafe {
        match CStr::from_ptr(name).to_bytes() {
            b"vkGetInstanceProcAddr" => transmute(instance_function as *const c_void),
            b"vkGetDeviceProcAddr" => transmute(device_function as *const c_void),
            b"vkCreateInstance" => transmute(create_instance as *const c_void),
            b"vkCreateDevice" => transmute(create_device as *const c_void),
            b"vkGetPhysicalDeviceSurfaceCapabilitiesKHR" => {
                transmute(surface_capabilities as *const c_void)
            }
            _ => next(&INSTANCE_FUNCTION, instance, CStr::from_ptr(name)),
        }
    }
}

/// Where the loader begins.
#[unsafe(no_mangle)]
pub unsafe extern "system" fn vkNegotiateLoaderLayerInterfaceVersion(
    interface: *mut Interface,
) -> i32 {
    unsafe {
        (*interface).version = 2;
        (*interface).instance_function = instance_function;
        (*interface).device_function = device_function;
        (*interface).physical_function = std::ptr::null_mut();
    }
    0
}
