//! Particle files: PLY, NPY, NPZ, CSV.
#![no_main]

use libfuzzer_sys::fuzz_target;
use raindrops::scene::particles::drops_of_bytes;

fuzz_target!(
    // The reason is that of the target `environment`.
    init: std::panic::set_hook(Box::new(|_| {})),
    |bytes: &[u8]| match drops_of_bytes(bytes) {
        Ok(drops) => assert!(
            drops.iter().all(|drop| drop.center.is_finite() && drop.radius > 0.0 && drop.id != Some(0))
        ),
        Err(problem) => assert!(!problem.is_empty() && !problem.contains('\n'), "{problem}"),
    }
);
