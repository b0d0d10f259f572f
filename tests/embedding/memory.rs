//! Set-up in a host's memory and on its queue: what is taken, and when it is given back.

use std::sync::atomic::{AtomicUsize, Ordering::SeqCst};
use std::sync::{Arc, Mutex};

use gpu_allocator::vulkan::{Allocator, AllocatorCreateDesc};
use raindrops::device::{Device, requirements};
use raindrops::renderer::{Lighting, ViewInfo};
use raindrops::scene::model::Preset;

use crate::embedded::{Embedded, environment, host, scene};
use crate::host::Host;

fn allocator_of(host: &Host) -> Arc<Mutex<Allocator>> {
    let allocator = Allocator::new(&AllocatorCreateDesc {
        instance: host.instance.clone(),
        device: host.device.clone(),
        physical_device: host.physical,
        debug_settings: Default::default(),
        buffer_device_address: false,
        allocation_sizes: Default::default(),
    });
    Arc::new(Mutex::new(allocator.expect("an allocator")))
}

/// Set-up takes memory from the host's allocator and the queue under the host's lock.
#[test]
fn memory_and_queue_are_the_hosts() {
    let _alone = crate::common::layer::alone();
    let host = host(Preset::Fast);
    let allocator = allocator_of(&host);
    let calls = Arc::new(AtomicUsize::new(0));
    let (mut lent, counted) = (host.lent(), calls.clone());
    lent.allocator = Some(allocator.clone());
    lent.queue_lock = Some(Arc::new(move |work: &mut dyn FnMut()| {
        counted.fetch_add(1, SeqCst);
        work();
    }));
    // SAFETY: as in `on_host`.
    let device = unsafe { Device::import(lent, &requirements(Preset::Fast)) }.expect("a device");
    let scene = scene(Preset::Fast);
    let mut embedded = Embedded::new(&host, &device, &scene, &ViewInfo::default());
    let bytes = || allocator.lock().expect("no panic").generate_report().total_allocated_bytes;
    assert!(bytes() > 1 << 20, "{} bytes", bytes());
    let of_set_up = calls.load(SeqCst);
    assert!(of_set_up > 3, "{of_set_up}");
    embedded.frame(&host, 0, &scene);
    assert_eq!(calls.load(SeqCst), of_set_up, "a frame does not use the queue");
    host.destroy_image(embedded.target);
    drop(embedded.view);
    drop(device);
    assert_eq!(bytes(), 0);
    assert_eq!(Arc::strong_count(&allocator), 1);
    drop(allocator);
    assert_eq!(host.messages(), Vec::<String>::new());
}

/// What set-up and growth are done with stays as long as a frame is recorded that the host has not called retired, and
/// not longer: whether the frame was executed or thrown away.
#[test]
fn staging_is_freed_when_the_host_says_that_frames_have_retired() {
    let _alone = crate::common::layer::alone();
    let host = host(Preset::Fast);
    let allocator = allocator_of(&host);
    let mut lent = host.lent();
    lent.allocator = Some(allocator.clone());
    // SAFETY: as in `on_host`.
    let device = unsafe { Device::import(lent, &requirements(Preset::Fast)) }.expect("a device");
    let report = || allocator.lock().expect("no panic").generate_report();
    let uploads = || report().allocations.iter().filter(|a| a.name.contains("upload")).count();
    let bytes = || report().total_allocated_bytes;
    let scene = scene(Preset::Fast);
    let mut embedded = Embedded::new(&host, &device, &scene, &ViewInfo::default());
    assert_eq!(uploads(), 0, "no frame is under way");
    for is_executed in [true, false] {
        embedded.record(&host, 0, &scene);
        let before = bytes();
        drop(Lighting::new(&device, &environment()).expect("light"));
        assert!(uploads() > 0 && bytes() > before, "freed while a frame is under way");
        embedded.view.grow().expect("room");
        let grown = bytes();
        if is_executed {
            host.run(embedded.commands[0]);
            assert!(uploads() > 0 && bytes() == grown, "freed before the host has said so");
        }
        // SAFETY: it was executed, or is never submitted.
        let report = unsafe { embedded.view.retired(0) }.expect("no error");
        assert_eq!(report.is_some(), is_executed);
        assert_eq!(uploads(), 0, "kept after the frame has retired");
        // Nothing is left of lists that took half as much, nor of light that was dropped.
        assert!(bytes() < grown && bytes() < 2 * before, "{before}, {grown}, {}", bytes());
    }
    host.destroy_image(embedded.target);
    drop(embedded.view);
    drop(device);
    drop(allocator);
    assert_eq!(host.messages(), Vec::<String>::new());
}
