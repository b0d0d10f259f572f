//! A camera from matrices: points fall where the matrices put them, and depth is what they say; or it is refused.

use glam::{DMat4, DVec3, DVec4};
use raindrops::scene::camera::Camera;
use raindrops::scene::matrices::ClipSpace;

const SIZE: (u32, u32) = (640, 360);

/// A perspective by its edges at distance 1, off-centre; y down, looking along -z; depth `a + b / distance`.
fn frustum([left, top, right, bottom]: [f64; 4], a: f64, b: f64) -> DMat4 {
    DMat4::from_cols(
        DVec4::new(2.0 / (right - left), 0.0, 0.0, 0.0),
        DVec4::new(0.0, -2.0 / (top - bottom), 0.0, 0.0),
        DVec4::new((right + left) / (right - left), -(top + bottom) / (top - bottom), -a, -1.0),
        DVec4::new(0.0, 0.0, b, 0.0),
    )
}

/// From world space to the eye's, which looks along -z.
fn look(eye: DVec3, forward: DVec3, up: DVec3) -> DMat4 {
    let right = forward.cross(up).normalize();
    let to_world = glam::DMat3::from_cols(right, right.cross(forward), -forward);
    DMat4::from_mat3(to_world.transpose()) * DMat4::from_translation(-eye)
}

fn flipped() -> DMat4 {
    DMat4::from_scale(DVec3::new(1.0, -1.0, 1.0))
}

/// Where the matrices put a point, in pixels, and its depth.
fn by_matrices(
    view: DMat4,
    projection: DMat4,
    clip_space: ClipSpace,
    point: DVec3,
) -> (f64, f64, f64) {
    let clip = projection * view * point.extend(1.0);
    let ndc = clip.truncate() / clip.w;
    let down = if clip_space == ClipSpace::YDown { ndc.y } else { -ndc.y };
    let (width, height) = (f64::from(SIZE.0), f64::from(SIZE.1));
    (0.5 * width * (1.0 + ndc.x), 0.5 * height * (1.0 + down), ndc.z)
}

#[test]
fn points_fall_where_the_matrices_put_them() {
    let mut random = crate::common::Random(7);
    let aspect = f64::from(SIZE.0) / f64::from(SIZE.1);
    // Ordinary, reversed, reversed and infinite depth; the last also with a near plane of 0.01.
    let (near, far) = (0.1, 100.0);
    let depths = [
        (far / (far - near), -far * near / (far - near)),
        (-near / (far - near), far * near / (far - near)),
        (0.0, near),
        (0.0, 0.01),
    ];
    for (a, b) in depths {
        for clip_space in [ClipSpace::YDown, ClipSpace::YUp] {
            for forward in [-1.0, 1.0] {
                let eye = 3.0 * random.direction();
                let view = look(eye, random.direction(), random.direction());
                let shift = [0.3 * random.unit(), 0.2 * random.unit()];
                let edges = [
                    -0.7 * aspect + shift[0],
                    0.7 + shift[1],
                    0.7 * aspect + shift[0],
                    -0.7 + shift[1],
                ];
                let mut projection = frustum(edges, a, b);
                if clip_space == ClipSpace::YUp {
                    projection = flipped() * projection;
                }
                // An eye that looks along z: z is turned on both sides.
                let mirror = DMat4::from_scale(DVec3::new(1.0, 1.0, -forward));
                let (view, projection) = (mirror * view, projection * mirror);
                let (camera, depth) =
                    Camera::from_matrices(view, projection, SIZE, clip_space).expect("a camera");
                let resolved = camera.view(SIZE.0, SIZE.1);
                for _ in 0..50 {
                    let pixel = [640.0 * random.unit(), 360.0 * random.unit()];
                    let distance = 0.2 + 50.0 * random.unit();
                    let ray = resolved.ray(pixel[0], pixel[1]);
                    let point = eye + distance / -ray.dot(resolved.back) * ray;
                    let (x, y, z) = by_matrices(view, projection, clip_space, point);
                    assert!(
                        (x - pixel[0]).abs() < 1e-6 && (y - pixel[1]).abs() < 1e-6,
                        "{x} {y} {pixel:?}"
                    );
                    let found = depth.distance(z);
                    assert!((found / distance - 1.0).abs() < 1e-6, "{found} for {distance}");
                }
            }
        }
    }
}

#[test]
fn what_is_no_perspective_of_square_pixels_is_refused() {
    let aspect = f64::from(SIZE.0) / f64::from(SIZE.1);
    let good = frustum([-aspect, 1.0, aspect, -1.0], 0.0, 0.1);
    let view = DMat4::IDENTITY;
    let refused = |view, projection, words: &str| {
        let line = Camera::from_matrices(view, projection, SIZE, ClipSpace::YDown)
            .expect_err("a refusal")
            .to_string();
        println!("{line}");
        assert!(line.contains(words), "'{line}' says not '{words}'");
    };
    assert!(Camera::from_matrices(view, good, SIZE, ClipSpace::YDown).is_ok());
    let orthographic = DMat4::from_scale(DVec3::new(0.1, -0.1, -0.1));
    refused(view, orthographic, "no perspective: its last row is [0.0, 0.0, 0.0, 1.0]");
    refused(view, frustum([-1.0, 1.0, 1.0, -1.0], 0.0, 0.1), "not square");
    refused(view, flipped() * good, "the other clip space");
    refused(view, frustum([-aspect, 1.0, aspect, -1.0], 0.5, 0.0), "one depth");
    refused(DMat4::from_scale(DVec3::splat(2.0)), good, "scaled, sheared or mirrored");
    refused(DMat4::from_scale(DVec3::new(-1.0, 1.0, 1.0)), good, "right-handed");
    refused(view, good * DMat4::from_rotation_z(0.1), "sheared or rotated");
    refused(view, DMat4::NAN, "not finite");
}
