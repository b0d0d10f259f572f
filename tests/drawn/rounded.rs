//! Rounding (`glsl/include/rounded.glsl`), run on the GPU: halves go upward on every driver, which GLSL's own functions leave open.

use half::f16;
use raindrops::passes::frame::Frame;

#[test]
fn halves_go_upward() {
    let whole = -40..40;
    let mut input: Vec<[f32; 4]> = whole
        .map(|n| n as f32)
        .flat_map(|n| [[n + 0.5, n - 0.5, 0.0, n + 0.5], [n + 0.25, n + 0.75, 0.0, n - 0.25]])
        .collect();
    // Shares beside 0 and 1, and those that fall on a half of a unit.
    input.extend([[-0.5, 1.5, 0.0, 0.0], [0.0, 1.0, 0.0, 0.0], [1e-6, 0.999_999, 0.0, 0.0]]);
    input.extend((0..65_535).map(|n| {
        let share = ((f64::from(n) + 0.5) / 65_535.0) as f32;
        [share, 1.0 - share, 0.0, share]
    }));
    let upward = |x: f32| (x + 0.5).floor();
    let units = |share: f32| upward(share.clamp(0.0, 1.0) * 65_535.0) as u32;
    crate::common::on_device(|device| {
        let found = crate::shader::run(device, "rounded.comp", &Frame::default(), &input, 1);
        for ([x, y, _, w], [by_four, by_two, second, packed]) in input.iter().zip(found) {
            assert_eq!([by_four, second, by_two], [*x, *y, *w].map(upward), "{x}, {y} and {w}");
            assert_eq!(packed.to_bits(), units(*x) | units(*y) << 16, "shares {x} and {y}");
        }
    });
}

#[test]
fn halves_are_the_nearest() {
    // Every half up to the largest, and floats at, below and above the middle between it and the next.
    let largest = f16::MAX.to_bits();
    let between = (0..largest).map(|bits| {
        let [here, next] = [bits, bits + 1].map(|bits| f16::from_bits(bits).to_f32());
        let middle = 0.5 * (here + next);
        [here, middle.next_down(), middle, middle.next_up()]
    });
    let last = [f16::MAX.to_f32(), f16::MAX.to_f32().next_down(), 1.0, 0.0];
    let input: Vec<[f32; 4]> = between.chain([last]).collect();
    crate::common::on_device(|device| {
        let found = crate::shader::run(device, "half_bits.comp", &Frame::default(), &input, 1);
        for (given, found) in input.iter().zip(found) {
            let nearest = given.map(|x| f32::from(f16::from_f32(x).to_bits()));
            assert_eq!(found, nearest, "the bits of {given:?}");
        }
    });
}
