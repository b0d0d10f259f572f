//! What all drops of a host's in a buffer of its own have in common, whatever their values are (`glsl/include/host_records.glsl`):
//! where these stand, how many drops the buffer holds, and what cannot be read.

use ash::vk;

use crate::gpu::{Bindings, Device, Resource, Slot};
use crate::{Error, Result};

/// In the place of a word's number: there is none.
const NOTHING: u32 = u32::MAX;

/// How many particles or drops there are.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ParticleCount {
    /// So many.
    Number(u32),
    /// The 32 bits at an offset in bytes of this buffer, when the commands are executed.
    OnDevice(vk::Buffer, u64),
}

/// A record's value: its name, where it begins in bytes from the record's start, and how many it takes.
pub(crate) type Value = (&'static str, u32, u32);

/// Records of a host's.
pub(crate) struct Records {
    /// What they are, for messages.
    pub what: &'static str,
    pub buffer: vk::Buffer,
    /// Bytes before the first one, those that may be read from there on, and those from one to the next.
    pub offset: u64,
    pub bytes: u64,
    pub stride: u32,
    pub values: [Option<Value>; 4],
    pub count: ParticleCount,
    /// So many at most are taken.
    pub most: u32,
}

/// Where shaders find them, in words.
pub(crate) struct Words {
    pub start: u32,
    pub stride: u32,
    pub count: u32,
    pub count_at: u32,
    /// So many the buffer holds, of those that are taken.
    pub capacity: u32,
}

/// A value's place as shaders have it.
pub(crate) fn word(byte: Option<u32>) -> u32 {
    byte.map_or(NOTHING, |byte| byte / 4)
}

impl Records {
    /// Bytes from a record's start to the end of its last value.
    fn end(&self) -> u32 {
        let values = self.values.iter().flatten();
        values.map(|(_, at, bytes)| at.saturating_add(*bytes)).max().unwrap_or_default()
    }

    fn capacity(&self) -> u32 {
        let beside = self.bytes.saturating_sub(self.end().into());
        let held = beside / u64::from(self.stride) + 1;
        held.min(self.most.into()) as u32
    }

    /// What of the buffer is bound, offset and bytes, and where in it the first record begins.
    fn range(&self, device: &Device) -> (u64, u64, u64) {
        let used = u64::from(self.capacity() - 1) * u64::from(self.stride) + u64::from(self.end());
        aligned(device, self.offset, used)
    }

    /// Refuses what cannot be read.
    pub fn check(&self, device: &Device) -> Result<()> {
        let refuse = |problem: String| Err(Error::scene(self.what, problem));
        let stride = self.stride;
        if stride == 0 || !stride.is_multiple_of(4) || !self.offset.is_multiple_of(4) {
            return refuse(format!(
                "offset {} or stride {stride} is no multiple of 4, or 0 bytes from one to the next",
                self.offset
            ));
        }
        for (name, at, bytes) in self.values.iter().flatten() {
            if !at.is_multiple_of(4) || at.saturating_add(*bytes) > stride {
                return refuse(format!(
                    "{name} at byte {at} takes {bytes}: it begins at no multiple of 4, or ends beyond the stride, {stride}"
                ));
            }
        }
        if self.bytes < self.end().into() {
            return refuse(format!(
                "{} bytes of their buffer hold not one, which ends at byte {}",
                self.bytes,
                self.end()
            ));
        }
        let is_null = |buffer: &vk::Buffer| *buffer == vk::Buffer::null();
        match &self.count {
            ParticleCount::OnDevice(buffer, at) if is_null(buffer) || !at.is_multiple_of(4) => {
                return refuse(format!(
                    "their count is in no buffer, or at byte {at}, no multiple of 4"
                ));
            }
            _ if is_null(&self.buffer) => return refuse("their buffer is null".into()),
            _ => {}
        }
        let (_, range, _) = self.range(device);
        let limit = device.report.limits.max_storage_buffer_range.into();
        device.report.check_limit("the bytes of a host's drops", range, limit)
    }

    /// Fills a set with the buffers of records and count.
    ///
    /// # Errors
    /// See [`Bindings::write`].
    ///
    /// # Safety
    /// The set is not in use, and the buffers live until it is no more.
    pub unsafe fn set_buffers(
        &self,
        device: &Device,
        bindings: &Bindings,
        set: usize,
        slots: [Slot; 2],
    ) -> Result<()> {
        let (offset, bytes, _) = self.range(device);
        let count = match self.count {
            ParticleCount::Number(_) => (self.buffer, offset, bytes),
            ParticleCount::OnDevice(buffer, at) => {
                let (offset, bytes, _) = aligned(device, at, 4);
                (buffer, offset, bytes)
            }
        };
        let ranges = slots.into_iter().zip([(self.buffer, offset, bytes), count]);
        ranges.into_iter().try_for_each(|(slot, (buffer, offset, bytes))| {
            // SAFETY: by contract.
            unsafe { bindings.write(set, slot, &Resource::HostRange(buffer, offset, bytes)) }
        })
    }

    /// Where shaders find them.
    pub fn words(&self, device: &Device) -> Words {
        let (count, count_at) = match self.count {
            ParticleCount::Number(count) => (count, NOTHING),
            ParticleCount::OnDevice(_, at) => (0, (aligned(device, at, 4).2 / 4) as u32),
        };
        let start = (self.range(device).2 / 4) as u32;
        Words { start, stride: self.stride / 4, count, count_at, capacity: self.capacity() }
    }
}

/// A range of a buffer that can be bound, and where what was asked for begins in it.
fn aligned(device: &Device, offset: u64, bytes: u64) -> (u64, u64, u64) {
    let alignment = device.report.limits.min_storage_buffer_offset_alignment.max(4);
    let beside = offset % alignment;
    (offset - beside, bytes + beside, beside)
}
