//! Specialization constants, and what is computed from them, are what a device would make of them.

use raindrops::passes::frame::Frame;

use crate::common::on_device;
use crate::shader::run_with;

#[test]
fn operations_on_constants() {
    let float = |x: f32| x.to_bits();
    // A, B, YES, NO and X: the defaults, A the larger one, and equals. None: not given.
    let cases: [(&[[u32; 2]], [u32; 14]); 3] = [
        (&[], [5, 9, 1, 0, 14, u32::MAX - 3, 11, float(0.25), 0, 1, 0, 0, 0, 1]),
        (
            &[[90, 7], [91, 3], [92, 1], [93, 1], [94, float(-2.5)], [1, 77]],
            [7, 3, 1, 1, 10, 4, 8, float(-2.5), 0, 1, 1, 0, 1, 0],
        ),
        (&[[90, 6], [91, 6], [92, 0]], [6, 6, 0, 0, 12, 0, 8, float(0.25), 1, 0, 0, 1, 0, 0]),
    ];
    on_device(|device| {
        for (constants, expected) in cases {
            let found =
                run_with(device, "specialized.comp", &Frame::default(), constants, &[[0.0; 4]], 4);
            let words: Vec<u32> = found.iter().flatten().map(|word| word.to_bits()).collect();
            assert_eq!(words[..14], expected, "{constants:?}");
        }
    });
}
