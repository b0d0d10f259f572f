//! Environment files: EXR, Radiance HDR, PNG, JPEG. What loads is sound, what does not is told in a line.
#![no_main]

use libfuzzer_sys::fuzz_target;
use raindrops::environment::Environment;

fuzz_target!(
    // Decoders that panic are caught, and no finding; the fuzzer's own hook would end at each.
    init: std::panic::set_hook(Box::new(|_| {})),
    |bytes: &[u8]| match Environment::from_bytes("fuzzed", bytes) {
        Ok(environment) => {
            assert_eq!(environment.width(), 2 * environment.height());
            let is_sound = |texel: &glam::Vec3| texel.is_finite() && texel.min_element() >= 0.0;
            assert!(environment.texels().iter().all(is_sound));
        }
        Err(error) => assert!(!error.to_string().contains('\n'), "{error}"),
    }
);
