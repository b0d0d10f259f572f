//! Flattened drops and bubbles against numbers that were computed elsewhere, against the sphere's
//! closed form, and against what energy and geometry ask for.

use glam::DVec3;
use raindrops::optics::{Interface, Intersection, Shape, WATER, Walk};

use crate::common::Random;

/// Where a ray from outside enters a shape around the origin.
fn entry(shape: Shape, through: DVec3, direction: DVec3) -> DVec3 {
    let (near, _) = shape.cross(through, direction).expect("a hit");
    through + near * direction
}

fn assert_near(found: DVec3, expected: [f64; 3]) {
    assert!((found - DVec3::from(expected)).abs().max_element() < 1.5e-6, "{found} {expected:?}");
}

/// What a ray does: at the surface, and at the first exit with its weight over what came in.
fn first(shape: Shape, through: DVec3, direction: DVec3) -> (Interface, DVec3, f64) {
    let (at, inside) = Walk::enter(shape, entry(shape, through, direction), direction, WATER);
    let exit = inside.and_then(|mut walk| walk.next()).flatten().expect("an exit");
    (at, exit.direction, exit.weight / (1.0 - at.reflectance))
}

#[test]
fn rays_through_a_spheroid_go_where_they_should() {
    let shape = Shape::of_axis_ratio(0.8);
    let down = DVec3::NEG_Z;
    let (at, out, kept) = first(shape, DVec3::new(0.3, 0.4, 10.0), down);
    assert_near(at.reflected, [0.417714, 0.870237, 0.261158]);
    assert!((at.reflectance - 0.023016).abs() < 1e-6);
    assert_near(out, [-0.150925, -0.254441, -0.955239]);
    assert!((1.0 - kept - 0.020726).abs() < 1e-6);
    let point = entry(shape, DVec3::new(0.3, 0.4, 10.0), down);
    let (_, inside) = Walk::enter(shape, point, down, WATER);
    let second = inside.and_then(|walk| walk.flatten().nth(1)).expect("an exit");
    assert_near(second.direction, [-0.271253, -0.151896, 0.950447]);

    let oblique = DVec3::new(0.0, -0.5, -0.75_f64.sqrt());
    let (at, out, _) = first(shape, DVec3::new(0.2, 5.75, 9.0), oblique);
    assert_near(at.reflected, [0.225366, 0.880865, -0.416278]);
    assert_near(out, [-0.096872, -0.694522, -0.712920]);

    // The first exit is under total reflection; all of the light stays inside, and leaves later.
    let shape = Shape::of_axis_ratio(0.7);
    let through = DVec3::new(0.0, 4.329_357, 9.047_450);
    let point = entry(shape, through, oblique);
    let (at, inside) = Walk::enter(shape, point, oblique, WATER);
    let mut walk = inside.expect("a way in");
    assert!(walk.next().flatten().is_none(), "this ray is reflected totally");
    assert_eq!(walk.left(), 1.0 - at.reflectance);
    // A little further in it is not: the case is near its limit.
    assert!(walk.next().flatten().is_some());
}

#[test]
fn rays_through_two_halves_go_where_they_should() {
    let of_3_mm = Shape::Halves { equatorial: 1.0552, top: 1.0150, bottom: 0.7759, joint: -0.0805 };
    for (x, y, reflected, transmitted, reflectance) in [
        (0.3, 0.4, [0.465625, 0.806021, 0.365408], [-0.158245, -0.266274, -0.950819], 0.022006),
        (-0.5, -0.5, [-0.527692, -0.818843, -0.225914], [0.277139, 0.304611, -0.911266], 0.035688),
    ] {
        let (at, out, _) = first(of_3_mm, DVec3::new(x, y, 10.0), DVec3::NEG_Z);
        assert_near(at.reflected, reflected);
        assert_near(out, transmitted);
        assert!((at.reflectance - reflectance).abs() < 1e-6);
    }
    // In by the lower half, out by the upper.
    let of_4_mm = Shape::Halves { equatorial: 1.0890, top: 1.0035, bottom: 0.6765, joint: -0.1110 };
    let through = DVec3::new(0.45, -0.35, 10.0);
    assert!(entry(of_4_mm, through, DVec3::NEG_Z).y < -0.1110);
    let (at, out, _) = first(of_4_mm, through, DVec3::NEG_Z);
    assert_near(at.reflected, [0.578701, -0.796452, 0.175411]);
    assert_near(out, [-0.222815, 0.178279, -0.958421]);
    assert!((at.reflectance - 0.024126).abs() < 1e-6);
}

#[test]
fn the_outline_is_the_ellipse_of_the_elevation() {
    let shape = Shape::of_axis_ratio(0.8);
    for (elevation, half_height) in [(0.0_f64, 0.861774), (30.0, 0.920375), (90.0, 1.077217)] {
        let (sine, cosine) = elevation.to_radians().sin_cos();
        // Seen from `elevation` over the horizon.
        let direction = DVec3::new(0.0, -sine, -cosine);
        for (axis, extent) in [(DVec3::X, 1.077217), (DVec3::new(0.0, cosine, -sine), half_height)]
        {
            for (scale, hits) in [(1.0 - 2e-6, true), (1.0 + 2e-6, false)] {
                let through = scale * extent * axis - 7.0 * direction;
                assert_eq!(shape.cross(through, direction).is_some(), hits, "{elevation}° {axis}");
            }
        }
    }
}

/// A random shape, from needles to discs, and a ray that meets it.
fn random_hit(random: &mut Random, shape: Shape) -> (DVec3, DVec3) {
    loop {
        let direction = random.direction();
        let across = direction.any_orthonormal_pair();
        let mut at = || shape.reach() * (2.0 * random.unit() - 1.0);
        let through = at() * across.0 + at() * across.1 - 20.0 * direction;
        if let Some((near, _)) = shape.cross(through, direction) {
            return (through + near * direction, direction);
        }
    }
}

#[test]
fn no_light_is_lost_at_any_axis_ratio() {
    let mut random = Random(11);
    let halves = Shape::Halves { equatorial: 1.1564, top: 0.9367, bottom: 0.5524, joint: -0.1319 };
    let shapes = [0.1, 0.5, 0.7, 0.9, 0.999, 1.0, 1.2, 3.0].map(Shape::of_axis_ratio);
    let mut totals = 0;
    for shape in shapes.into_iter().chain([halves]) {
        for index in [WATER, 1.0 / WATER] {
            for _ in 0..2000 {
                let (point, direction) = random_hit(&mut random, shape);
                let (at, inside) = Walk::enter(shape, point, direction, index);
                let Some(mut walk) = inside else {
                    assert_eq!(at.reflectance, 1.0);
                    continue;
                };
                let mut sum = at.reflectance;
                for _ in 0..3 {
                    match walk.next().flatten() {
                        Some(exit) => {
                            sum += exit.weight;
                            assert!((exit.direction.length() - 1.0).abs() < 1e-9);
                        }
                        None => totals += 1,
                    }
                }
                sum += walk.rest().weight;
                assert!((sum - 1.0).abs() < 1e-12, "{shape:?} {index}: {sum}");
            }
        }
    }
    assert!(totals > 500, "only {totals} total reflections: they were not tested");
}

/// The surface is the one that is meant: points satisfy its equation, normals are its gradient, and the
/// body of every shape has unit volume.
#[test]
fn crossings_lie_on_the_surface_and_face_the_right_way() {
    let mut random = Random(5);
    for ratio in [0.4_f64, 0.7, 0.95, 1.3] {
        let shape = Shape::of_axis_ratio(ratio);
        let (a, h) = (ratio.powf(-1.0 / 3.0), ratio.powf(2.0 / 3.0));
        assert!((a * a * h - 1.0).abs() < 1e-12);
        for _ in 0..500 {
            let (point, direction) = random_hit(&mut random, shape);
            let on = (point.x / a).powi(2) + (point.y / h).powi(2) + (point.z / a).powi(2);
            assert!((on - 1.0).abs() < 1e-12);
            let normal = shape.normal(point);
            assert!(normal.dot(direction) < 0.0);
            // Two tangents by differences along the surface.
            let (u, v) = normal.any_orthonormal_pair();
            for tangent in [u, v] {
                let beside = point + 1e-5 * tangent + 3.0 * normal;
                let (near, _) = shape.cross(beside, -normal).expect("a hit");
                let slope = (beside - near * normal - point).dot(normal) / 1e-5;
                assert!(slope.abs() < 1e-3, "{slope}");
            }
        }
    }
}

#[test]
fn two_equal_halves_are_the_spheroid() {
    let mut random = Random(3);
    let Shape::Spheroid { equatorial, polar } = Shape::of_axis_ratio(0.75) else {
        panic!("a spheroid")
    };
    let whole = Shape::Spheroid { equatorial, polar };
    let halves = Shape::Halves { equatorial, top: polar, bottom: polar, joint: 0.0 };
    for _ in 0..5000 {
        let (point, direction) = random_hit(&mut random, whole);
        let through = point - 3.0 * direction;
        let (a, b) = (whole.cross(through, direction), halves.cross(through, direction));
        let ((a, b), (c, d)) = (a.expect("a hit"), b.expect("a hit"));
        assert!((a - c).abs() < 1e-12 && (b - d).abs() < 1e-12);
    }
    // And beside it, both miss.
    for _ in 0..5000 {
        let direction = random.direction();
        let through = 2.0 * random.direction() - 9.0 * direction;
        let [a, b] = [whole, halves].map(|shape| shape.cross(through, direction).is_some());
        assert_eq!(a, b);
    }
}

/// Axis ratio 1, traced from surface to surface, against the closed form; a bubble likewise.
#[test]
fn a_round_spheroid_is_the_sphere() {
    let mut random = Random(1);
    let round = Shape::Spheroid { equatorial: 1.0, polar: 1.0 };
    let mut total = 0;
    for number in 0..20_000 {
        let index = if number % 2 == 0 { WATER } else { 1.0 / 1.333 };
        let (point, direction) = random_hit(&mut random, round);
        let sphere = Intersection::of_ray(direction, 5.0 * direction - point, 1.0);
        let Some(sphere) = sphere.map(|sphere| sphere.with_index(index)) else { continue };
        // Within 10⁻³ of the rim, and of the limit of total reflection, a root amplifies rounding.
        if sphere.cos_incidence < 1e-3 || (sphere.impact_parameter - index).abs() < 1e-3 {
            continue;
        }
        let (at, inside) = Walk::enter(round, point, direction, index);
        assert!((at.reflected - sphere.reflected()).length() < 1e-12);
        assert!((at.reflectance - sphere.reflectance()).abs() < 1e-12);
        let Some(walk) = inside else {
            assert!(sphere.impact_parameter > index);
            assert_eq!(sphere.reflectance(), 1.0);
            total += 1;
            continue;
        };
        for (exit, k) in walk.zip(0..4) {
            let exit = exit.expect("no total reflection inside a sphere");
            assert!((exit.direction - sphere.after_internal_reflections(k)).length() < 1e-12);
            assert!((exit.weight - sphere.weight_of_internal_reflections(k)).abs() < 1e-12);
        }
    }
    assert!(total > 1000, "only {total} total reflections");
}

#[test]
fn a_bubble_bends_light_outwards_and_reflects_it_totally() {
    let index = 1.0 / 1.333;
    let at = |b: f64| Intersection {
        direction: DVec3::NEG_Z,
        offset: DVec3::X,
        impact_parameter: b,
        cos_incidence: (1.0 - b * b).sqrt(),
        index,
    };
    let deviation = |b: f64| {
        let out = at(b).transmitted();
        out.x.atan2(-out.z).to_degrees()
    };
    // Away from the centre, which lies at -x.
    assert!((deviation(0.5) - 23.59501).abs() < 1e-5, "{}", deviation(0.5));
    assert!((deviation(index) - 82.79).abs() < 0.01, "{}", deviation(index));
    assert!((index - 0.7502).abs() < 1e-4);
    for b in [index + 1e-9, 0.8, 0.99, 1.0] {
        assert_eq!(at(b).reflectance(), 1.0);
        let normal = DVec3::new(b, 0.0, (1.0 - b * b).sqrt());
        let met = Interface::meet(DVec3::NEG_Z, normal, index);
        assert_eq!((met.reflectance, met.refracted), (1.0, None));
        assert_eq!(at(b).weight_of_internal_reflections(0), 0.0);
        assert!(at(b).transmitted().is_finite());
    }
    // Over the disc, by the midpoint rule in b².
    let steps = 1_000_000;
    let (mut all, mut within, mut beyond) = (0.0, 0.0, 0.0);
    for step in 0..steps {
        let b = ((f64::from(step) + 0.5) / f64::from(steps)).sqrt();
        let reflectance = at(b).reflectance();
        all += reflectance;
        if b < index { within += reflectance } else { beyond += 1.0 }
    }
    let steps = f64::from(steps);
    assert!((beyond / steps - 0.437).abs() < 5e-4);
    assert!((all / steps - 0.4746).abs() < 5e-5, "{}", all / steps);
    assert!((within / (steps - beyond) - 0.0664).abs() < 1e-4, "{}", within / (steps - beyond));
}
