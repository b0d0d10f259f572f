//! The rotation of the mask (equations 1 to 4), in float64 and by the shader itself on the GPU: an identity where
//! it should be, orthonormal everywhere, and turned the way (s, t) is.

use crate::common::Random;
use glam::{DMat3, DVec3};
use raindrops::optics::{Intersection, mask_intersection};
use raindrops::passes::frame::Frame;
use raindrops::reference::paper::rotation;

/// The rotations of `glsl/include/sprite.glsl` for drops of radius 1 at these centres, the camera's axes those of
/// the world.
fn rotations_on_the_gpu(centers: &[DVec3]) -> Vec<DMat3> {
    let frame = Frame {
        right: [1.0, 0.0, 0.0, 0.0],
        up: [0.0, 1.0, 0.0, 0.0],
        back: [0.0, 0.0, 1.0, 0.0],
        image: [1.0, 1.0, 1.0, 1.0],
        ..Frame::default()
    };
    let input: Vec<[f32; 4]> =
        centers.iter().map(|center| center.as_vec3().extend(1.0).to_array()).collect();
    let mut columns = Vec::new();
    crate::common::on_device(|device| {
        columns = crate::shader::run(device, "sprite.comp", &frame, &input, 3)
    });
    let axis = |v: &[f32; 4]| DVec3::new(v[0].into(), v[1].into(), v[2].into());
    columns
        .chunks_exact(3)
        .map(|v| DMat3::from_cols(axis(&v[0]), axis(&v[1]), axis(&v[2])))
        .collect()
}

/// Largest element of MᵀM - 1.
fn skew(m: DMat3) -> f64 {
    let off = m.transpose() * m - DMat3::IDENTITY;
    off.to_cols_array().into_iter().fold(0.0, |most, x| most.max(x.abs()))
}

#[test]
fn identity_in_the_pose_of_the_preprocessing() {
    let centers = [1.001, 1.5, 3.0, 1e3, 1e9].map(|distance| DVec3::new(0.0, 0.0, -distance));
    for center in centers {
        assert_eq!(rotation(center), DMat3::IDENTITY);
    }
    for (center, found) in centers.iter().zip(rotations_on_the_gpu(&centers)) {
        let off = (found - DMat3::IDENTITY).to_cols_array();
        // Square roots and quotients of float32.
        assert!(off.iter().all(|x| x.abs() < 1e-6), "{center}: {found}");
    }
}

/// Directions in front of the camera: random ones, and on rings out to a hair from the camera plane.
fn directions() -> Vec<DVec3> {
    let mut random = Random(1);
    let front = |d: DVec3| DVec3::new(d.x, d.y, -d.z.abs());
    let mut all: Vec<_> = (0..100_000).map(|_| front(random.direction())).collect();
    for off_axis in [1e-9, 1e-6, 1e-3, 1.0, 45.0, 80.0, 89.0, 89.9, 89.999, 89.999_999] {
        let (sin, cos) = f64::to_radians(off_axis).sin_cos();
        all.extend((0..360).map(|azimuth| {
            let (y, x) = f64::to_radians(azimuth.into()).sin_cos();
            DVec3::new(sin * x, sin * y, -cos)
        }));
    }
    all
}

#[test]
fn orthonormal_for_every_direction() {
    let (mut worst, mut worst_axis) = (0f64, 0f64);
    for direction in directions() {
        for distance in [1.0001, 7.0, 1e6] {
            let center = distance * direction;
            let exact = rotation(center);
            assert!(exact.is_finite(), "{direction}");
            worst = worst.max(skew(exact)).max((exact.determinant() - 1.0).abs());
            // n points from the drop to the eye.
            worst_axis = worst_axis.max((exact * DVec3::Z + direction.normalize()).length());
        }
    }
    println!("off orthonormal in float64: {worst:.1e}");
    assert!(worst < 1e-14 && worst_axis < 1e-14, "{worst}, {worst_axis}");
    // The control.
    assert!(skew(2.0 * DMat3::IDENTITY) > 0.1);
}

#[test]
fn the_shader_turns_as_float64_does() {
    let centers: Vec<DVec3> = directions().into_iter().map(|direction| 7.0 * direction).collect();
    let (mut worst, mut apart) = (0f64, 0f64);
    for (center, found) in centers.iter().zip(rotations_on_the_gpu(&centers)) {
        worst = worst.max(skew(found));
        let off = (found - rotation(*center)).to_cols_array();
        apart = off.iter().fold(apart, |most, x| most.max(x.abs()));
    }
    println!("off orthonormal on the GPU: {worst:.1e}; off float64: {apart:.1e}");
    assert!(worst < 2e-6 && apart < 2e-6, "{worst}, {apart}");
}

/// Largest angle in degrees between what the mask gives after `turn` and the exact ray through the
/// same point of the screen, at the sprite's centre and at four points near its rim.
fn worst_angle(center: DVec3, turn: DMat3) -> f64 {
    let distance = center.length();
    let half_angle = (1.0 / distance).asin();
    // The sprite as it is drawn: on the image plane at depth 1, (s, t) along the screen's axes.
    let z = -center.z;
    let middle = center.truncate() * z / (z * z - 1.0);
    let radius = (distance * distance - 1.0).powf(0.25) / (z * z - 1.0).powf(0.75);
    let places = [(0.0, 0.0), (0.9, 0.0), (-0.9, 0.0), (0.0, 0.9), (0.0, -0.9)];
    let mut worst = 0f64;
    for (s, t) in places {
        let point = middle + radius * glam::DVec2::new(s, t);
        let ray = point.extend(-1.0).normalize();
        let exact = Intersection::of_ray(ray, center, 1.0).expect("a ray that meets the drop");
        let masked = mask_intersection(s, t, half_angle);
        let pairs =
            [(exact.transmitted(), masked.transmitted()), (exact.reflected(), masked.reflected())];
        for (exact, masked) in pairs {
            let turned = turn * masked;
            worst = worst.max(turned.cross(exact).length().atan2(turned.dot(exact)).to_degrees());
        }
    }
    worst
}

#[test]
fn the_mask_turns_with_the_sprites_axes() {
    let mut random = Random(7);
    for distance in [1.6, 4.0, 60.0] {
        let axial = DVec3::new(0.0, 0.0, -distance);
        let on_axis = worst_angle(axial, rotation(axial));
        // tan and sin of a half-angle meet in the middle; nothing else is approximated here.
        assert!(on_axis < 1e-5, "d = {distance}: {on_axis}° on the axis");
        let (mut worst, mut control) = (0f64, f64::INFINITY);
        for _ in 0..200 {
            // Up to 1° off the axis, where the square stands for the ellipse well.
            let offset = 1f64.to_radians() * random.unit();
            let azimuth = std::f64::consts::TAU * random.unit();
            let center = distance
                * DVec3::new(
                    offset.sin() * azimuth.cos(),
                    offset.sin() * azimuth.sin(),
                    -offset.cos(),
                );
            worst = worst.max(worst_angle(center, rotation(center)));
            // The control: the same n with another roll, as a basis made from n alone would have.
            let rolled = rotation(center) * DMat3::from_rotation_z(30f64.to_radians());
            control = control.min(worst_angle(center, rolled));
        }
        println!(
            "d = {distance}: {worst:.2}° at most within 1° of the axis; rolled: {control:.1}°"
        );
        assert!(worst < 2.5, "d = {distance}: {worst}°");
        assert!(control > 20.0, "d = {distance}: the control passes with {control}°");
    }
}

/// Far off the axis the square billboard's own error shows, but no roll: the mean over all azimuths of
/// what the rotation gets wrong about the screen's axes is nothing.
#[test]
fn far_off_the_axis_nothing_is_rolled() {
    for off_axis in [30.0, 60.0, 85.0] {
        let (sin, cos) = f64::to_radians(off_axis).sin_cos();
        for azimuth in 0..360 {
            let (y, x) = f64::to_radians(azimuth.into()).sin_cos();
            let turn = rotation(50.0 * DVec3::new(sin * x, sin * y, -cos));
            // The least rotation leaves the axis perpendicular to both directions where it is.
            let still = DVec3::new(-y, x, 0.0);
            assert!((turn * still - still).length() < 1e-12);
        }
    }
}
