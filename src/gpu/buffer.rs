//! A buffer with its memory.

use std::sync::Arc;

use ash::vk;
use gpu_allocator::MemoryLocation;
use gpu_allocator::vulkan::{Allocation, AllocationCreateDesc, AllocationScheme};

use super::retired::Object;
use super::{Commands, Device, Named, copy_buffer};
use crate::{Error, Result};

/// Where a buffer's memory is wanted.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Memory {
    /// On the device.
    Device,
    /// Visible to both, for writing by the CPU.
    Upload,
    /// Visible to both, for reading by the CPU.
    Readback,
}

/// A buffer with its memory. Both are freed when neither this, nor a set or view of it, nor commands need them.
pub struct Buffer {
    pub(super) raw: vk::Buffer,
    /// Size in bytes.
    pub size: u64,
    pub(super) held: Arc<BufferMemory>,
}

/// What is freed with a buffer.
pub(super) struct BufferMemory {
    raw: vk::Buffer,
    allocation: Option<Allocation>,
    device: Arc<Device>,
}

impl Buffer {
    /// Creates a buffer of `size` bytes (at least 16, so that an empty list is still a buffer).
    ///
    /// # Errors
    /// [`Error::Memory`] if the device cannot have or has no such memory; [`Error::Vulkan`] if the
    /// driver refuses.
    pub fn new(
        device: &Arc<Device>,
        name: &str,
        size: u64,
        usage: vk::BufferUsageFlags,
        memory: Memory,
    ) -> Result<Self> {
        let size = size.max(16);
        device.check_allocation(name, size)?;
        let info = vk::BufferCreateInfo::default().size(size).usage(usage);
        // SAFETY: `info` is valid; the handle is owned by the value made here.
        let raw = unsafe { device.raw.create_buffer(&info, None) }.named("vkCreateBuffer", name)?;
        let mut held = BufferMemory { raw, allocation: None, device: device.clone() };
        device.name(raw, name);
        // SAFETY: the buffer was just made.
        let requirements = unsafe { device.raw.get_buffer_memory_requirements(raw) };
        let location = match memory {
            Memory::Device => MemoryLocation::GpuOnly,
            Memory::Upload => MemoryLocation::CpuToGpu,
            Memory::Readback => MemoryLocation::GpuToCpu,
        };
        let allocation = device
            .allocator()
            .allocate(&AllocationCreateDesc {
                name,
                requirements,
                location,
                linear: true,
                allocation_scheme: AllocationScheme::GpuAllocatorManaged,
            })
            .map_err(|error| Error::Memory {
                object: name.into(),
                mebibytes: size as f64 / 1_048_576.0,
                reason: error.to_string(),
            })?;
        // SAFETY: memory of the buffer's own requirements, bound once.
        let bound =
            unsafe { device.raw.bind_buffer_memory(raw, allocation.memory(), allocation.offset()) };
        held.allocation = Some(allocation);
        bound.named("vkBindBufferMemory", name)?;
        Ok(Self { raw, size, held: Arc::new(held) })
    }

    /// A host-visible buffer that holds `values`.
    ///
    /// # Errors
    /// Those of [`Buffer::new`].
    pub fn upload<T: bytemuck::Pod>(
        device: &Arc<Device>,
        name: &str,
        values: &[T],
        usage: vk::BufferUsageFlags,
    ) -> Result<Self> {
        let mut buffer =
            Self::new(device, name, size_of_val(values) as u64, usage, Memory::Upload)?;
        buffer.write(0, values);
        Ok(buffer)
    }

    /// A buffer on the device that holds `values`, copied there.
    ///
    /// # Errors
    /// Those of [`Buffer::new`] and [`Commands::once`].
    pub fn upload_device<T: bytemuck::Pod>(
        device: &Arc<Device>,
        name: &str,
        values: &[T],
        usage: vk::BufferUsageFlags,
    ) -> Result<Self> {
        let staging = Self::upload(device, name, values, vk::BufferUsageFlags::TRANSFER_SRC)?;
        let usage = usage | vk::BufferUsageFlags::TRANSFER_DST;
        let buffer = Self::new(device, name, staging.size, usage, Memory::Device)?;
        Commands::once(device, name, |commands| copy_buffer(device, commands, &staging, &buffer))?;
        Ok(buffer)
    }

    /// A host-visible buffer that `bytes` are copied to, for [`Buffer::read`].
    ///
    /// # Errors
    /// Those of [`Buffer::new`].
    pub fn readback(device: &Arc<Device>, name: &str, bytes: u64) -> Result<Self> {
        Self::new(device, name, bytes, vk::BufferUsageFlags::TRANSFER_DST, Memory::Readback)
    }

    /// The raw handle, for recording commands.
    pub fn raw(&self) -> vk::Buffer {
        self.raw
    }

    /// Writes `values` at a byte offset of a buffer in [`Memory::Upload`].
    ///
    /// # Panics
    /// If the buffer is not host-visible or too small: a mistake of the caller.
    pub fn write<T: bytemuck::Pod>(&mut self, offset: usize, values: &[T]) {
        let bytes: &[u8] = bytemuck::cast_slice(values);
        let allocation = self.held.allocation.as_ref().expect("it has memory");
        let end = offset.checked_add(bytes.len()).expect("within memory");
        assert!(end as u64 <= self.size, "the buffer has room");
        let mapped = allocation.mapped_ptr().expect("the buffer is host-visible").as_ptr();
        // SAFETY: the memory is mapped, the bytes are within it, and `self` alone writes it from here.
        unsafe {
            let to = mapped.cast::<u8>().add(offset);
            std::ptr::copy_nonoverlapping(bytes.as_ptr(), to, bytes.len());
        }
    }

    /// The first `count` values of a host-visible buffer.
    ///
    /// # Panics
    /// If the buffer is not host-visible or too small: a mistake of the caller.
    pub fn read<T: bytemuck::Pod>(&self, count: usize) -> Vec<T> {
        let mapped = self.held.allocation.as_ref().and_then(Allocation::mapped_slice);
        let bytes = &mapped.expect("the buffer is host-visible")[..count * size_of::<T>()];
        bytemuck::pod_collect_to_vec(bytes)
    }
}

impl Drop for BufferMemory {
    fn drop(&mut self) {
        let memory = self.allocation.take().map(Object::Memory);
        self.device.retire([Object::Buffer(self.raw)].into_iter().chain(memory));
    }
}
