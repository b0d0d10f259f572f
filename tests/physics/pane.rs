//! A drop on a pane and a ray through it, against numbers that were computed elsewhere; the reference against them and
//! against the closed form.
//!
//! Unless said, lengths are in contact radii, coordinates along the pane's u, v and normal, water has the index 1.333 and
//! glass 1.52.

use glam::{DVec2, DVec3, Vec3};
use raindrops::environment::Environment;
use raindrops::optics::Cap;
use raindrops::reference::{Tracer, Truth};
use raindrops::scene::Scene;

use crate::common::painted;

pub const WATER: f64 = 1.333;
pub const GLASS: f64 = 1.52;

/// A ray in air at an angle to the normal, towards an azimuth; degrees.
pub fn incident(angle: f64, azimuth: f64) -> DVec3 {
    let ((sine, cosine), (up, right)) =
        (angle.to_radians().sin_cos(), azimuth.to_radians().sin_cos());
    DVec3::new(sine * right, sine * up, cosine)
}

/// (1-F)/(1+F) of glass, by Fresnel's formulas in angles.
pub fn dry(cosine: f64) -> f64 {
    let i = cosine.acos();
    if i < 1e-6 {
        let f = ((GLASS - 1.0) / (GLASS + 1.0)).powi(2);
        return (1.0 - f) / (1.0 + f);
    }
    let t = (i.sin() / GLASS).asin();
    let f =
        0.5 * (((i - t).sin() / (i + t).sin()).powi(2) + ((i - t).tan() / (i + t).tan()).powi(2));
    (1.0 - f) / (1.0 + f)
}

pub fn close(found: f64, wanted: f64, tolerance: f64, what: &str) {
    assert!((found - wanted).abs() <= tolerance, "{what}: {found} for {wanted}");
}

#[test]
fn caps_have_their_height_radius_and_volume() {
    let cap = Cap { radius: 1.0, angle: 60.0 };
    for (found, wanted) in [
        (cap.height(), 0.577_350),
        (cap.sphere_radius(), 1.154_701),
        (cap.volume(), 1.007_666),
        (Cap::spread(60.0), 0.803_947),
        (Cap::spread(10.0), 1.5605),
        (Cap::spread(110.0), 0.5179),
        (Cap { radius: 1.0, angle: 100.0 }.volume(), 2.7583),
        (Cap { radius: 1.0, angle: 100.0 }.reach(), 1.0154),
        (Cap { radius: 1.0, angle: 60.0 }.center_height() + cap.sphere_radius(), cap.height()),
    ] {
        close(found, wanted, 6e-5, "cap");
    }
    let again = Cap::of_volume(cap.volume(), 60.0);
    close(again.radius, 1.0, 1e-12, "radius of the volume");
}

#[test]
fn the_first_exit_is_that_of_the_closed_form() {
    let exit = |angle, i, azimuth, x, y, glass| {
        Cap { radius: 1.0, angle }.first_exit(
            incident(i, azimuth),
            DVec3::new(x, y, 0.0),
            WATER,
            glass,
        )
    };
    for (angle, i, azimuth, x, y, wanted, weight) in [
        (60.0, 0.0, 0.0, 0.3, 0.2, [-0.092775, -0.061850, 0.993764], 0.933464),
        (45.0, 45.0, 0.0, -0.5, 0.4, [0.851875, -0.194567, 0.486265], 0.693364),
        (45.0, 45.0, 0.0, 0.5, 0.4, [0.550223, -0.100092, 0.828997], 0.922941),
        (30.0, 60.0, 90.0, 0.1, 0.6, [-0.018093, 0.736833, 0.675833], 0.883303),
        (90.0, 20.0, 180.0, 0.3, 0.3, [-0.359924, -0.114108, 0.925978], 0.931853),
        (100.0, 30.0, 0.0, -0.2, 0.1, [0.411425, -0.033320, 0.910834], 0.932261),
    ] {
        let found = exit(angle, i, azimuth, x, y, GLASS).expect("an exit");
        let apart = (found.direction - DVec3::from(wanted)).abs().max_element();
        assert!(apart < 1e-6, "{angle} {i}: {:?}", found.direction);
        close(found.weight, weight, 1e-6, "weight");
        // The glass takes some light and bends nothing.
        let other = exit(angle, i, azimuth, x, y, 1.9).expect("an exit");
        assert_eq!(other.direction, found.direction);
        assert!(other.weight < found.weight - 0.01);
    }
    for (angle, i, azimuth, x, y) in [(60.0, 0.0, 0.0, 0.9, 0.0), (30.0, 60.0, 90.0, 0.1, -0.6)] {
        assert_eq!(exit(angle, i, azimuth, x, y, GLASS), None);
    }
    for (angle, slope) in [(10.0, 0.057_824_8), (30.0, 0.1665), (60.0, 0.288_386_5), (90.0, 0.333)]
    {
        let found = exit(angle, 0.0, 0.0, 1e-4, 0.0, GLASS).expect("an exit");
        close(found.direction.x / 1e-4, -slope, 1e-6, "paraxial");
    }
    // A hemisphere is dark from 1/n on, and shows no more than 90° less the critical angle.
    let seen = |place| exit(90.0, 0.0, 0.0, place, 0.0, GLASS);
    assert!(seen(0.750_187).is_some() && seen(0.750_189).is_none());
    let last = seen(0.750_187).expect("an exit").direction;
    close((-last.x).asin().to_degrees(), 41.3931, 0.1, "limit");
    let hemisphere = Cap { radius: 1.0, angle: 90.0 };
    close(hemisphere.dark_share(DVec3::Z, WATER), 0.437_219, 3e-3, "dark share");
    let dark = Cap { radius: 2.0, angle: 50.0 }.dark_share(incident(45.0, 0.0), WATER);
    close(dark, 0.262, 5e-3, "dark share");
}

/// A pane that faces -z at the origin, so that u is -x... the camera's right: u = x, v = y, normal = -z.
pub fn scene(keys: &str, drops: &str, camera: &str) -> Scene {
    let text = format!(
        "[water]\nindex = {WATER}\n[pane]\npoint = [0, 0, 0]\nnormal = [0, 0, -1]\nindex = {GLASS}\n{keys}\n{drops}\n[camera]\n{camera}"
    );
    Scene::parse(&text, "pane.toml").expect("a scene")
}

/// Along u, v, normal to the world of [`scene`].
pub fn world(local: DVec3) -> DVec3 {
    DVec3::new(local.x, local.y, -local.z)
}

/// Light along a ray that leaves a pane without thickness at (x, y).
pub fn light(
    keys: &str,
    drop: &str,
    way: DVec3,
    place: DVec2,
    environment: &Environment,
    orders: u32,
) -> DVec3 {
    let eye = world(place.extend(0.0) - 3.0 * way);
    let camera = format!("position = [{:?}, {:?}, {:?}]\ntarget = [0, 0, -9]", eye.x, eye.y, eye.z);
    let scene = scene(
        &format!("thickness = 0.0\n{keys}"),
        &format!("[[pane.drop]]\nat = [0, 0]\nradius = 1.0\n{drop}"),
        &camera,
    );
    let truth = Truth { internal_reflections: orders, glints: false, ..Truth::default() };
    Tracer::new(&scene, environment, truth).radiance_along(world(way))
}

/// Radiance that says the direction: 0.5 + 0.4 of each coordinate of the world.
pub fn telling() -> Environment {
    painted(1024, |d| (0.5 + 0.4 * d).as_vec3())
}

pub fn told(local: DVec3) -> DVec3 {
    0.5 + 0.4 * world(local)
}

pub fn same(found: DVec3, wanted: DVec3, tolerance: f64, what: &str) {
    let apart = (found - wanted).abs().max_element();
    assert!(apart < tolerance, "{what}: {found} for {wanted}");
}

#[test]
fn the_reference_and_the_closed_form_agree_on_the_first_exit() {
    let environment = telling();
    let mut met = 0;
    for number in 0..240_u32 {
        let part = |factor: u32| f64::from(number * factor % 241) / 241.0;
        let angle = 10.0 + 110.0 * part(7);
        let (way, radius) = (incident(85.0 * part(29), 360.0 * part(53)), part(97).sqrt());
        let place = radius * DVec2::from_angle(6.3 * part(131));
        let drop = format!("contact_angle = {angle}");
        let found = light("", &drop, way, place, &environment, 0);
        let cap = Cap { radius: 1.0, angle };
        let exit = cap.first_exit(way, place.extend(0.0), WATER, GLASS);
        // What leaves towards the pane, or is reflected at the base first, has tests of its own.
        let is_up = exit.is_some_and(|exit| exit.direction.z > 0.0);
        match exit {
            Some(exit) if is_up => {
                met += 1;
                same(
                    found,
                    exit.weight * told(exit.direction),
                    5e-5,
                    &format!("{cap:?} {way} {place}"),
                );
            }
            None => same(found, DVec3::ZERO, 1e-12, &format!("dark {cap:?} {way} {place}")),
            _ => {}
        }
    }
    assert!(met > 100, "{met}");
}

#[test]
fn what_is_reflected_totally_goes_back_through_the_base() {
    let (white, black) = (Environment::constant(Vec3::ONE), Environment::constant(Vec3::ZERO));
    // (1-F)(1-F) of air to glass and of glass to water, square on.
    let square = (1.0 - ((GLASS - 1.0) / (GLASS + 1.0)).powi(2))
        * (1.0 - ((GLASS - WATER) / (GLASS + WATER)).powi(2));
    for (angle, i, place, orders, weight, cap, sky, inside) in [
        // Twice at the cap, then the base.
        (60.0, 0.0, 0.9, 2, Some(square), 0.0, 0.043182, 0.952379),
        // Out through the cap but for F, which comes to the base.
        (30.0, 60.0, 0.7, 1, None, 1.0 - 0.020722, 0.000843, 0.019790),
    ] {
        let drop = format!("contact_angle = {angle}");
        let of = |keys: &str, environment, orders| {
            light(keys, &drop, incident(i, 0.0), DVec2::new(place, 0.0), environment, orders).x
        };
        let inside_alone = "inside = [1, 1, 1]";
        close(of("", &white, 300) + of(inside_alone, &black, 300), 1.0, 1e-9, "all light");
        let (to_sky, to_inside) = (of("", &white, orders), of(inside_alone, &black, orders));
        let weight = weight.unwrap_or(to_sky / (cap + sky));
        close(to_sky, weight * (cap + sky), 1e-6, "sky");
        close(to_inside, 1.0 - weight + weight * inside, 2e-6, "inside");
    }
    // Where the light goes that comes out beside the drop.
    let drop = "contact_angle = 60";
    let found = light("", drop, DVec3::Z, DVec2::new(0.9, 0.0), &telling(), 2);
    let beside = DVec3::new(-0.559_785, 0.0, (1.0 - 0.559_785_f64.powi(2)).sqrt());
    let weight = light("", drop, DVec3::Z, DVec2::new(0.9, 0.0), &white, 2).x;
    same(found, weight * told(beside), 1e-5, "beside");
}

#[test]
fn a_cap_is_met_from_outside() {
    let environment = telling();
    for (angle, i, place, reflectance, reflected, weight, out) in [
        (
            60.0,
            60.0,
            -1.2,
            0.164_493,
            [0.416_080, 0.0, 0.909_328],
            None,
            [0.918_043, 0.0, -0.396_481],
        ),
        (
            90.0,
            60.0,
            -1.5,
            0.031_725,
            [0.928_2, 0.0, 0.0],
            Some(0.937_556),
            [0.999_744, 0.0, 0.022_626],
        ),
    ] {
        let drop = format!("contact_angle = {angle}");
        let (way, place) = (incident(i, 0.0), DVec2::new(place, 0.0));
        let through = dry(way.z);
        let found = light("", &drop, way, place, &environment, 0);
        let out = DVec3::from(out);
        if weight.is_none() {
            // Towards the pane: mirrored by 1-T, and its weight is what white light has, less the reflection.
            let white = light("", &drop, way, place, &Environment::constant(Vec3::ONE), 0).x;
            let left = white / through - reflectance;
            let mirrored = DVec3::new(out.x, out.y, -out.z);
            let wanted = reflectance * told(DVec3::from(reflected)) + left * told(mirrored);
            same(found, through * wanted, 2e-4, "towards the pane");
            // The share 1-T of what leaves the water, over 0.8 of the light.
            let of_pane = 1.0 - dry(-out.z);
            assert!(
                left > 0.75 * (1.0 - reflectance) * of_pane && left < (1.0 - reflectance) * of_pane
            );
        } else if let Some(weight) = weight {
            let white = light("", &drop, way, place, &Environment::constant(Vec3::ONE), 0).x;
            close(white, through * (reflectance + weight), 1e-5, "out of the other side");
            // F is small here, and its direction is that of the mirror.
            let hit = DVec3::new(-0.947_822, 0.0, 0.3188);
            let mirrored = way - 2.0 * way.dot(hit) * hit;
            let mirrored = if mirrored.z > 0.0 { told(mirrored) } else { DVec3::ZERO };
            same(found, through * (reflectance * mirrored + weight * told(out)), 1e-4, "out");
        }
    }
    // Under the equator of an overhanging cap, just beside its disc.
    let beside = |place: f64| {
        let place = DVec2::new(place, 0.0);
        light(
            "",
            "contact_angle = 100",
            incident(30.0, 0.0),
            place,
            &Environment::constant(Vec3::ONE),
            0,
        )
        .x
    };
    let through = dry(30_f64.to_radians().cos());
    assert!((beside(-1.005) - through).abs() > 1e-3);
    close(beside(1.7), through, 1e-9, "beyond");
}
