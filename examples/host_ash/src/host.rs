//! A small Vulkan program without rain: an instance with its messages, a device with one queue, images, buffers and
//! command buffers. Everything is by `ash`, as an engine would have it; nothing is of `raindrops` but the list of
//! what the device must have.

#![allow(dead_code, reason = "the example and a test use a part of this each")]

use std::ffi::{CStr, c_void};
use std::sync::Mutex;

use ash::{ext, vk};
use raindrops::device::{Features, HostDevice, Requirements};

const VALIDATION: &CStr = c"VK_LAYER_KHRONOS_validation";

/// Messages of the validation layer.
type Messages = Mutex<Vec<String>>;

pub struct Host {
    pub entry: ash::Entry,
    pub instance: ash::Instance,
    pub physical: vk::PhysicalDevice,
    pub device: ash::Device,
    pub features: Features,
    pub family: u32,
    pub queue: vk::Queue,
    pool: vk::CommandPool,
    messenger: Option<(ext::debug_utils::Instance, vk::DebugUtilsMessengerEXT)>,
    messages: Box<Messages>,
}

unsafe extern "system" fn collect(
    _: vk::DebugUtilsMessageSeverityFlagsEXT,
    _: vk::DebugUtilsMessageTypeFlagsEXT,
    data: *const vk::DebugUtilsMessengerCallbackDataEXT<'_>,
    user: *mut c_void,
) -> vk::Bool32 {
    // SAFETY: the layer passes valid data; `user` is the boxed `Messages`.
    let (text, messages) = unsafe {
        (
            CStr::from_ptr((*data).p_message).to_string_lossy().into_owned(),
            &*user.cast::<Messages>(),
        )
    };
    messages.lock().expect("no panic").push(text);
    vk::FALSE
}

impl Host {
    /// Opens the first device whose name holds `wanted`, or the first of all; it must have what is required. `validates`:
    /// with the validation layer and its synchronization checks.
    pub fn new(
        entry: ash::Entry,
        required: &Requirements,
        validates: bool,
        wanted: Option<&str>,
    ) -> Self {
        let messages: Box<Messages> = Box::default();
        let application = vk::ApplicationInfo::default().api_version(required.api_version);
        let (layers, extensions) = ([VALIDATION.as_ptr()], [ext::debug_utils::NAME.as_ptr()]);
        let checks = [vk::ValidationFeatureEnableEXT::SYNCHRONIZATION_VALIDATION];
        let mut checks = vk::ValidationFeaturesEXT::default().enabled_validation_features(&checks);
        let mut info = vk::InstanceCreateInfo::default().application_info(&application);
        if validates {
            info = info
                .enabled_layer_names(&layers)
                .enabled_extension_names(&extensions)
                .push_next(&mut checks);
        }
        // SAFETY: `info` and all it points to outlive the call.
        let instance = unsafe { entry.create_instance(&info, None) }.expect("an instance");
        let messenger = validates.then(|| {
            use vk::DebugUtilsMessageSeverityFlagsEXT as Severity;
            let info = vk::DebugUtilsMessengerCreateInfoEXT::default()
                .message_severity(Severity::WARNING | Severity::ERROR)
                .message_type(vk::DebugUtilsMessageTypeFlagsEXT::VALIDATION)
                .pfn_user_callback(Some(collect))
                .user_data(std::ptr::from_ref(&*messages).cast_mut().cast());
            let loader = ext::debug_utils::Instance::new(&entry, &instance);
            // SAFETY: the messages are boxed and outlive the messenger.
            let raw = unsafe { loader.create_debug_utils_messenger(&info, None) };
            (loader, raw.expect("a messenger"))
        });

        // SAFETY: the instance is alive.
        let all = unsafe { instance.enumerate_physical_devices() }.expect("devices");
        let name = |physical: &vk::PhysicalDevice| {
            // SAFETY: it is the instance's.
            let properties = unsafe { instance.get_physical_device_properties(*physical) };
            properties.device_name_as_c_str().unwrap_or(c"").to_string_lossy().to_lowercase()
        };
        let is_wanted = |physical: &&vk::PhysicalDevice| {
            wanted.is_none_or(|wanted| name(physical).contains(&wanted.to_lowercase()))
        };
        let physical = *all.iter().find(is_wanted).expect("the device that is wanted");
        // SAFETY: it is the instance's.
        let families = unsafe { instance.get_physical_device_queue_family_properties(physical) };
        let takes_all =
            |family: &vk::QueueFamilyProperties| family.queue_flags.contains(required.queue_flags);
        let family = families.iter().position(takes_all).expect("a queue family") as u32;

        // What an engine would enable for itself goes into the same structures.
        let mut core = vk::PhysicalDeviceFeatures::default();
        let mut vulkan12 = vk::PhysicalDeviceVulkan12Features::default();
        let mut vulkan13 = vk::PhysicalDeviceVulkan13Features::default();
        required.features.enable(&mut core, &mut vulkan12, &mut vulkan13);
        let features = Features::of(&core, &vulkan12, &vulkan13);
        let queues = [vk::DeviceQueueCreateInfo::default()
            .queue_family_index(family)
            .queue_priorities(&[1.0])];
        let info = vk::DeviceCreateInfo::default()
            .queue_create_infos(&queues)
            .enabled_features(&core)
            .push_next(&mut vulkan12)
            .push_next(&mut vulkan13);
        // SAFETY: `info` and all it points to outlive the call.
        let device = unsafe { instance.create_device(physical, &info, None) }.expect("a device");
        // SAFETY: the family was asked for one queue.
        let queue = unsafe { device.get_device_queue(family, 0) };
        let info = vk::CommandPoolCreateInfo::default()
            .queue_family_index(family)
            .flags(vk::CommandPoolCreateFlags::RESET_COMMAND_BUFFER);
        // SAFETY: valid info.
        let pool = unsafe { device.create_command_pool(&info, None) }.expect("a pool");
        Self {
            entry,
            instance,
            physical,
            device,
            features,
            family,
            queue,
            pool,
            messenger,
            messages,
        }
    }

    /// What `Device::import` is told of it.
    pub fn lent(&self) -> HostDevice {
        HostDevice {
            entry: self.entry.clone(),
            instance: self.instance.clone(),
            api_version: vk::API_VERSION_1_3,
            debug_utils: self.messenger.is_some(),
            physical_device: self.physical,
            device: self.device.clone(),
            features: self.features,
            queue_family: self.family,
            queue: self.queue,
            queue_lock: None,
            allocator: None,
            pipelines: Vec::new(),
        }
    }

    /// What the validation layer has said so far.
    pub fn messages(&self) -> Vec<String> {
        self.messages.lock().expect("no panic").clone()
    }

    pub fn commands(&self) -> vk::CommandBuffer {
        let info = vk::CommandBufferAllocateInfo::default()
            .command_pool(self.pool)
            .command_buffer_count(1);
        // SAFETY: the pool is alive.
        unsafe { self.device.allocate_command_buffers(&info) }.expect("a command buffer")[0]
    }

    pub fn begin(&self, commands: vk::CommandBuffer) {
        let info = vk::CommandBufferBeginInfo::default()
            .flags(vk::CommandBufferUsageFlags::ONE_TIME_SUBMIT);
        // SAFETY: the buffer is not in use.
        unsafe { self.device.begin_command_buffer(commands, &info) }.expect("a recording");
    }

    pub fn end(&self, commands: vk::CommandBuffer) {
        // SAFETY: it is being recorded.
        unsafe { self.device.end_command_buffer(commands) }.expect("a recording");
    }

    pub fn fence(&self) -> vk::Fence {
        // SAFETY: valid info.
        unsafe { self.device.create_fence(&vk::FenceCreateInfo::default(), None) }.expect("a fence")
    }

    /// Submits; the fence is signalled when all is done.
    pub fn submit(&self, commands: vk::CommandBuffer, fence: vk::Fence) {
        let commands = [vk::CommandBufferSubmitInfo::default().command_buffer(commands)];
        let info = [vk::SubmitInfo2::default().command_buffer_infos(&commands)];
        // SAFETY: the commands are executable, and this thread alone uses the queue.
        unsafe { self.device.queue_submit2(self.queue, &info, fence) }.expect("a submission");
    }

    /// Waits for a fence and resets it.
    pub fn wait(&self, fence: vk::Fence) {
        // SAFETY: the fence is alive, and signalled by what was submitted.
        unsafe {
            self.device.wait_for_fences(&[fence], true, u64::MAX).expect("the queue");
            self.device.reset_fences(&[fence]).expect("a fence");
        }
    }

    pub fn destroy_fence(&self, fence: vk::Fence) {
        // SAFETY: nothing waits for it.
        unsafe { self.device.destroy_fence(fence, None) };
    }

    /// Submits and waits.
    pub fn run(&self, commands: vk::CommandBuffer) {
        let fence = self.fence();
        self.submit(commands, fence);
        self.wait(fence);
        self.destroy_fence(fence);
    }

    /// Records, submits and waits.
    pub fn once(&self, record: impl FnOnce(vk::CommandBuffer)) {
        let commands = self.commands();
        self.begin(commands);
        record(commands);
        self.end(commands);
        self.run(commands);
        // SAFETY: they are done.
        unsafe { self.device.free_command_buffers(self.pool, &[commands]) };
    }

    fn memory(
        &self,
        needs: vk::MemoryRequirements,
        wanted: vk::MemoryPropertyFlags,
    ) -> vk::DeviceMemory {
        // SAFETY: the physical device is the instance's.
        let kinds = unsafe { self.instance.get_physical_device_memory_properties(self.physical) };
        let fits = |index: &u32| {
            needs.memory_type_bits >> index & 1 == 1
                && kinds.memory_types[*index as usize].property_flags.contains(wanted)
        };
        let kind = (0..kinds.memory_type_count).find(fits).expect("a memory type");
        let info =
            vk::MemoryAllocateInfo::default().allocation_size(needs.size).memory_type_index(kind);
        // SAFETY: valid info.
        unsafe { self.device.allocate_memory(&info, None) }.expect("memory")
    }

    /// An image of one level; of six layers it is seen as a cube.
    pub fn image(
        &self,
        format: vk::Format,
        (width, height): (u32, u32),
        layers: u32,
        usage: vk::ImageUsageFlags,
    ) -> Texture {
        let is_cube = layers == 6;
        let flags = if is_cube {
            vk::ImageCreateFlags::CUBE_COMPATIBLE
        } else {
            vk::ImageCreateFlags::empty()
        };
        let info = vk::ImageCreateInfo::default()
            .flags(flags)
            .image_type(vk::ImageType::TYPE_2D)
            .format(format)
            .extent(vk::Extent3D { width, height, depth: 1 })
            .mip_levels(1)
            .array_layers(layers)
            .samples(vk::SampleCountFlags::TYPE_1)
            .tiling(vk::ImageTiling::OPTIMAL)
            .usage(usage);
        // SAFETY: valid infos; memory of the image's own requirements.
        unsafe {
            let image = self.device.create_image(&info, None).expect("an image");
            let needs = self.device.get_image_memory_requirements(image);
            let memory = self.memory(needs, vk::MemoryPropertyFlags::DEVICE_LOCAL);
            self.device.bind_image_memory(image, memory, 0).expect("memory");
            use vk::ImageAspectFlags as Aspect;
            // Depth is seen without the stencil beside it.
            let (aspect, seen) = match format {
                vk::Format::D32_SFLOAT => (Aspect::DEPTH, Aspect::DEPTH),
                vk::Format::D32_SFLOAT_S8_UINT => (Aspect::DEPTH | Aspect::STENCIL, Aspect::DEPTH),
                _ => (Aspect::COLOR, Aspect::COLOR),
            };
            let view = |kind, first, count| {
                let range = vk::ImageSubresourceRange {
                    aspect_mask: seen,
                    base_mip_level: 0,
                    level_count: 1,
                    base_array_layer: first,
                    layer_count: count,
                };
                let info = vk::ImageViewCreateInfo::default()
                    .image(image)
                    .view_type(kind)
                    .format(format)
                    .subresource_range(range);
                self.device.create_image_view(&info, None).expect("a view")
            };
            let whole = if is_cube { vk::ImageViewType::CUBE } else { vk::ImageViewType::TYPE_2D };
            let faces = (0..layers).filter(|_| is_cube);
            let faces = faces.map(|face| view(vk::ImageViewType::TYPE_2D, face, 1)).collect();
            Texture {
                image,
                view: view(whole, 0, layers),
                faces,
                memory,
                format,
                size: (width, height),
                aspect,
                layers,
            }
        }
    }

    pub fn destroy_image(&self, texture: Texture) {
        // SAFETY: nothing uses it.
        unsafe {
            for view in texture.faces.iter().chain([&texture.view]) {
                self.device.destroy_image_view(*view, None);
            }
            self.device.destroy_image(texture.image, None);
            self.device.free_memory(texture.memory, None);
        }
    }

    /// Fills an image, layer after layer, and leaves it to be sampled.
    pub fn write(&self, texture: &Texture, bytes: &[u8]) {
        let layers = vk::ImageSubresourceLayers::default()
            .aspect_mask(texture.aspect)
            .layer_count(texture.layers);
        let range = vk::ImageSubresourceRange::default()
            .aspect_mask(texture.aspect)
            .level_count(1)
            .layer_count(texture.layers);
        let (width, height) = texture.size;
        let region = [vk::BufferImageCopy::default()
            .image_subresource(layers)
            .image_extent(vk::Extent3D { width, height, depth: 1 })];
        use vk::{AccessFlags2 as Access, ImageLayout as Layout, PipelineStageFlags2 as Stage};
        let change = |commands, (stage, access, old), (next_stage, next_access, new)| {
            let barrier = [vk::ImageMemoryBarrier2::default()
                .src_stage_mask(stage)
                .src_access_mask(access)
                .dst_stage_mask(next_stage)
                .dst_access_mask(next_access)
                .old_layout(old)
                .new_layout(new)
                .image(texture.image)
                .subresource_range(range)];
            let info = vk::DependencyInfo::default().image_memory_barriers(&barrier);
            // SAFETY: the command buffer is being recorded.
            unsafe { self.device.cmd_pipeline_barrier2(commands, &info) };
        };
        let before = (Stage::ALL_COMMANDS, Access::NONE, Layout::UNDEFINED);
        let copied = (Stage::COPY, Access::TRANSFER_WRITE, Layout::TRANSFER_DST_OPTIMAL);
        let after =
            (Stage::COMPUTE_SHADER, Access::SHADER_SAMPLED_READ, Layout::SHADER_READ_ONLY_OPTIMAL);
        let staging = self.buffer(bytes.len() as u64, vk::BufferUsageFlags::TRANSFER_SRC);
        staging.put(0, bytes);
        self.once(|commands| {
            change(commands, before, copied);
            let layout = vk::ImageLayout::TRANSFER_DST_OPTIMAL;
            // SAFETY: the buffer holds the image, and is freed when the queue is done.
            unsafe {
                self.device.cmd_copy_buffer_to_image(
                    commands,
                    staging.raw,
                    texture.image,
                    layout,
                    &region,
                );
            }
            change(commands, copied, after);
        });
        self.destroy_buffer(staging);
    }

    /// The bytes of a one-layer image that was left as a source of copies.
    pub fn read(&self, texture: &Texture, bytes: u64) -> Vec<u8> {
        let staging = self.buffer(bytes, vk::BufferUsageFlags::TRANSFER_DST);
        let layers =
            vk::ImageSubresourceLayers::default().aspect_mask(texture.aspect).layer_count(1);
        let (width, height) = texture.size;
        let region = [vk::BufferImageCopy::default()
            .image_subresource(layers)
            .image_extent(vk::Extent3D { width, height, depth: 1 })];
        let layout = vk::ImageLayout::TRANSFER_SRC_OPTIMAL;
        self.once(|commands| {
            // SAFETY: the buffer holds the image, which is in that layout.
            unsafe {
                self.device.cmd_copy_image_to_buffer(
                    commands,
                    texture.image,
                    layout,
                    staging.raw,
                    &region,
                );
            }
            self.copied_for_cpu(commands);
        });
        let read = staging.get();
        self.destroy_buffer(staging);
        read
    }

    /// A barrier after copies that the CPU reads.
    pub fn copied_for_cpu(&self, commands: vk::CommandBuffer) {
        let to_host = [vk::MemoryBarrier2::default()
            .src_stage_mask(vk::PipelineStageFlags2::COPY)
            .src_access_mask(vk::AccessFlags2::TRANSFER_WRITE)
            .dst_stage_mask(vk::PipelineStageFlags2::HOST)
            .dst_access_mask(vk::AccessFlags2::HOST_READ)];
        let info = vk::DependencyInfo::default().memory_barriers(&to_host);
        // SAFETY: the command buffer is being recorded, outside of any rendering.
        unsafe { self.device.cmd_pipeline_barrier2(commands, &info) };
    }

    /// A buffer that the CPU writes and reads.
    pub fn buffer(&self, bytes: u64, usage: vk::BufferUsageFlags) -> Mapped {
        use vk::MemoryPropertyFlags as Memory;
        let info = vk::BufferCreateInfo::default().size(bytes).usage(usage);
        // SAFETY: valid infos; memory of the buffer's own requirements, mapped once.
        unsafe {
            let raw = self.device.create_buffer(&info, None).expect("a buffer");
            let needs = self.device.get_buffer_memory_requirements(raw);
            let memory = self.memory(needs, Memory::HOST_VISIBLE | Memory::HOST_COHERENT);
            self.device.bind_buffer_memory(raw, memory, 0).expect("memory");
            let whole = vk::WHOLE_SIZE;
            let mapped = self.device.map_memory(memory, 0, whole, vk::MemoryMapFlags::empty());
            Mapped { raw, bytes, memory, mapped: mapped.expect("a mapping").cast() }
        }
    }

    pub fn destroy_buffer(&self, buffer: Mapped) {
        // SAFETY: nothing uses it.
        unsafe {
            self.device.destroy_buffer(buffer.raw, None);
            self.device.free_memory(buffer.memory, None);
        }
    }
}

/// A buffer with memory that the CPU sees.
pub struct Mapped {
    pub raw: vk::Buffer,
    pub bytes: u64,
    memory: vk::DeviceMemory,
    mapped: *mut u8,
}

impl Mapped {
    /// Writes bytes from an offset on. The device must not be using them.
    pub fn put(&self, offset: usize, bytes: &[u8]) {
        assert!((offset + bytes.len()) as u64 <= self.bytes, "the buffer has room");
        // SAFETY: the memory is mapped, and the bytes are within it.
        unsafe {
            std::ptr::copy_nonoverlapping(bytes.as_ptr(), self.mapped.add(offset), bytes.len());
        }
    }

    /// What is in it. The device must not be writing it.
    pub fn get(&self) -> Vec<u8> {
        // SAFETY: the memory is mapped, and as large.
        unsafe { std::slice::from_raw_parts(self.mapped, self.bytes as usize) }.to_vec()
    }
}

/// An image with its memory and view.
pub struct Texture {
    pub image: vk::Image,
    pub view: vk::ImageView,
    /// A view of each face, if it is a cube.
    pub faces: Vec<vk::ImageView>,
    memory: vk::DeviceMemory,
    pub format: vk::Format,
    pub size: (u32, u32),
    pub aspect: vk::ImageAspectFlags,
    pub layers: u32,
}

impl Drop for Host {
    fn drop(&mut self) {
        // SAFETY: nothing of the device is in use.
        unsafe {
            self.device.destroy_command_pool(self.pool, None);
            self.device.destroy_device(None);
            if let Some((loader, messenger)) = &self.messenger {
                loader.destroy_debug_utils_messenger(*messenger, None);
            }
            self.instance.destroy_instance(None);
        }
    }
}
