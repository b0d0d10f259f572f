//! Division by way of floats (`glsl/include/divided.glsl`), run on the GPU, against the CPU's.

use crate::common::Random;
use raindrops::passes::frame::Frame;

/// Around every multiple, where a rounded quotient is one off first, and at random, up to what the shader promises.
#[test]
fn a_division_is_exact() {
    let mut random = Random(7);
    let mut pairs = vec![(0u32, 1u32), (0, u32::MAX >> 8), ((1 << 20) - 1, 1)];
    for divisor in (1..200).chain([255, 256, 257, 1023, 4096, 8191, 16_384, 65_535]) {
        for quotient in [1, 2, 3, 7, 1000, 4095, 65_537, 524_289, (1 << 20) - 1] {
            let multiple = u64::from(divisor) * quotient;
            let around = [multiple - 1, multiple, multiple + 1, multiple + u64::from(divisor) - 1];
            let within = around.into_iter().filter(|a| *a < 1 << 31);
            pairs.extend(within.map(|a| (a as u32, divisor)));
        }
    }
    for _ in 0..100_000 {
        let (divisor, quotient) =
            (1 + random.bits() as u32 % 20_000, random.bits() as u32 % 16_384);
        pairs.push((divisor * quotient + random.bits() as u32 % divisor, divisor));
    }
    let input: Vec<_> =
        pairs.iter().map(|(a, b)| [f32::from_bits(*a), f32::from_bits(*b), 0.0, 0.0]).collect();
    crate::common::on_device(|device| {
        let found = crate::shader::run(device, "divided.comp", &Frame::default(), &input, 1);
        for ((a, b), found) in pairs.iter().zip(found) {
            let found = [found[0].to_bits(), found[1].to_bits()];
            assert_eq!(found, [a / b, a % b], "{a} by {b}");
        }
    });
}
