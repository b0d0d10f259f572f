//! A Vulkan driver that finds no card, as radv on a machine without one: its instance stands, and it lists no devices. The loader
//! makes a failure of that. A shared library, compiled by `tests/faults/failing_calls.rs`.

use std::ffi::{CStr, c_char, c_void};
use std::mem::transmute;

type Pointer = *mut c_void;
type Function = Option<unsafe extern "system" fn()>;

const SUCCESS: i32 = 0;
/// What the loader expects at the beginning of an instance (`ICD_LOADER_MAGIC` of `vk_icd.h`).
const LOADER_MAGIC: usize = 0x01CD_C0DE;
/// The highest version of the interface with the loader that this driver knows.
const INTERFACE: u32 = 5;
const VULKAN_1_3: u32 = (1 << 22) | (3 << 12);

unsafe extern "system" fn version(out: *mut u32) -> i32 {
    unsafe { *out = VULKAN_1_3 };
    SUCCESS
}

/// Without extensions.
unsafe extern "system" fn extensions(_: *const c_char, count: *mut u32, _: Pointer) -> i32 {
    unsafe { *count = 0 };
    SUCCESS
}

unsafe extern "system" fn create(_: Pointer, _: Pointer, out: *mut Pointer) -> i32 {
    unsafe { *out = Box::into_raw(Box::new([LOADER_MAGIC; 8])).cast() };
    SUCCESS
}

unsafe extern "system" fn destroy(instance: Pointer, _: Pointer) {
    unsafe { drop(Box::from_raw(instance.cast::<[usize; 8]>())) };
}

unsafe extern "system" fn devices(_: Pointer, count: *mut u32, _: Pointer) -> i32 {
    unsafe { *count = 0 };
    SUCCESS
}

/// In place of what is called of devices alone; the loader wants it to be there.
unsafe extern "system" fn of_devices() {
    std::process::abort();
}

#[unsafe(no_mangle)]
pub unsafe extern "system" fn vk_icdNegotiateLoaderICDInterfaceVersion(asked: *mut u32) -> i32 {
    unsafe { *asked = (*asked).min(INTERFACE) };
    SUCCESS
}

#[unsafe(no_mangle)]
pub unsafe extern "system" fn vk_icdGetInstanceProcAddr(_: Pointer, name: *const c_char) -> Function {
    unsafe {
        match CStr::from_ptr(name).to_bytes() {
            b"vkEnumerateInstanceVersion" => transmute(version as *const c_void),
            b"vkEnumerateInstanceExtensionProperties" => transmute(extensions as *const c_void),
            b"vkCreateInstance" => transmute(create as *const c_void),
            b"vkDestroyInstance" => transmute(destroy as *const c_void),
            b"vkEnumeratePhysicalDevices" => transmute(devices as *const c_void),
            b"vkEnumeratePhysicalDeviceGroups" => None,
            name if name.ends_with(b"KHR") || name.ends_with(b"EXT") => None,
            _ => Some(of_devices),
        }
    }
}
