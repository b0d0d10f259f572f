//! The Vulkan instance, and the validation layer's messages when it is asked for.

use std::ffi::{CStr, c_char, c_void};
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Arc, Mutex, PoisonError};

use ash::{ext, khr, vk};
#[cfg(feature = "view")]
use raw_window_handle::HasDisplayHandle;

use super::Named;
use crate::{Error, Result};

const VALIDATION_LAYER: &CStr = c"VK_LAYER_KHRONOS_validation";

/// Whether the Khronos validation layer watches, with synchronization checks.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Validation {
    /// Not loaded.
    Off,
    /// Loaded; any warning or error is collected (see [`Instance::messages`]).
    On,
    /// Messages as by `On`, with the layer's advice on good practice.
    BestPractices,
}

/// Messages of the validation layer, shared with its callback.
#[derive(Default)]
struct Messages(Mutex<Vec<String>>);

/// The Vulkan instance.
pub struct Instance {
    pub(super) raw: ash::Instance,
    pub(super) entry: ash::Entry,
    pub(super) debug_utils: bool,
    /// Version that it was made for.
    pub(super) api_version: u32,
    /// Whether it is destroyed with this; a host's is not.
    is_owned: bool,
    /// Whether surfaces of windows can be made from it.
    pub(super) presents: bool,
    /// Tells it from the others of this process.
    pub(super) number: u64,
    /// Version of Vulkan that the validation layer knows, where it watches.
    pub(super) layer_version: Option<u32>,
    messenger: Option<(ext::debug_utils::Instance, vk::DebugUtilsMessengerEXT)>,
    messages: Box<Messages>,
}

impl Instance {
    /// Loads Vulkan and creates an instance of API 1.3.
    ///
    /// # Errors
    /// [`Error::NoLoader`]; [`Error::Validation`] if validation is asked for and not installed;
    /// [`Error::NoDevice`] if the loader finds no driver; [`Error::Vulkan`] if one refuses.
    pub fn new(validation: Validation) -> Result<Arc<Self>> {
        Self::with_extensions(load()?, validation, &[])
    }

    /// Like [`Instance::new`], by a Vulkan that the caller has loaded.
    ///
    /// # Errors
    /// Like [`Instance::new`].
    pub fn with_entry(entry: ash::Entry, validation: Validation) -> Result<Arc<Self>> {
        Self::with_extensions(entry, validation, &[])
    }

    /// Like [`Instance::new`], with what surfaces on `display` need.
    ///
    /// # Errors
    /// Like [`Instance::new`]; [`Error::Window`] for a display that Vulkan does not know.
    #[cfg(feature = "view")]
    pub fn for_windows(
        validation: Validation,
        display: &impl HasDisplayHandle,
    ) -> Result<Arc<Self>> {
        let problem = |error: &dyn std::fmt::Display| Error::Window(error.to_string());
        let display = display.display_handle().map_err(|error| problem(&error))?;
        let names = ash_window::enumerate_required_extensions(display.as_raw());
        Self::with_extensions(load()?, validation, names.map_err(|error| problem(&error))?)
    }

    fn with_extensions(
        entry: ash::Entry,
        validation: Validation,
        wanted: &[*const c_char],
    ) -> Result<Arc<Self>> {
        let is_watched = validation != Validation::Off;
        let messages = Box::new(Messages::default());

        // SAFETY: no preconditions beyond a loaded entry.
        let extensions = unsafe { entry.enumerate_instance_extension_properties(None) }
            .named("vkEnumerateInstanceExtensionProperties", "the loader")?;
        let has = |name| extensions.iter().any(|e| e.extension_name_as_c_str() == Ok(name));
        let debug_utils = is_watched || has(ext::debug_utils::NAME);

        let application = vk::ApplicationInfo::default()
            .application_name(c"raindrops")
            .engine_name(c"raindrops")
            .api_version(vk::API_VERSION_1_3);
        let mut layer_names = Vec::new();
        let mut extension_names = wanted.to_vec();
        if debug_utils {
            extension_names.push(ext::debug_utils::NAME.as_ptr());
        }
        let enabled = [
            vk::ValidationFeatureEnableEXT::SYNCHRONIZATION_VALIDATION,
            vk::ValidationFeatureEnableEXT::BEST_PRACTICES,
        ];
        let count = if validation == Validation::BestPractices { 2 } else { 1 };
        let mut features =
            vk::ValidationFeaturesEXT::default().enabled_validation_features(&enabled[..count]);
        let mut messenger_info = messenger_info(&messages);
        let mut info = vk::InstanceCreateInfo::default().application_info(&application);
        // Else the loader hides drivers over another interface, such as MoltenVK.
        if has(khr::portability_enumeration::NAME) {
            extension_names.push(khr::portability_enumeration::NAME.as_ptr());
            info = info.flags(vk::InstanceCreateFlags::ENUMERATE_PORTABILITY_KHR);
        }
        let mut layer_version = None;
        if is_watched {
            // SAFETY: no preconditions beyond a loaded entry.
            let layers = unsafe { entry.enumerate_instance_layer_properties() }
                .named("vkEnumerateInstanceLayerProperties", "the loader")?;
            let layer = layers.iter().find(|l| l.layer_name_as_c_str() == Ok(VALIDATION_LAYER));
            layer_version = Some(layer.map(|layer| layer.spec_version).ok_or_else(|| {
                Error::Validation("the layer VK_LAYER_KHRONOS_validation is not installed".into())
            })?);
            layer_names.push(VALIDATION_LAYER.as_ptr());
            extension_names.push(ext::validation_features::NAME.as_ptr());
            info = info.push_next(&mut features).push_next(&mut messenger_info);
        }
        info = info.enabled_layer_names(&layer_names).enabled_extension_names(&extension_names);

        // SAFETY: `info` and all it points to outlive the call.
        let raw = unsafe { entry.create_instance(&info, None) }.map_err(|result| match result {
            vk::Result::ERROR_INCOMPATIBLE_DRIVER => Error::NoDevice,
            vk::Result::ERROR_EXTENSION_NOT_PRESENT if !wanted.is_empty() => Error::Window(
                "the Vulkan loader knows no driver that draws in windows of this display".into(),
            ),
            result => {
                Error::Vulkan { call: "vkCreateInstance", object: "the instance".into(), result }
            }
        })?;
        let presents = !wanted.is_empty();
        let mut instance = Self {
            raw,
            entry,
            debug_utils,
            api_version: vk::API_VERSION_1_3,
            is_owned: true,
            presents,
            number: next_number(),
            layer_version,
            messenger: None,
            messages,
        };
        if is_watched {
            let loader = ext::debug_utils::Instance::new(&instance.entry, &instance.raw);
            let info = self::messenger_info(&instance.messages);
            // SAFETY: the callback's user data is boxed and outlives the messenger (see `drop`).
            let messenger = unsafe { loader.create_debug_utils_messenger(&info, None) }
                .named("vkCreateDebugUtilsMessengerEXT", "the validation messenger")?;
            instance.messenger = Some((loader, messenger));
        }
        Ok(Arc::new(instance))
    }

    /// A host's instance, of an API version, with or without `VK_EXT_debug_utils`; it is never destroyed.
    ///
    /// # Safety
    /// Entry and instance stay alive until this and all that is made from it is dropped. The version and the extension
    /// are those that the instance was made with.
    pub(super) unsafe fn of_host(
        entry: ash::Entry,
        raw: ash::Instance,
        api_version: u32,
        debug_utils: bool,
    ) -> Arc<Self> {
        Arc::new(Self {
            raw,
            entry,
            debug_utils,
            api_version,
            is_owned: false,
            presents: false,
            number: next_number(),
            layer_version: None,
            messenger: None,
            messages: Box::default(),
        })
    }

    /// Every warning and error of the validation layer so far, oldest first.
    pub fn messages(&self) -> Vec<String> {
        self.messages.0.lock().unwrap_or_else(PoisonError::into_inner).clone()
    }

    /// Fails if the validation layer has said anything.
    ///
    /// # Errors
    /// [`Error::Validation`] with the first message and the number of the others.
    pub fn expect_silence(&self) -> Result<()> {
        match self.messages().as_slice() {
            [] => Ok(()),
            [first, rest @ ..] => {
                Err(Error::Validation(format!("{first} (and {} more messages)", rest.len())))
            }
        }
    }
}

/// Tells an instance from the others of this process.
fn next_number() -> u64 {
    static INSTANCES: AtomicU64 = AtomicU64::new(0);
    INSTANCES.fetch_add(1, Ordering::Relaxed)
}

/// The system's Vulkan loader.
fn load() -> Result<ash::Entry> {
    // SAFETY: loading a library runs its initialisers; this is the system's Vulkan loader.
    unsafe { ash::Entry::load() }.map_err(|error| Error::NoLoader(error.to_string()))
}

fn messenger_info(messages: &Messages) -> vk::DebugUtilsMessengerCreateInfoEXT<'static> {
    use vk::{
        DebugUtilsMessageSeverityFlagsEXT as Severity, DebugUtilsMessageTypeFlagsEXT as Type,
    };
    vk::DebugUtilsMessengerCreateInfoEXT::default()
        .message_severity(Severity::WARNING | Severity::ERROR)
        .message_type(Type::VALIDATION | Type::PERFORMANCE)
        .pfn_user_callback(Some(collect))
        .user_data(std::ptr::from_ref(messages).cast_mut().cast())
}

/// Called by the layer from any thread.
unsafe extern "system" fn collect(
    _: vk::DebugUtilsMessageSeverityFlagsEXT,
    _: vk::DebugUtilsMessageTypeFlagsEXT,
    data: *const vk::DebugUtilsMessengerCallbackDataEXT<'_>,
    user: *mut c_void,
) -> vk::Bool32 {
    // SAFETY: the layer passes valid data for the duration of the call, and `user` is the boxed
    // `Messages` that outlives the messenger.
    let (message, messages) = unsafe {
        let message = (*data).p_message;
        let text = if message.is_null() { c"" } else { CStr::from_ptr(message) };
        (text.to_string_lossy().into_owned(), &*user.cast::<Messages>())
    };
    messages.0.lock().unwrap_or_else(PoisonError::into_inner).push(message);
    vk::FALSE
}

impl Drop for Instance {
    fn drop(&mut self) {
        // SAFETY: every object made from the instance holds an `Arc` of it, so none is left.
        unsafe {
            if let Some((loader, messenger)) = &self.messenger {
                loader.destroy_debug_utils_messenger(*messenger, None);
            }
            if self.is_owned {
                self.raw.destroy_instance(None);
            }
        }
    }
}
