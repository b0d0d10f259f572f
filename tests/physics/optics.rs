//! The closed forms of one drop against two explicit refractions, and against known numbers.

use std::f64::consts::PI;

use glam::DVec3;
use raindrops::optics::{Intersection, WATER, fresnel, level_distance, level_half_angle};

/// Numbers in 0 to 1 from a linear congruential generator (Knuth's MMIX constants).
fn random() -> impl FnMut() -> f64 {
    let mut state = 1_u64;
    move || {
        state =
            state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (state >> 11) as f64 / (1_u64 << 53) as f64
    }
}

/// Snell's law as a vector formula; `normal` against `direction`, `ratio` = n before / n behind.
fn refract(direction: DVec3, normal: DVec3, ratio: f64) -> DVec3 {
    let cosine = -direction.dot(normal);
    let rest = 1.0 - ratio * ratio * (1.0 - cosine * cosine);
    assert!(rest > 0.0, "total reflection within a sphere");
    ratio * direction + (ratio * cosine - rest.sqrt()) * normal
}

fn reflect(direction: DVec3, normal: DVec3) -> DVec3 {
    direction - 2.0 * direction.dot(normal) * normal
}

/// A random ray from the origin and a random sphere that it meets.
fn random_ray(random: &mut impl FnMut() -> f64) -> (DVec3, DVec3, f64) {
    let mut unit = || {
        let z = 2.0 * random() - 1.0;
        let (sine, cosine) = (2.0 * PI * random()).sin_cos();
        DVec3::new((1.0 - z * z).sqrt() * cosine, (1.0 - z * z).sqrt() * sine, z)
    };
    let (direction, other) = (unit(), unit());
    let radius = 0.1 + random();
    let across = direction.cross(other).normalize() * (radius * random().sqrt());
    (direction, direction * (radius * 1.01 + 20.0 * random()) + across, radius)
}

#[test]
fn closed_forms_agree_with_explicit_refractions() {
    let mut random = random();
    for _ in 0..200_000 {
        let (direction, center, radius) = random_ray(&mut random);
        if center.length() <= radius {
            continue;
        }
        let Some(intersection) = Intersection::of_ray(direction, center, radius) else { continue };
        let b = intersection.impact_parameter;
        // The explicit form subtracts squares of the distance (rounding of 1e-16 of them), and its
        // root amplifies that towards the rim by 1/√(1-b²).
        let tolerance =
            1e-15 * (1.0 + (center.length() / radius).powi(2)) / (1.0 - b * b).sqrt().max(1e-7);

        let along = center.dot(direction);
        let distance = along - (along * along - center.length_squared() + radius * radius).sqrt();
        let normal = (direction * distance - center) / radius;
        assert!((intersection.normal() - normal).length() < tolerance);
        assert!((intersection.reflected() - reflect(direction, normal)).length() < 4.0 * tolerance);

        let mut inside = refract(direction, normal, 1.0 / WATER);
        let mut at = normal;
        for k in 0..4 {
            // Lengths drift by bounces; without this the drift, not the physics, is compared.
            at = (at - 2.0 * inside.dot(at) * inside).normalize();
            let out = refract(inside, -at, WATER);
            let difference = (intersection.after_internal_reflections(k) - out).length();
            assert!(difference < 20.0 * tolerance, "k {k} b {b}: {difference} {tolerance}");
            assert!((intersection.exit_normal(k) - at).length() < 20.0 * tolerance);
            inside = reflect(inside, at).normalize();
        }
        assert_eq!(intersection.transmitted(), intersection.after_internal_reflections(0));
    }
}

#[test]
fn an_axial_ray_goes_straight_through_and_comes_back() {
    let ray = Intersection::of_ray(DVec3::NEG_Z, DVec3::NEG_Z * 5.0, 1.0).expect("a hit");
    assert_eq!(ray.impact_parameter, 0.0);
    assert!((ray.transmitted() - DVec3::NEG_Z).length() < 1e-15);
    assert!((ray.reflected() - DVec3::Z).length() < 1e-15);
    assert!((ray.after_internal_reflections(1) - DVec3::Z).length() < 1e-15);
    // ((n-1)/(n+1))² at normal incidence.
    assert!((ray.reflectance() - (0.33_f64 / 2.33).powi(2)).abs() < 1e-15);
}

#[test]
fn a_ray_at_the_rim_reflects_wholly_and_onwards() {
    let rim = Intersection {
        direction: DVec3::NEG_Z,
        offset: DVec3::X,
        impact_parameter: 1.0,
        cos_incidence: 0.0,
        index: WATER,
    };
    assert!((rim.reflected() - DVec3::NEG_Z).length() < 1e-15);
    assert!((rim.reflectance() - 1.0).abs() < 1e-15);
    // Just beside the sphere, behind it, or from it away: no intersection.
    let beside = DVec3::new(1.0 + 1e-12, 0.0, -5.0);
    assert!(Intersection::of_ray(DVec3::NEG_Z, beside, 1.0).is_none());
    assert!(Intersection::of_ray(DVec3::NEG_Z, DVec3::Z * 5.0, 1.0).is_none());
    let within = DVec3::new(1.0 - 1e-12, 0.0, -5.0);
    assert!(Intersection::of_ray(DVec3::NEG_Z, within, 1.0).is_some());
}

fn intersection_at(b: f64) -> Intersection {
    Intersection {
        direction: DVec3::NEG_Z,
        offset: DVec3::X,
        impact_parameter: b,
        cos_incidence: (1.0 - b * b).sqrt(),
        index: WATER,
    }
}

#[test]
fn the_deviation_is_twice_the_difference_of_the_angles() {
    for step in 0..1000 {
        let b = f64::from(step) / 1000.0;
        let deviation = 2.0 * (b.asin() - (b / WATER).asin());
        // Towards the centre, which lies at -offset.
        let expected = deviation.cos() * DVec3::NEG_Z - deviation.sin() * DVec3::X;
        assert!((intersection_at(b).transmitted() - expected).length() < 1e-13);
    }
}

#[test]
fn the_second_interface_reflects_as_much_as_the_first() {
    for step in 0..=1000 {
        let ray = intersection_at(f64::from(step) / 1000.0);
        // From water to air the roles of the angles and the indices change places.
        let (ci, ct) = (ray.cos_incidence, ray.cos_refraction());
        let s = (WATER * ct - ci) / (WATER * ct + ci);
        let p = (ct - WATER * ci) / (ct + WATER * ci);
        assert!((0.5 * (s * s + p * p) - fresnel(ci, ct, WATER)).abs() < 1e-15);
    }
}

#[test]
fn the_orders_share_all_of_the_light() {
    for step in 0..1000 {
        let ray = intersection_at(f64::from(step) / 1000.0);
        let orders = |last| (0..=last).map(|k| ray.weight_of_internal_reflections(k)).sum::<f64>();
        for last in [0, 1, 8, 40] {
            let all =
                ray.reflectance() + orders(last) + ray.weight_beyond_internal_reflections(last);
            assert!((all - 1.0).abs() < 1e-13);
        }
    }
}

/// Mean over a far drop's disc: all of it has the same distance, so b² is uniform.
fn mean_over_disc(value: impl Fn(&Intersection) -> f64) -> f64 {
    let steps = 1_000_000;
    let at = |step: i32| intersection_at(((f64::from(step) + 0.5) / f64::from(steps)).sqrt());
    (0..steps).map(|step| value(&at(step))).sum::<f64>() / f64::from(steps)
}

#[test]
fn the_discs_means_are_the_known_ones() {
    // To the digits that were found independently by 10⁶ random rays.
    let near = |value: f64, expected: f64, digit: f64| {
        assert!((value - expected).abs() < 0.6 * digit, "{value} is not {expected}");
    };
    near(mean_over_disc(Intersection::reflectance), 0.066, 0.001);
    near(mean_over_disc(|ray| ray.weight_of_internal_reflections(0)), 0.882, 0.001);
    near(mean_over_disc(|ray| ray.weight_of_internal_reflections(1)), 0.044, 0.001);
    near(mean_over_disc(|ray| ray.weight_of_internal_reflections(2)), 0.0055, 0.0001);
    near(mean_over_disc(|ray| ray.weight_beyond_internal_reflections(8)), 0.0001, 0.0001);
}

#[test]
fn the_rainbow_is_where_descartes_found_it() {
    let deviation = |b: f64| {
        let out = intersection_at(b).after_internal_reflections(1);
        // Unfolded: between 90° and 180° the cosine tells it uniquely.
        out.dot(DVec3::NEG_Z).clamp(-1.0, 1.0).acos()
    };
    let (least, b) = (0..100_000)
        .map(|step| f64::from(step) / 100_000.0)
        .map(|b| (deviation(b), b))
        .min_by(|a, b| a.0.total_cmp(&b.0))
        .expect("a minimum");
    // In closed form: cos² θi = (n²-1)/3 at the minimum. 137.5° for n = 1.33; the often quoted
    // 137.9° is that of n = 1.333.
    let incidence = ((WATER * WATER - 1.0) / 3.0).sqrt().acos();
    let closed = PI + 2.0 * incidence - 4.0 * (incidence.sin() / WATER).asin();
    assert!((least - closed).abs() < 1e-8, "{} {}", least.to_degrees(), closed.to_degrees());
    assert!((least.to_degrees() - 137.48).abs() < 0.01);
    assert!((b - 0.862).abs() < 0.001 && (b - incidence.sin()).abs() < 1e-4);
}

#[test]
fn table_1_of_the_paper_digit_by_digit() {
    let printed = [
        ("45.0000", "1.4142"),
        ("26.5651", "2.2361"),
        ("14.0362", "4.1231"),
        ("7.1250", "8.0623"),
        ("3.5763", "16.0312"),
        ("1.7899", "32.0156"),
        ("0.8952", "64.0078"),
        ("0.4476", "128.0039"),
        ("0.2238", "256.0020"),
        ("0.1119", "512.0010"),
        ("0.0560", "1024.0005"),
    ];
    for (level, (angle, distance)) in (0..).zip(printed) {
        assert_eq!(format!("{:.4}", level_half_angle(level).to_degrees()), angle);
        assert_eq!(format!("{:.4}", level_distance(level)), distance);
    }
}
