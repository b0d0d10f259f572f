//! The canary's canary: a mistake on purpose must make `expect_silence` fail. Without these, silence
//! under validation could mean that nobody listens.

use std::sync::Arc;

use ash::vk;
use raindrops::gpu::sets::{constant, order_large as slot};
use raindrops::gpu::{
    Bindings, Buffer, Commands, ComputePipeline, Device, Instance, Memory, Resource, Slot, Use,
    memory_barrier, shaders,
};

/// Runs `mistake` on a device and returns what `expect_silence` says, or nothing if it is content.
fn complaint(mistake: impl FnOnce(&Arc<Device>)) -> Option<String> {
    let _alone = crate::common::layer::alone();
    let instance = crate::common::validated_instance();
    let device = open(&instance);
    mistake(&device);
    drop(device);
    instance.expect_silence().err().map(|error| error.to_string())
}

fn open(instance: &Arc<Instance>) -> Arc<Device> {
    Device::open(instance, crate::common::chosen(instance)).expect("a device")
}

#[test]
fn silence_is_silence() {
    assert_eq!(complaint(|device| device.wait_idle().expect("an idle device")), None);
}

/// While renderers are prepared on one thread, another draws and waits for the device.
#[test]
fn threads_share_the_queue() {
    let said = complaint(|device| {
        let (idle, submitting) = (device.clone(), device.clone());
        let threads = [
            std::thread::spawn(move || (0..2000).try_for_each(|_| idle.wait_idle())),
            std::thread::spawn(move || {
                (0..2000).try_for_each(|_| Commands::once(&submitting, "canary", |_| {}))
            }),
        ];
        for thread in threads {
            thread.join().expect("no panic").expect("both go on");
        }
    });
    assert_eq!(said, None);
}

#[test]
fn wrong_usage_is_named() {
    let said = complaint(|device| {
        let buffer = |usage| {
            Buffer::new(device, "canary", 64, usage, Memory::Device).expect("a small buffer")
        };
        let from = buffer(vk::BufferUsageFlags::STORAGE_BUFFER); // not TRANSFER_SRC
        let to = buffer(vk::BufferUsageFlags::TRANSFER_DST);
        Commands::once(device, "canary", |commands| {
            let region = [vk::BufferCopy { src_offset: 0, dst_offset: 0, size: 64 }];
            // SAFETY: drivers copy between such buffers all the same; only the usage is undeclared.
            unsafe { device.raw().cmd_copy_buffer(commands.raw(), from.raw(), to.raw(), &region) };
        })
        .expect("a copy");
    });
    let said = said.expect("a copy from a buffer that is no source must be told");
    assert!(said.contains("VUID-vkCmdCopyBuffer-srcBuffer"), "{said}");
    assert!(said.contains("canary"), "objects are named in messages: {said}");
}

/// Two fills of one buffer: a write after a write, with or without the barrier between them.
fn two_fills(with_barrier: bool) -> Option<String> {
    complaint(|device| {
        let usage = vk::BufferUsageFlags::TRANSFER_DST;
        let buffer = Buffer::new(device, "canary", 64, usage, Memory::Device).expect("a buffer");
        Commands::once(device, "canary", |commands| {
            for value in [1, 2] {
                // SAFETY: the buffer is alive; the order of the fills matters to nobody.
                unsafe {
                    device.raw().cmd_fill_buffer(commands.raw(), buffer.raw(), 0, 64, value);
                }
                if with_barrier {
                    let write = [Use::TransferWrite];
                    memory_barrier(device, commands, &write, &write);
                }
            }
        })
        .expect("two fills");
    })
}

#[test]
fn missing_barrier_between_fills_is_a_hazard() {
    let said = two_fills(false).expect("a write after a write must be told");
    assert!(said.contains("SYNC-HAZARD-WRITE"), "{said}");
    assert_eq!(two_fills(true), None, "with the barrier there is no hazard");
}

/// What order_large.comp takes.
const SLOTS: [Slot; 5] =
    [slot::LARGE_DROPS, slot::LARGE_INDEX, slot::COUNTERS, slot::ORDERED, slot::ARGUMENTS];
const CONSTANTS: [[u32; 2]; 1] = [[constant::MAX_LARGE, 1]];

/// A hazard between shaders, through descriptors: the second dispatch reads what the first writes.
/// (The layer of 2023 by design says nothing about two dispatches that only *write* one buffer.)
fn two_dispatches(with_barrier: bool) -> Option<String> {
    complaint(|device| {
        let usage = vk::BufferUsageFlags::STORAGE_BUFFER;
        let buffers: Vec<_> = (0..5)
            .map(|_| Buffer::upload(device, "canary", &[0u32; 16], usage).expect("a buffer"))
            .collect();
        let bindings = Bindings::new(device, "canary", &SLOTS, 2).expect("two sets");
        // It reads the first three and writes the others.
        for (set, order) in [[0, 1, 2, 3, 4], [3, 1, 2, 0, 4]].iter().enumerate() {
            for (slot, buffer) in SLOTS.into_iter().zip(order) {
                // SAFETY: no commands have it yet.
                unsafe { bindings.write(set, slot, &Resource::Buffer(&buffers[*buffer])) }
                    .expect("a set");
            }
        }
        let pipeline =
            ComputePipeline::new(device, shaders::ORDER_LARGE_COMP, &bindings, 0, &CONSTANTS)
                .expect("a pipeline");
        Commands::once(device, "canary", |commands| {
            pipeline.dispatch(commands, &bindings, 0, &[], [1, 1, 1]);
            if with_barrier {
                let write = [Use::ComputeWrite];
                memory_barrier(device, commands, &write, &write);
            }
            pipeline.dispatch(commands, &bindings, 1, &[], [1, 1, 1]);
        })
        .expect("two dispatches");
    })
}

#[test]
fn missing_barrier_between_dispatches_is_a_hazard() {
    let said = two_dispatches(false).expect("a read after a write must be told");
    assert!(said.contains("SYNC-HAZARD-READ-AFTER-WRITE"), "{said}");
    assert_eq!(two_dispatches(true), None, "with the barrier there is no hazard");
}

/// Whoever drops something need not wait: neither for commands that are yet to be submitted, nor for the queue.
#[test]
fn what_is_dropped_in_use_is_freed_later() {
    let said = complaint(|device| {
        use vk::BufferUsageFlags as Usage;
        let before = device.allocated_bytes();
        let usage = Usage::TRANSFER_DST | Usage::STORAGE_BUFFER;
        // Where nothing is recorded or under way, what is dropped is held by its set alone.
        let buffer = Buffer::new(device, "canary", 1 << 20, usage, Memory::Device).expect("room");
        let slots = SLOTS.map(|slot| (slot, Resource::Buffer(&buffer)));
        let bindings = Bindings::of(device, "canary", &slots).expect("a set");
        drop(buffer);
        assert!(device.allocated_bytes() > before, "a set keeps what it holds");
        drop(bindings);
        assert_eq!(device.allocated_bytes(), before, "nothing holds it");

        let mut commands = Commands::new(device, "canary").expect("commands");
        let recorder = commands.begin().expect("a recording");
        let buffer = Buffer::new(device, "canary", 1 << 20, usage, Memory::Device).expect("room");
        // SAFETY: the buffer has that usage.
        unsafe { device.raw().cmd_fill_buffer(recorder.raw(), buffer.raw(), 0, 1 << 20, 1) };
        memory_barrier(device, recorder, &[Use::TransferWrite], &[Use::ComputeWrite]);
        // A set keeps what it holds, and a pipeline stays with its device.
        let slots = SLOTS.map(|slot| (slot, Resource::Buffer(&buffer)));
        let bindings = Bindings::of(device, "canary", &slots).expect("a set");
        drop(buffer);
        let pipeline =
            ComputePipeline::new(device, shaders::ORDER_LARGE_COMP, &bindings, 0, &CONSTANTS);
        pipeline.expect("a pipeline").dispatch(recorder, &bindings, 0, &[], [1, 1, 1]);
        drop(bindings);
        assert!(device.allocated_bytes() > before, "it is in use");
        commands.submit().expect("submitted");
        commands.wait().expect("done");
        assert_eq!(device.allocated_bytes(), before, "it is freed");

        // Nor does a recording that is thrown away hold anything for good.
        commands.begin().expect("a recording");
        drop(Buffer::new(device, "canary", 1 << 20, usage, Memory::Device).expect("room"));
        assert!(device.allocated_bytes() > before);
        commands.begin().expect("another");
        assert_eq!(device.allocated_bytes(), before);

        // Frames under way, of a renderer that is gone.
        crate::common::frame(device, raindrops::scene::model::Preset::Fast, (32, 24));
        drop(commands);
        assert_eq!(device.allocated_bytes(), before);
    });
    assert_eq!(said, None);
}

/// A report only says which device is meant: what is changed in it, or of another instance, is not believed.
#[test]
fn a_report_is_not_believed() {
    let _alone = crate::common::layer::alone();
    let (instance, other) =
        (crate::common::validated_instance(), crate::common::validated_instance());
    let honest = crate::common::chosen(&instance);
    let mut forged = honest.clone();
    forged.limits.max_image_dimension2_d = u32::MAX;
    forged.max_allocation = u64::MAX;
    forged.missing = vec!["everything"];
    let device = Device::open(&instance, forged).expect("the device as it is");
    assert_eq!(device.report.limits.max_image_dimension2_d, honest.limits.max_image_dimension2_d);
    assert_eq!(device.report.max_allocation, honest.max_allocation);
    let Err(error) = Device::open(&other, honest) else { panic!("it is of another instance") };
    assert!(error.to_string().contains("another instance"), "{error}");
    drop(device);
    for instance in [instance, other] {
        instance.expect_silence().expect("silence");
    }
}
