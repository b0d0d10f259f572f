//! What was dropped while the queue, or commands that are being recorded, may still use it: it is freed when they are
//! done. So whoever drops something need not wait.
//!
//! Commands have a ticket from the moment that they begin to be recorded until the queue is done with them, or they
//! are thrown away. What is dropped is freed once every ticket is closed that was open then.

use std::collections::{BTreeSet, VecDeque};
use std::sync::PoisonError;

use ash::vk;
use gpu_allocator::vulkan::Allocation;

use super::Device;

/// Something of a device that no one owns any more.
pub(super) enum Object {
    Buffer(vk::Buffer),
    BufferView(vk::BufferView),
    Image(vk::Image),
    ImageView(vk::ImageView),
    Sampler(vk::Sampler),
    DescriptorPool(vk::DescriptorPool),
    DescriptorSetLayout(vk::DescriptorSetLayout),
    QueryPool(vk::QueryPool),
    /// The memory of an object that is freed before it.
    Memory(Allocation),
}

/// Open tickets, and what waits for them, in the order in which it was dropped.
#[derive(Default)]
pub(super) struct Retired {
    tickets: u64,
    open: BTreeSet<u64>,
    waiting: VecDeque<(u64, Object)>,
}

impl Retired {
    /// What need not wait any longer.
    fn freed(&mut self) -> Vec<Object> {
        let first_open = self.open.first().copied().unwrap_or(u64::MAX);
        let count = self.waiting.partition_point(|(last_ticket, _)| *last_ticket < first_open);
        self.waiting.drain(..count).map(|(_, object)| object).collect()
    }
}

impl Device {
    /// A ticket for commands that begin to be recorded.
    pub(crate) fn open_ticket(&self) -> u64 {
        let mut retired = self.retired.lock().unwrap_or_else(PoisonError::into_inner);
        retired.tickets += 1;
        let ticket = retired.tickets;
        retired.open.insert(ticket);
        ticket
    }

    /// The commands of a ticket are done, or will never be submitted.
    pub(crate) fn close_ticket(&self, ticket: u64) {
        self.free_after(|retired| {
            retired.open.remove(&ticket);
        });
    }

    /// Frees objects as soon as no commands use them.
    pub(super) fn retire(&self, objects: impl IntoIterator<Item = Object>) {
        self.free_after(|retired| {
            let last = retired.tickets;
            retired.waiting.extend(objects.into_iter().map(|object| (last, object)));
        });
    }

    /// Frees all that waits. No commands are left that use it.
    pub(super) fn free_all(&self) {
        self.free_after(|retired| retired.open.clear());
    }

    /// Frees what need not wait any longer after a change.
    fn free_after(&self, change: impl FnOnce(&mut Retired)) {
        let mut retired = self.retired.lock().unwrap_or_else(PoisonError::into_inner);
        change(&mut retired);
        let freed = retired.freed();
        // Freeing takes other locks.
        drop(retired);
        for object in freed {
            // SAFETY: no one owns it, and no commands that may use it are left; null is ignored.
            unsafe {
                match object {
                    Object::Buffer(raw) => self.raw.destroy_buffer(raw, None),
                    Object::BufferView(raw) => self.raw.destroy_buffer_view(raw, None),
                    Object::Image(raw) => self.raw.destroy_image(raw, None),
                    Object::ImageView(raw) => self.raw.destroy_image_view(raw, None),
                    Object::Sampler(raw) => self.raw.destroy_sampler(raw, None),
                    Object::DescriptorPool(raw) => self.raw.destroy_descriptor_pool(raw, None),
                    Object::DescriptorSetLayout(raw) => {
                        self.raw.destroy_descriptor_set_layout(raw, None);
                    }
                    Object::QueryPool(raw) => self.raw.destroy_query_pool(raw, None),
                    // Freeing fails only for memory of another allocator.
                    Object::Memory(allocation) => drop(self.allocator().free(allocation)),
                }
            }
        }
    }
}
