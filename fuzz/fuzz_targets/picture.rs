//! Pictures to compare: EXR, PNG, JPEG.
#![no_main]

use std::path::Path;

use libfuzzer_sys::fuzz_target;
use raindrops::picture::Picture;

fuzz_target!(
    // The reason is that of the target `environment`.
    init: std::panic::set_hook(Box::new(|_| {})),
    |bytes: &[u8]| match Picture::from_bytes(Path::new("fuzzed"), bytes) {
        Ok(picture) => {
            assert_eq!(picture.pixels.len(), picture.width as usize * picture.height as usize);
        }
        Err(error) => assert!(!error.to_string().contains('\n'), "{error}"),
    }
);
