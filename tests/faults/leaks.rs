//! What is made and freed over and over does not grow: devices, renderers, sizes of image.
//!
//! `cargo test --test faults leaks -- --ignored` does each a thousand times.
#![cfg(target_os = "linux")]

use std::process::Command;
use std::sync::Arc;

use raindrops::gpu::{Device, Instance, Validation};
use raindrops::scene::model::Preset;

/// Resident memory of this process in MiB.
fn resident_mib() -> f64 {
    let text = std::fs::read_to_string("/proc/self/statm").expect("statm");
    let pages: f64 = text.split_whitespace().nth(1).and_then(|n| n.parse().ok()).expect("pages");
    pages * 4096.0 / 1_048_576.0
}

fn frame(device: &Arc<Device>, preset: Preset, edge: u32) {
    crate::common::frame(device, preset, (edge, edge / 2));
}

/// Does it `count` times and returns the growth in MiB over half of them: from the median of the second quarter to
/// that of the last, so that one that is large by chance does not count.
fn growth(count: u32, mut once: impl FnMut(u32)) -> f64 {
    let resident: Vec<f64> = (0..count)
        .map(|number| {
            once(number);
            resident_mib()
        })
        .collect();
    let quarter = count as usize / 4;
    let median = |from: usize| {
        let mut part = resident[from..from + quarter].to_vec();
        part.sort_by(f64::total_cmp);
        part[quarter / 2]
    };
    median(3 * quarter) - median(quarter)
}

/// Tells a process of this program that it is the one that measures.
const ALONE: &str = "RAINDROPS_MEASURES_GROWTH";

/// Runs the test `name` again in a process that does nothing else: memory is the process's, and other tests would
/// count. One arena, as glibc keeps another for each thread that a driver starts.
fn alone(name: &str, measure: impl FnOnce()) {
    if std::env::var_os(ALONE).is_some() {
        return measure();
    }
    let output = Command::new(std::env::current_exe().expect("this program"))
        .args(["--exact", name, "--include-ignored", "--nocapture"])
        .env(ALONE, "1")
        .env("MALLOC_ARENA_MAX", "1")
        .output()
        .expect("the program again");
    let told = String::from_utf8_lossy(&output.stdout);
    println!("{told}{}", String::from_utf8_lossy(&output.stderr));
    assert!(output.status.success() && told.contains("1 passed"), "{name}: {}", output.status);
}

fn check(count: u32, bound_mib: f64) {
    // Without validation: the layer keeps a record of what was.
    let instance = Instance::new(Validation::Off).expect("Vulkan");
    let report = crate::common::chosen(&instance);
    let device = Device::open(&instance, report.clone()).expect("a device");
    let grown = growth(count, |number| {
        frame(
            &device,
            if number % 50 == 49 { Preset::Fast } else { Preset::Paper },
            16 + 4 * (number % 50),
        );
    });
    println!("{count} resizes: {grown:+.1} MiB");
    assert!(grown < bound_mib, "{count} resizes: {grown:.1} MiB more");
    assert_eq!(Arc::strong_count(&device), 1);
    drop(device);
    let grown = growth(count, |_| {
        let instance = Instance::new(Validation::Off).expect("Vulkan");
        let device = Device::open(&instance, crate::common::chosen(&instance)).expect("a device");
        frame(&device, Preset::Paper, 32);
    });
    println!("{count} devices: {grown:+.1} MiB");
    assert!(grown < bound_mib, "{count} devices: {grown:.1} MiB more");
}

/// A sixth of a mebibyte each time shows; usual are 0.2 to 0.8 in all.
#[test]
fn a_few_times_over() {
    alone("leaks::a_few_times_over", || check(48, 4.0));
}

#[test]
#[ignore = "takes minutes"]
fn a_thousand_times_over() {
    alone("leaks::a_thousand_times_over", || check(1000, 64.0));
}

/// What the layer advises: nothing but what is argued in `docs/stability.md`.
#[test]
fn good_practice() {
    let _alone = crate::common::layer::alone();
    let instance = Instance::new(Validation::BestPractices).expect("Vulkan with validation");
    let device = Device::open(&instance, crate::common::chosen(&instance)).expect("a device");
    for preset in [Preset::Paper, Preset::Fast] {
        frame(&device, preset, 64);
    }
    drop(device);
    let messages = instance.messages();
    let argued = std::fs::read_to_string(
        std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("docs/stability.md"),
    )
    .expect("the arguments");
    let mut names: Vec<&str> = messages
        .iter()
        .filter_map(|text| text.split('[').nth(1)?.split(']').next().map(str::trim))
        .collect();
    names.sort_unstable();
    names.dedup();
    println!("{names:#?}");
    for name in names {
        assert!(argued.contains(name), "not argued: {name}: {messages:#?}");
    }
}
