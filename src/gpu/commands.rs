//! One command buffer that is recorded, submitted and waited for, over and over.

use std::marker::PhantomData;
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

use ash::vk;

use super::{Device, Named};
use crate::Result;

/// A command buffer with a timeline semaphore that counts its submissions.
pub struct Commands {
    pool: vk::CommandPool,
    raw: vk::CommandBuffer,
    timeline: vk::Semaphore,
    submitted: u64,
    /// Ticket of what is being recorded (`retired.rs`), and of what is submitted; 0: none.
    recording: u64,
    pending: AtomicU64,
    device: Arc<Device>,
}

/// Commands that are being recorded, as long as they may be.
#[derive(Clone, Copy)]
pub struct Recorder<'a> {
    raw: vk::CommandBuffer,
    of: PhantomData<&'a mut Commands>,
}

impl Recorder<'_> {
    /// A host's command buffer.
    ///
    /// # Safety
    /// It is being recorded, outside of any rendering, as long as this or a copy of it is used.
    pub(crate) unsafe fn of_host(raw: vk::CommandBuffer) -> Self {
        Self { raw, of: PhantomData }
    }

    /// The raw handle.
    pub fn raw(self) -> vk::CommandBuffer {
        self.raw
    }
}

impl Commands {
    /// An empty command buffer.
    ///
    /// # Errors
    /// [`crate::Error::Vulkan`] if the driver refuses.
    pub fn new(device: &Arc<Device>, name: &str) -> Result<Self> {
        let mut commands = Self {
            pool: vk::CommandPool::null(),
            raw: vk::CommandBuffer::null(),
            timeline: vk::Semaphore::null(),
            submitted: 0,
            recording: 0,
            pending: AtomicU64::new(0),
            device: device.clone(),
        };
        let info = vk::CommandPoolCreateInfo::default()
            .queue_family_index(device.queue_family)
            .flags(vk::CommandPoolCreateFlags::TRANSIENT);
        // SAFETY: valid info; `commands` owns the handle.
        commands.pool = unsafe { device.raw.create_command_pool(&info, None) }
            .named("vkCreateCommandPool", name)?;
        let info = vk::CommandBufferAllocateInfo::default()
            .command_pool(commands.pool)
            .command_buffer_count(1);
        // SAFETY: the pool is alive; one buffer is asked for, so one is returned.
        commands.raw = unsafe { device.raw.allocate_command_buffers(&info) }
            .named("vkAllocateCommandBuffers", name)?[0];
        device.name(commands.raw, name);
        let mut kind =
            vk::SemaphoreTypeCreateInfo::default().semaphore_type(vk::SemaphoreType::TIMELINE);
        let info = vk::SemaphoreCreateInfo::default().push_next(&mut kind);
        // SAFETY: valid info; `commands` owns the handle.
        commands.timeline =
            unsafe { device.raw.create_semaphore(&info, None) }.named("vkCreateSemaphore", name)?;
        device.name(commands.timeline, name);
        Ok(commands)
    }

    /// Records, submits and waits: for work that is done once.
    ///
    /// # Errors
    /// [`crate::Error::Vulkan`] if making, recording, submitting or waiting fails, as for a lost device.
    pub fn once(device: &Arc<Device>, name: &str, record: impl FnOnce(Recorder<'_>)) -> Result<()> {
        let mut commands = Self::new(device, name)?;
        record(commands.begin()?);
        let _long_job = device.long_job();
        commands.submit()?;
        commands.wait()
    }

    /// Waits for the last submission and starts recording anew.
    ///
    /// # Errors
    /// [`crate::Error::Vulkan`] if waiting fails, as for a lost device, or recording cannot begin.
    pub fn begin(&mut self) -> Result<Recorder<'_>> {
        self.wait()?;
        // What was recorded and never submitted is thrown away.
        self.device.close_ticket(std::mem::replace(&mut self.recording, self.device.open_ticket()));
        let info = vk::CommandBufferBeginInfo::default()
            .flags(vk::CommandBufferUsageFlags::ONE_TIME_SUBMIT);
        // SAFETY: the buffer is not in use: its last submission was waited for.
        unsafe {
            self.device
                .raw
                .reset_command_pool(self.pool, vk::CommandPoolResetFlags::empty())
                .named("vkResetCommandPool", "the frame")?;
            self.device
                .raw
                .begin_command_buffer(self.raw, &info)
                .named("vkBeginCommandBuffer", "the frame")?;
        }
        Ok(Recorder { raw: self.raw, of: PhantomData })
    }

    /// Ends recording and hands the work to the queue.
    ///
    /// # Errors
    /// [`crate::Error::Vulkan`] if recording cannot end or the queue refuses, as for a lost device.
    pub fn submit(&mut self) -> Result<()> {
        self.submit_between(None, None)
    }

    /// Like [`Commands::submit`]; colour attachments wait for one semaphore, and another is signalled
    /// when all is done.
    pub(super) fn submit_between(
        &mut self,
        wait: Option<vk::Semaphore>,
        signal: Option<vk::Semaphore>,
    ) -> Result<()> {
        // SAFETY: recording was begun.
        unsafe { self.device.raw.end_command_buffer(self.raw) }
            .named("vkEndCommandBuffer", "the frame")?;
        let commands = [vk::CommandBufferSubmitInfo::default().command_buffer(self.raw)];
        let at = |semaphore, stage| {
            vk::SemaphoreSubmitInfo::default().semaphore(semaphore).stage_mask(stage)
        };
        let output = vk::PipelineStageFlags2::COLOR_ATTACHMENT_OUTPUT;
        let waits: Vec<_> = wait.into_iter().map(|semaphore| at(semaphore, output)).collect();
        let all = vk::PipelineStageFlags2::ALL_COMMANDS;
        let mut signals = vec![at(self.timeline, all).value(self.submitted + 1)];
        signals.extend(signal.map(|semaphore| at(semaphore, all)));
        let info = [vk::SubmitInfo2::default()
            .wait_semaphore_infos(&waits)
            .command_buffer_infos(&commands)
            .signal_semaphore_infos(&signals)];
        let raw = &self.device.raw;
        self.device
            .with_queue(|queue| {
                // SAFETY: the command buffer is executable; nobody else uses the queue.
                unsafe { raw.queue_submit2(queue, &info, vk::Fence::null()) }
            })
            .named("vkQueueSubmit2", &self.device.report.name)?;
        self.submitted += 1;
        self.pending.store(std::mem::take(&mut self.recording), Ordering::Relaxed);
        Ok(())
    }

    /// Waits until the last submission is done.
    ///
    /// # Errors
    /// [`crate::Error::Vulkan`] if waiting fails, as for a lost device.
    pub fn wait(&self) -> Result<()> {
        // Nor may a semaphore be waited for that could not be made.
        if self.submitted == 0 {
            return Ok(());
        }
        let (semaphores, values) = ([self.timeline], [self.submitted]);
        let info = vk::SemaphoreWaitInfo::default().semaphores(&semaphores).values(&values);
        // SAFETY: the semaphore is alive and will be signalled with this value.
        unsafe { self.device.raw.wait_semaphores(&info, u64::MAX) }
            .named("vkWaitSemaphores", &self.device.report.name)?;
        self.device.close_ticket(self.pending.swap(0, Ordering::Relaxed));
        Ok(())
    }
}

impl Drop for Commands {
    fn drop(&mut self) {
        // A lost device cannot be waited for; its objects are destroyed all the same.
        if self.wait().is_err() {
            let _ = self.device.wait_idle();
        }
        // SAFETY: the last submission is done (or the device lost).
        unsafe {
            self.device.raw.destroy_semaphore(self.timeline, None);
            self.device.raw.destroy_command_pool(self.pool, None);
        }
        for ticket in [self.recording, self.pending.load(Ordering::Relaxed)] {
            self.device.close_ticket(ticket);
        }
    }
}
