//! The octahedral map of directions (`glsl/include/octahedron.glsl`), run on the GPU, against its definition in
//! float64 and against what it is for: every direction is near that of its texel, across all seams.

use crate::common::Random;
use glam::DVec3;
use raindrops::passes::frame::Frame;

/// Texels of an edge, as in the shader.
const EDGE: u32 = 64;

/// Meyer et al. 2010: the octahedron |x| + |y| + |z| = 1 from above, its lower half unfolded outwards.
fn middle_of(texel: u32) -> DVec3 {
    let along = |number: u32| (f64::from(number) + 0.5) / f64::from(EDGE) * 2.0 - 1.0;
    let (x, y) = (along(texel % EDGE), along(texel / EDGE));
    let height = 1.0 - x.abs() - y.abs();
    let folded = if height >= 0.0 {
        DVec3::new(x, y, height)
    } else {
        DVec3::new((1.0 - y.abs()) * x.signum(), (1.0 - x.abs()) * y.signum(), height)
    };
    folded.normalize()
}

/// For each direction its texel, the texel's direction, and the basis.
fn found(directions: &[DVec3]) -> Vec<(u32, [DVec3; 3])> {
    let input: Vec<[f32; 4]> =
        directions.iter().map(|d| d.as_vec3().extend(0.0).to_array()).collect();
    let mut output = Vec::new();
    crate::common::on_device(|device| {
        output = crate::shader::run(device, "octahedron.comp", &Frame::default(), &input, 3);
    });
    let axis = |v: &[f32; 4]| DVec3::new(v[0].into(), v[1].into(), v[2].into());
    output.chunks_exact(3).map(|v| (v[0][3] as u32, [&v[0], &v[1], &v[2]].map(axis))).collect()
}

#[test]
fn every_texel_has_its_own_direction() {
    let middles: Vec<DVec3> = (0..EDGE * EDGE).map(middle_of).collect();
    for (expected, (texel, [n, u, v])) in (0..).zip(found(&middles)) {
        assert_eq!(texel, expected, "the texel of its own middle");
        assert!((n - middle_of(expected)).length() < 1e-6, "texel {texel}: {n}");
        let (across, handed) = (u.dot(v).abs(), u.cross(v).dot(n));
        assert!(across < 1e-6 && (handed - 1.0).abs() < 1e-6, "texel {texel}: {u} {v} about {n}");
    }
}

#[test]
fn every_direction_is_near_that_of_its_texel() {
    let mut random = Random(3);
    let mut directions: Vec<DVec3> = (0..200_000).map(|_| random.direction()).collect();
    // Along the seams: the equator, and the four edges of the lower half.
    for step in 0..3600 {
        let (y, x) = (f64::from(step) * 0.1).to_radians().sin_cos();
        for hair in [-1e-4, 0.0, 1e-4] {
            directions.push(DVec3::new(x, y, hair).normalize());
            directions.push(DVec3::new(hair, x, -y.abs()).normalize());
            directions.push(DVec3::new(x, hair, -y.abs()).normalize());
        }
    }
    let mut most = 0f64;
    for (direction, (_, [n, ..])) in directions.iter().zip(found(&directions)) {
        most = most.max(direction.angle_between(n).to_degrees());
    }
    println!("{most:.3} degrees at most");
    // Half a texel's diagonal where the map stretches most, in the middle of a face: √1.5 x √3 / 32.
    assert!(most < 3.9, "{most} degrees");
}
