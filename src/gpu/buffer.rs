//! A buffer with its memory.

use std::sync::Arc;

use ash::vk;
use gpu_allocator::MemoryLocation;
use gpu_allocator::vulkan::{Allocation, AllocationCreateDesc, AllocationScheme};

use super::retired::Object;
use super::{Commands, Device, Named, copy_buffer, unless_none};
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

/// The window that every card has into its memory, bytes: system and driver need it, too.
const SMALL_WINDOW: u64 = 256 << 20;

/// Whether what the host writes, each frame or once, is best written to the device's own memory: where all of that can be
/// written, or more than the small window of a card without a resizable one; or where there is no other.
pub(super) fn writes_to_device(memory: &vk::PhysicalDeviceMemoryProperties) -> bool {
    use vk::MemoryPropertyFlags as Flags;
    let written = Flags::HOST_VISIBLE | Flags::HOST_COHERENT;
    let mut types =
        memory.memory_types_as_slice().iter().filter(|of| of.property_flags.contains(written));
    let heap = |of: &vk::MemoryType| memory.memory_heaps[of.heap_index as usize].size;
    let is_own = |of: &&vk::MemoryType| of.property_flags.contains(Flags::DEVICE_LOCAL);
    let has_others = types.clone().any(|of| !is_own(&of));
    types.any(|of| is_own(&of) && (heap(of) > SMALL_WINDOW || !has_others))
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
        let is_read =
            device.unless_none.is_some() && usage.contains(vk::BufferUsageFlags::INDIRECT_BUFFER);
        let usage = if is_read { usage | unless_none::USAGE } else { usage };
        let info = vk::BufferCreateInfo::default().size(size).usage(usage);
        // SAFETY: `info` is valid; the handle is owned by the value made here.
        let raw = unsafe { device.raw.create_buffer(&info, None) }.named("vkCreateBuffer", name)?;
        let mut held = BufferMemory { raw, allocation: None, device: device.clone() };
        device.name(raw, name);
        // SAFETY: the buffer was just made.
        let requirements = unsafe { device.raw.get_buffer_memory_requirements(raw) };
        let location = match memory {
            Memory::Device => MemoryLocation::GpuOnly,
            // The allocator takes the device's own memory for it, where it can.
            Memory::Upload if device.report.writes_to_device => MemoryLocation::CpuToGpu,
            // The host's, of which the allocator has no other name.
            Memory::Upload => MemoryLocation::GpuToCpu,
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
    /// See [`Buffer::new`].
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
    /// See [`Buffer::new`] and [`Commands::once`].
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
    /// See [`Buffer::new`].
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

#[cfg(test)]
mod tests {
    use vk::MemoryPropertyFlags as Flags;

    use super::*;

    /// A device's memory: heaps in MiB, types by heap and properties.
    fn memory(heaps: &[u64], types: &[(u32, Flags)]) -> vk::PhysicalDeviceMemoryProperties {
        let mut of = vk::PhysicalDeviceMemoryProperties {
            memory_heap_count: heaps.len() as u32,
            memory_type_count: types.len() as u32,
            ..Default::default()
        };
        for (heap, mebibytes) in of.memory_heaps.iter_mut().zip(heaps) {
            heap.size = mebibytes << 20;
        }
        for (of, (heap_index, property_flags)) in of.memory_types.iter_mut().zip(types) {
            *of = vk::MemoryType { property_flags: *property_flags, heap_index: *heap_index };
        }
        of
    }

    #[test]
    fn the_host_writes_to_the_device_where_its_window_is_large() {
        let (own, host) = (Flags::DEVICE_LOCAL, Flags::HOST_VISIBLE | Flags::HOST_COHERENT);
        let types = [(0, own), (1, host), (1, host | Flags::HOST_CACHED), (2, own | host)];
        // A card with the window of old, with a larger one, with one over all of its memory, and without one.
        assert!(!writes_to_device(&memory(&[8192, 16384, 256], &types)));
        assert!(writes_to_device(&memory(&[8192, 16384, 257], &types)));
        let over_all = [(0, own), (1, host), (0, own | host)];
        assert!(writes_to_device(&memory(&[8192, 16384], &over_all)));
        assert!(!writes_to_device(&memory(&[8192, 16384], &over_all[..2])));
        // One memory for both, however small.
        assert!(writes_to_device(&memory(&[128], &[(0, own | host)])));
    }
}
