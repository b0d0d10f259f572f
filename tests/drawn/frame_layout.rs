//! `Frame` in Rust and in GLSL are the same, member for member: marker values go through a shader
//! that reads them by name. The shader is the test's own, so it is compiled here and not shipped.

use std::mem::offset_of;

use raindrops::passes::frame::Frame;

/// The members in the order of their declaration, each four words, every word different.
fn markers() -> ([[u32; 4]; 24], Frame) {
    // Floats above 1, so that no driver takes a marker for a denormal or a NaN and changes it.
    let word = |member: usize, lane: usize| 0x3f80_0000 + (member * 16 + lane) as u32;
    let words = std::array::from_fn(|member| std::array::from_fn(|lane| word(member, lane)));
    let float = |member: usize| words[member].map(f32::from_bits);
    let frame = Frame {
        right: float(0),
        up: float(1),
        back: float(2),
        units: float(3),
        camera_place: words[4],
        shift: words[5],
        seed: words[6],
        motion: float(7),
        camera_high: float(8),
        camera_low: float(9),
        extent: float(10),
        image: float(11),
        window: words[12],
        principal: float(13),
        frustum_x: float(14),
        frustum_y: float(15),
        environment: float(16),
        tone: float(17),
        tiles: words[18],
        room: words[19],
        clusters: words[20],
        moved: float(21),
        streaks: words[22],
        lens: float(23),
    };
    (words, frame)
}

#[test]
fn offsets_are_those_of_std140() {
    let offsets = [
        offset_of!(Frame, right),
        offset_of!(Frame, up),
        offset_of!(Frame, back),
        offset_of!(Frame, units),
        offset_of!(Frame, camera_place),
        offset_of!(Frame, shift),
        offset_of!(Frame, seed),
        offset_of!(Frame, motion),
        offset_of!(Frame, camera_high),
        offset_of!(Frame, camera_low),
        offset_of!(Frame, extent),
        offset_of!(Frame, image),
        offset_of!(Frame, window),
        offset_of!(Frame, principal),
        offset_of!(Frame, frustum_x),
        offset_of!(Frame, frustum_y),
        offset_of!(Frame, environment),
        offset_of!(Frame, tone),
        offset_of!(Frame, tiles),
        offset_of!(Frame, room),
        offset_of!(Frame, clusters),
        offset_of!(Frame, moved),
        offset_of!(Frame, streaks),
        offset_of!(Frame, lens),
    ];
    for (member, offset) in offsets.into_iter().enumerate() {
        assert_eq!(offset, 16 * member);
    }
    assert_eq!(size_of::<Frame>(), 16 * offsets.len());
}

#[test]
fn every_member_arrives_under_its_name() {
    let (words, markers) = markers();
    crate::common::on_device(|device| {
        let arrived =
            crate::shader::run(device, "frame_layout.comp", &markers, &[[0.0; 4]], words.len());
        let arrived: Vec<_> = arrived.iter().map(|vector| vector.map(f32::to_bits)).collect();
        assert_eq!(arrived, words);
    });
}
