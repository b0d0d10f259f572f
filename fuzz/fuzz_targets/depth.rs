//! Depth behind the drops: EXR with and without other passes, PNG of 16 bits.
#![no_main]

use std::path::Path;

use libfuzzer_sys::fuzz_target;
use raindrops::picture::depth::DecodedDepth;
use raindrops::scene::background::Background;

fuzz_target!(
    // The reason is that of the target `environment`.
    init: std::panic::set_hook(Box::new(|_| {})),
    |bytes: &[u8]| {
        let background = Background {
            depth_scale: Some(0.01),
            depth_invalid: Some(0.0),
            ..Background::default()
        };
        match DecodedDepth::from_bytes(Path::new("fuzzed"), bytes, &background) {
            Ok(DecodedDepth { depth, width, height, .. }) => {
                assert_eq!(depth.values.len(), width as usize * height as usize);
                assert!(depth.values.iter().all(|depth| depth.is_finite() && *depth > 0.0));
            }
            Err(error) => assert!(!error.to_string().contains('\n'), "{error}"),
        }
    }
);
