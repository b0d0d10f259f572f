//! What a shader reads and writes: a descriptor set, written once when its resources are made.
//!
//! Plain sets rather than push descriptors: SwiftShader has none, and nothing here is rebound
//! within a frame.

use std::any::Any;
use std::sync::{Arc, Mutex, PoisonError};

use ash::vk;

use super::requirements::STORAGE_BUFFERS;
use super::retired::Object;
use super::{Buffer, Device, Image, Named, Recorder, Sampler, Texels};
use crate::Result;

/// What is too large for one binding of a device, of [`crate::Error::Limit`].
pub(crate) const BUFFER_BYTES: &str = "the bytes of a storage buffer";

/// What kind of resource fills a slot.
pub type Binding = vk::DescriptorType;

/// One slot of a set. Those of our shaders are in [`super::sets`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Slot {
    number: u32,
    kind: Binding,
}

impl Slot {
    /// Binding `number`.
    pub const fn new(number: u32, kind: Binding) -> Self {
        Self { number, kind }
    }
}

/// What fills a slot.
pub enum Resource<'a> {
    /// A uniform or storage buffer, whole.
    Buffer(&'a Buffer),
    /// A byte range of a storage buffer.
    Range(&'a Buffer, u64, u64),
    /// A buffer read by texels.
    Texels(&'a Texels),
    /// One level of an image, for storage.
    Storage(&'a Image, u32),
    /// Every level of an image, with a sampler.
    Sampled(&'a Image, &'a Sampler),
    /// One level of an image, with a sampler.
    SampledLevel(&'a Image, u32, &'a Sampler),
    /// A byte range of a host's storage buffer, which the set does not keep.
    HostRange(vk::Buffer, u64, u64),
    /// A view of a host's image, which the set does not keep, with a sampler.
    SampledView(vk::ImageView, &'a Sampler),
}

/// The layout of a set with the given slots, visible to all stages.
pub(super) fn set_layout(
    device: &ash::Device,
    name: &str,
    slots: &[Slot],
) -> Result<vk::DescriptorSetLayout> {
    let layout_bindings: Vec<_> = slots
        .iter()
        .map(|slot| {
            vk::DescriptorSetLayoutBinding::default()
                .binding(slot.number)
                .descriptor_type(slot.kind)
                .descriptor_count(1)
                .stage_flags(
                    vk::ShaderStageFlags::COMPUTE
                        | vk::ShaderStageFlags::VERTEX
                        | vk::ShaderStageFlags::FRAGMENT,
                )
        })
        .collect();
    let info = vk::DescriptorSetLayoutCreateInfo::default().bindings(&layout_bindings);
    // SAFETY: `info` outlives the call.
    unsafe { device.create_descriptor_set_layout(&info, None) }
        .named("vkCreateDescriptorSetLayout", name)
}

/// Keeps something of the device.
type Held = Arc<dyn Any + Send + Sync>;

impl Resource<'_> {
    /// What must live as long as a set with it.
    fn held(&self) -> [Option<Held>; 2] {
        match *self {
            Self::Buffer(buffer) | Self::Range(buffer, ..) => [Some(buffer.held.clone()), None],
            Self::Texels(texels) => [Some(texels.held.clone()), None],
            Self::Storage(image, _) => [Some(image.held.clone()), None],
            Self::Sampled(image, sampler) | Self::SampledLevel(image, _, sampler) => {
                [Some(image.held.clone()), Some(sampler.held.clone())]
            }
            Self::SampledView(_, sampler) => [Some(sampler.held.clone()), None],
            Self::HostRange(..) => [None, None],
        }
    }
}

/// A layout and one or more sets of it, which keep what they hold. They are set 0 of their pipelines, or set 1 beside what
/// several share.
pub struct Bindings {
    shared: Option<Arc<Bindings>>,
    layout: vk::DescriptorSetLayout,
    pool: vk::DescriptorPool,
    sets: Vec<vk::DescriptorSet>,
    slots: Vec<Slot>,
    /// What each slot of each set holds.
    held: Mutex<Vec<[Option<Held>; 2]>>,
    device: Arc<Device>,
}

impl Bindings {
    /// Makes `count` sets with the given slots, visible to all stages.
    ///
    /// # Errors
    /// [`crate::Error::Vulkan`] if the driver refuses.
    pub fn new(device: &Arc<Device>, name: &str, slots: &[Slot], count: u32) -> Result<Self> {
        let mut bindings = Self {
            shared: None,
            layout: vk::DescriptorSetLayout::null(),
            pool: vk::DescriptorPool::null(),
            sets: Vec::new(),
            slots: slots.to_vec(),
            held: Mutex::new(vec![[None, None]; slots.len() * count as usize]),
            device: device.clone(),
        };
        // `bindings` owns the handle.
        bindings.layout = set_layout(&device.raw, name, slots)?;
        let sizes: Vec<_> = slots
            .iter()
            .map(|slot| vk::DescriptorPoolSize { ty: slot.kind, descriptor_count: count })
            .collect();
        let info = vk::DescriptorPoolCreateInfo::default().pool_sizes(&sizes).max_sets(count);
        // SAFETY: `info` outlives the call; `bindings` owns the handle.
        bindings.pool = unsafe { device.raw.create_descriptor_pool(&info, None) }
            .named("vkCreateDescriptorPool", name)?;
        let layouts = vec![bindings.layout; count as usize];
        let info = vk::DescriptorSetAllocateInfo::default()
            .descriptor_pool(bindings.pool)
            .set_layouts(&layouts);
        // SAFETY: the pool was made for just these sets.
        bindings.sets = unsafe { device.raw.allocate_descriptor_sets(&info) }
            .named("vkAllocateDescriptorSets", name)?;
        for set in &bindings.sets {
            device.name(*set, name);
        }
        Ok(bindings)
    }

    /// Makes these set 1 of pipelines whose set 0 is the first of `shared`.
    pub fn beside(mut self, shared: &Arc<Self>) -> Self {
        self.shared = Some(shared.clone());
        let slots = self.slots().concat();
        let storage = slots.iter().filter(|slot| slot.kind == Binding::STORAGE_BUFFER).count();
        debug_assert!(storage <= STORAGE_BUFFERS as usize, "{storage} storage buffers");
        // What a stage takes on any device.
        let sampled = [Binding::UNIFORM_TEXEL_BUFFER, Binding::COMBINED_IMAGE_SAMPLER];
        let sampled = slots.iter().filter(|slot| sampled.contains(&slot.kind)).count();
        debug_assert!(sampled <= 16, "{sampled} sampled images");
        // With a fifth, two could be beyond what lavapipe of Mesa 22.3 takes (docs/upstream.md).
        let uniform = slots.iter().filter(|slot| slot.kind == Binding::UNIFORM_BUFFER).count();
        debug_assert!(uniform <= 4, "{uniform} uniform buffers");
        self
    }

    /// The sets of a pipeline, the shared one first.
    fn sets(&self) -> impl Iterator<Item = &Self> {
        self.shared.as_deref().into_iter().chain([self])
    }

    /// The slots of each of a pipeline's sets.
    pub(super) fn slots(&self) -> Vec<Vec<Slot>> {
        self.sets().map(|set| set.slots.clone()).collect()
    }

    /// Their layouts.
    pub(super) fn layouts(&self) -> Vec<vk::DescriptorSetLayout> {
        self.sets().map(|set| set.layout).collect()
    }

    /// One set, filled with a resource for each slot.
    ///
    /// # Errors
    /// [`crate::Error::Vulkan`] if the driver refuses; those of [`Bindings::write`].
    pub fn of(device: &Arc<Device>, name: &str, slots: &[(Slot, Resource<'_>)]) -> Result<Self> {
        Self::all(device, name, slots, 1)
    }

    /// Like [`Bindings::of`], `count` sets that are alike.
    ///
    /// # Errors
    /// See [`Bindings::of`].
    pub fn all(
        device: &Arc<Device>,
        name: &str,
        slots: &[(Slot, Resource<'_>)],
        count: u32,
    ) -> Result<Self> {
        let each: Vec<_> = slots.iter().map(|(slot, _)| *slot).collect();
        let bindings = Self::new(device, name, &each, count)?;
        (0..count).try_for_each(|index| bindings.fill(index, slots))?;
        Ok(bindings)
    }

    /// Like [`Bindings::of`], `count` sets, one at least: `slots` has what fills each by its number.
    ///
    /// # Errors
    /// See [`Bindings::of`].
    pub fn each<'a, const N: usize>(
        device: &Arc<Device>,
        name: &str,
        count: u32,
        slots: impl Fn(u32) -> [(Slot, Resource<'a>); N],
    ) -> Result<Self> {
        let bindings = Self::new(device, name, &slots(0).map(|(slot, _)| slot), count)?;
        (0..count).try_for_each(|index| bindings.fill(index, &slots(index)))?;
        Ok(bindings)
    }

    /// One set like the first of these but for `slots`, beside it: commands that have that one keep it.
    ///
    /// # Errors
    /// See [`Bindings::of`].
    pub fn but(&self, name: &str, slots: &[(Slot, Resource<'_>)]) -> Result<Self> {
        let mut other = Self::new(&self.device, name, &self.slots, 1)?;
        other.shared.clone_from(&self.shared);
        let copies: Vec<_> = self
            .slots
            .iter()
            .map(|slot| {
                vk::CopyDescriptorSet::default()
                    .src_set(self.sets[0])
                    .src_binding(slot.number)
                    .dst_set(other.sets[0])
                    .dst_binding(slot.number)
                    .descriptor_count(1)
            })
            .collect();
        // SAFETY: the sets are alike; no commands have the new one yet.
        unsafe { self.device.raw.update_descriptor_sets(&[], &copies) };
        {
            let held = self.held.lock().unwrap_or_else(PoisonError::into_inner);
            let copied = held[..self.slots.len()].to_vec();
            *other.held.lock().unwrap_or_else(PoisonError::into_inner) = copied;
        }
        other.fill(0, slots)?;
        Ok(other)
    }

    fn fill(&self, index: u32, slots: &[(Slot, Resource<'_>)]) -> Result<()> {
        slots.iter().try_for_each(|(slot, resource)| {
            // SAFETY: no commands have it yet.
            unsafe { self.write(index as usize, *slot, resource) }
        })
    }

    /// Fills `slot`, which it was made with, of set `index`.
    ///
    /// # Errors
    /// [`crate::Error::Limit`] if a storage buffer is bound whole that is longer than a binding may be.
    ///
    /// # Safety
    /// The set must not be in use: neither by the device, nor by commands that are yet to be submitted.
    pub unsafe fn write(&self, index: usize, slot: Slot, resource: &Resource<'_>) -> Result<()> {
        let Slot { number, kind } = slot;
        let place = self.slots.iter().position(|one| *one == slot);
        let place = place.unwrap_or_else(|| panic!("a set without binding {number}"));
        let write = vk::WriteDescriptorSet::default()
            .dst_set(self.sets[index])
            .dst_binding(number)
            .descriptor_type(kind);
        let buffer = |buffer: &Buffer, offset, range| {
            [vk::DescriptorBufferInfo { buffer: buffer.raw, offset, range }]
        };
        let image = |image_view, image_layout, sampler: Option<&Sampler>| {
            let sampler = sampler.map_or(vk::Sampler::null(), |sampler| sampler.raw);
            [vk::DescriptorImageInfo { sampler, image_view, image_layout }]
        };
        let sampled = vk::ImageLayout::SHADER_READ_ONLY_OPTIMAL;
        let buffers;
        let images;
        let views;
        let write = match *resource {
            Resource::Buffer(b) => {
                let limit = self.device.report.limits.max_storage_buffer_range.into();
                if kind == Binding::STORAGE_BUFFER {
                    self.device.report.check_limit(BUFFER_BYTES, b.size, limit)?;
                }
                buffers = buffer(b, 0, vk::WHOLE_SIZE);
                write.buffer_info(&buffers)
            }
            Resource::Range(b, offset, range) => {
                buffers = buffer(b, offset, range);
                write.buffer_info(&buffers)
            }
            Resource::HostRange(buffer, offset, range) => {
                buffers = [vk::DescriptorBufferInfo { buffer, offset, range }];
                write.buffer_info(&buffers)
            }
            Resource::Texels(texels) => {
                views = [texels.view];
                write.texel_buffer_view(&views)
            }
            Resource::Storage(i, level) => {
                images = image(i.level_view(level), vk::ImageLayout::GENERAL, None);
                write.image_info(&images)
            }
            Resource::Sampled(i, sampler) => {
                images = image(i.view(), sampled, Some(sampler));
                write.image_info(&images)
            }
            Resource::SampledView(view, sampler) => {
                images = image(view, sampled, Some(sampler));
                write.image_info(&images)
            }
            Resource::SampledLevel(i, level, sampler) => {
                images = image(i.level_view(level), sampled, Some(sampler));
                write.image_info(&images)
            }
        };
        // SAFETY: the resources are alive, and by contract the set is not in use.
        unsafe { self.device.raw.update_descriptor_sets(&[write], &[]) };
        let place = index * self.slots.len() + place;
        self.held.lock().unwrap_or_else(PoisonError::into_inner)[place] = resource.held();
        Ok(())
    }

    /// Binds set `index` at `bind_point`, and the shared one.
    pub(super) fn bind(
        &self,
        commands: Recorder<'_>,
        bind_point: vk::PipelineBindPoint,
        layout: vk::PipelineLayout,
        index: usize,
    ) {
        let sets: Vec<_> = self.shared.iter().map(|shared| shared.sets[0]).collect();
        let sets = [&sets[..], &[self.sets[index]]].concat();
        // SAFETY: the layout was made from these sets' layouts; the command buffer is recorded.
        unsafe {
            self.device.raw.cmd_bind_descriptor_sets(
                commands.raw(),
                bind_point,
                layout,
                0,
                &sets,
                &[],
            );
        }
    }
}

impl Drop for Bindings {
    fn drop(&mut self) {
        let layout = Object::DescriptorSetLayout(self.layout);
        self.device.retire([Object::DescriptorPool(self.pool), layout]);
    }
}
