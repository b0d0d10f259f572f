//! Rounding (`glsl/include/rounded.glsl`), run on the GPU: halves go upward on every driver, which GLSL's own functions leave open.

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
