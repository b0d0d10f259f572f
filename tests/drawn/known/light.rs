//! How much light a drop shows, and where: a white drop on black is as bright as its outline is large.

use std::f64::consts::PI;

use glam::{DQuat, DVec2, DVec3, Vec3};
use raindrops::environment::Environment;
use raindrops::optics::{Shape, Walk};
use raindrops::picture::Picture;
use raindrops::plan::Output;
use raindrops::rain::shape::Halves;
use raindrops::scene::Scene;
use raindrops::scene::model::{DropShape, Preset, Weights};
use raindrops::scene::water::Index;

use super::{draw, placed};
use crate::common::picture::{renderer_of, sum};
use crate::common::{hole, on_device, painted};

/// Half-angle of the dark hole about -z, in degrees: more than an image of one degree shows.
const HOLE: f64 = 1.5;

/// Half the sides of a splat's box are stored in steps of 1/512 pixel. A disc's box of equal area has sides of
/// √π radii.
fn radius_of_half_side(steps: u32) -> f64 {
    f64::from(steps) / 512.0 * 2.0 / PI.sqrt()
}

/// What a drop shows of a white environment with a dark hole: all but the light that comes through its middle.
/// Near the axis refraction turns a ray by 2 b (1 - 1/n), and two surfaces let 0.98² of it pass; the outer
/// reflection reaches the hole within 1e-4 of the rim.
fn shown() -> f64 {
    let b = HOLE.to_radians() / (2.0 * (1.0 - 1.0 / 1.33));
    1.0 - 0.96 * b * b - 1.5e-4
}

/// White everywhere but in the hole, and by so much over 1 that what a drop shows is a step of its 9-bit colours.
fn white_around_a_hole() -> Environment {
    hole(HOLE, Vec3::splat((511.0 / 512.0 / shown()) as f32))
}

/// Drops of `radius` pixels in rows `spacing` pixels apart, at all places between pixels and in tiles, in an image
/// of `edge` pixels and one degree; and the light of their ellipses in all.
fn rows(radius: f64, spacing: u32, edge: u32) -> (Scene, f64) {
    let focal = 0.5 * f64::from(edge) / 0.5f64.to_radians().tan();
    let depth = focal / radius;
    let number = edge / spacing;
    let places: Vec<DVec2> = (0..number * number)
        .map(|at| {
            let cell = DVec2::new((at % number).into(), (at / number).into()) + 0.5;
            // Eighths of a pixel, each as often, and pixels of a tile.
            let phase =
                DVec2::new(f64::from(at % 8) / 8.0 + 0.0625, f64::from(at / 8 % 8) / 8.0 + 0.0625);
            let pixel = DVec2::new((at / 3 % 4).into(), (at / 5 % 2).into());
            cell * f64::from(spacing) + phase + pixel
        })
        .collect();
    let center = |place: &DVec2| {
        let from = (*place - 0.5 * f64::from(edge)) * depth / focal;
        DVec3::new(from.x, -from.y, -depth)
    };
    // Semi-axes of a sphere's outline, in focal lengths: r √(d²-r²) / (z²-r²) and r / √(z²-r²).
    let area = |place: &DVec2| {
        let (d2, flat2) = (center(place).length_squared(), depth * depth - 1.0);
        PI * focal * focal * (d2 - 1.0).sqrt() / flat2.powf(1.5)
    };
    let light = 511.0 / 512.0 * places.iter().map(area).sum::<f64>();
    let mut scene = placed(places.iter().map(|place| (center(place), 1.0)), edge);
    scene.camera.vertical_fov = 1.0;
    (scene, light)
}

/// Mean of the pixels' centres, weighted by their light.
fn middle(picture: &Picture) -> DVec2 {
    let weighted = picture.pixels.iter().enumerate().map(|(at, pixel)| {
        let at = at as u32;
        let center = DVec2::new((at % picture.width).into(), (at / picture.width).into()) + 0.5;
        f64::from(pixel.y) * center
    });
    weighted.sum::<DVec2>() / sum(picture)
}

/// Splats, on one to three rows of tiles; blocks; rays.
#[test]
fn a_white_drop_is_as_bright_as_its_ellipse_is_large() {
    on_device(|device| {
        let hole = white_around_a_hole();
        let splats = [100, 250, 400, 550, 650].map(|steps| (radius_of_half_side(steps), 0.002));
        let larger = [1.6, 2.3, 3.7, 5.0].map(|radius| (radius, 0.0025));
        for (radius, bound) in splats.into_iter().chain(larger) {
            let (scene, light) = rows(radius, 24, 192);
            let picture = draw(device, &scene, &hole, Preset::Fast);
            let off = sum(&picture) / light - 1.0;
            let middle = middle(&picture) - middle_of(&scene);
            println!("fast, {radius:.3} px: light {off:+.5}, middle {middle:+.4}");
            assert!(off.abs() < bound, "fast, {radius} px: light off by {off}");
            assert!(middle.length() < 0.02, "fast, {radius} px: {middle} pixels aside");
        }
        for (preset, radius) in [(Preset::Fast, 14.0), (Preset::Fast, 25.0), (Preset::Exact, 9.0)] {
            let (scene, light) = rows(radius, 64, 192);
            let picture = draw(device, &scene, &hole, preset);
            let off = sum(&picture) / light - 1.0;
            let middle = middle(&picture) - middle_of(&scene);
            println!("{preset}, {radius} px: light {off:+.5}, middle {middle:+.4}");
            assert!(off.abs() < 0.002, "{preset}, {radius} px: light off by {off}");
            assert!(middle.length() < 0.05, "{preset}, {radius} px: {middle} pixels aside");
        }
    });
}

/// A dark room with five windows 12° wide and high, all `aside` degrees from -z.
fn windows(aside: f64) -> impl Fn(DVec3) -> f64 {
    let (sine, cosine) = aside.to_radians().sin_cos();
    let axes = [0.1, 1.3, 2.6, 3.9, 5.1].map(|turn: f64| {
        let toward = DVec3::new(turn.cos() * sine, turn.sin() * sine, -cosine);
        let (u, v) = toward.any_orthonormal_pair();
        [u, v, toward]
    });
    move |d| {
        let is_in = |window: &[DVec3; 3]| {
            let [x, y, z] = window.map(|axis| d.dot(axis));
            z > 0.0 && x.abs().max(y.abs()) < 0.105 * z
        };
        f64::from(u8::from(axes.iter().any(is_in)))
    }
}

/// Mean over the disc of a sphere seen along -z, by rays that are traced from surface to surface.
fn mean_over_disc(radiance: impl Fn(DVec3) -> f64) -> f64 {
    const RAYS: u32 = 100_000;
    let along_ray = |number: u32| {
        // Vogel's spiral: rings of equal areas.
        let b = ((f64::from(number) + 0.5) / f64::from(RAYS)).sqrt();
        let at = b * DVec2::from_angle(2.399_963_229_7 * f64::from(number));
        let at = at.extend((1.0 - b * b).sqrt());
        let (entry, inside) = Walk::enter(Shape::Sphere, at, DVec3::NEG_Z, 1.33);
        let exits = inside.into_iter().flat_map(|walk| walk.take(12).flatten());
        let through: f64 = exits.map(|exit| exit.weight * radiance(exit.direction)).sum();
        entry.reflectance * radiance(entry.reflected) + through
    };
    (0..RAYS).map(along_ray).sum::<f64>() / f64::from(RAYS)
}

/// The farther aside a window is, the nearer to the rim it is seen, where directions change much faster along the radius than
/// across it, and where a pixel shows part of a drop.
#[test]
fn small_drops_in_a_dark_room_are_as_bright_as_their_rays() {
    on_device(|device| {
        for aside in [20.0, 40.0, 60.0, 70.0, 80.0, 120.0, 150.0] {
            let windows = windows(aside);
            let expected = mean_over_disc(&windows);
            let environment = painted(1024, |d| Vec3::splat(windows(d) as f32));
            for radius in [0.4, 1.2, 2.3, 4.0] {
                let (scene, white) = rows(radius, 24, 192);
                let light = 511.0 / 512.0 * sum(&draw(device, &scene, &environment, Preset::Fast));
                let off = light / white - expected;
                println!("{radius} px, {aside}°: {expected:.5}, off by {off:+.5}");
                assert!(off.abs() < 0.05 * expected + 1e-4, "{radius} px, {aside}°: {off}");
            }
        }
    });
}

/// Mean over the outline of a flattened drop seen along `d`, by rays that are traced from surface to surface; and by how many radii
/// the middle of its light is higher than the outline's.
fn light_of_flattened(mm: f64, d: DVec3, radiance: impl Fn(DVec3) -> f64) -> (f64, f64) {
    const EDGE: u32 = 300;
    let Halves { joint, equatorial, top, bottom } = Halves::of_diameter(mm);
    let shape = Shape::Halves { equatorial, top, bottom, joint };
    let u = d.cross(DVec3::Y).normalize();
    let v = u.cross(d);
    let at = |number: u32| 1.3 * ((f64::from(number) + 0.5) / f64::from(EDGE) * 2.0 - 1.0);
    // How much there is of light and of the outline, and times its height.
    let (mut sum, mut met) = (DVec2::ZERO, DVec2::ZERO);
    for number in 0..EDGE * EDGE {
        let height = at(number / EDGE);
        let to_ray = at(number % EDGE) * u + height * v;
        let Some((first, _)) = shape.cross(to_ray, d) else { continue };
        let (entry, inside) = Walk::enter(shape, to_ray + first * d, d, 1.33);
        let exits = inside.into_iter().flat_map(|walk| walk.take(12).flatten());
        let through: f64 = exits.map(|exit| exit.weight * radiance(exit.direction)).sum();
        let light = entry.reflectance * radiance(entry.reflected) + through;
        sum += light * DVec2::new(1.0, height);
        met += DVec2::new(1.0, height);
    }
    (sum.x / met.x, sum.y / sum.x - met.y / met.x)
}

/// A flattened drop of up to a few pixels has a sphere's colours on its outline, and the light of its own rays, as high as theirs.
#[test]
fn small_flattened_drops_are_as_bright_as_their_rays() {
    let landscape = |d: DVec3| if d.y > 0.1 { 1.0 } else { 0.1 };
    let environment = painted(1024, |d| Vec3::splat(landscape(d) as f32));
    on_device(|device| {
        for pitch in [-60.0f64, -30.0, 0.0, 40.0] {
            let tilt = DQuat::from_rotation_x(pitch.to_radians());
            let toward = tilt * DVec3::NEG_Z;
            let (expected, height) = light_of_flattened(5.0, toward, landscape);
            // Pixels across and up that a drop moves.
            let [still, aside, up] = [DVec2::ZERO, 6.0 * DVec2::X, 6.0 * DVec2::Y];
            for (radius, way) in
                [(0.5, still), (0.5, aside), (0.8, still), (1.2, aside), (2.3, still), (2.3, up)]
            {
                let (mut scene, _) = rows(radius, 24, 192);
                (scene.metres, scene.camera.target) = (0.0025, toward);
                scene.camera.shutter = 0.01;
                // A radius of these drops is one unit.
                let velocity = tilt * (way / radius / 0.01).extend(0.0);
                scene.model.preset = Preset::Fast;
                for drop in &mut scene.drops {
                    (drop.center, drop.velocity) = (tilt * drop.center, velocity);
                    drop.shape = Some(DropShape::Equilibrium);
                }
                let mut renderer = renderer_of(device, &scene, &environment, Output::Layers);
                renderer.draw(&scene).expect("a frame");
                let colors = renderer.read_layers().expect("layers").color;
                let sum = |of: usize| colors.iter().map(|color| color[of].to_f64()).sum::<f64>();
                let off = sum(1) / sum(3) / expected - 1.0;
                // Drop by drop: those of other directions have other pictures.
                let mut cells = [[DVec2::ZERO; 2]; 64];
                for (at, color) in (0..).zip(&colors) {
                    let (row, cell) = (f64::from(at / 192), at / 192 / 24 * 8 + at % 192 / 24);
                    let weighed = [color[1].to_f64(), color[3].to_f64()];
                    for (sum, weight) in cells[cell as usize].iter_mut().zip(weighed) {
                        *sum += weight * DVec2::new(1.0, row);
                    }
                }
                let rows = cells.iter().map(|[light, drop]| drop.y / drop.x - light.y / light.x);
                let higher = rows.sum::<f64>() / cells.len() as f64 / radius - height;
                println!(
                    "{pitch}°, {radius} px over {way}: {expected:.5}, {height:+.3}, off by {off:+.3}, {higher:+.3}"
                );
                assert!(off.abs() < 0.06, "{pitch}°, {radius} px over {way}: {off}");
                // A splat has a sphere's halves, a streak none; the halves of what moves are drawn as high as each other.
                let bound = match way {
                    _ if radius < 0.7 => 0.35,
                    way if way == up => 0.2,
                    _ => 0.15,
                };
                assert!(higher.abs() < bound, "{pitch}°, {radius} px: {higher} radii too high");
            }
        }
    });
}

/// Mean of the places, in pixels, where a scene's drops are seen.
fn middle_of(scene: &Scene) -> DVec2 {
    let focal = scene.view().focal_px;
    let half = 0.5 * f64::from(scene.image.width);
    let place = |center: DVec3| half + focal * DVec2::new(center.x, -center.y) / -center.z;
    let sum: DVec2 = scene.drops.iter().map(|drop| place(drop.center)).sum();
    sum / scene.drops.len() as f64
}

/// Beyond the near plane a drop fades in as 3 x² - 2 x³ over the fade's length.
#[test]
fn the_near_fade_is_smooth() {
    on_device(|device| {
        let hole = white_around_a_hole();
        for preset in [Preset::Paper, Preset::Fast, Preset::Exact] {
            let (mut scene, _) = rows(5.0, 64, 128);
            let distance = scene.drops[0].center.length();
            let opaque = sum(&draw(device, &scene, &hole, preset));
            for (share, expected) in [(0.25, 0.15625), (0.5, 0.5), (0.75, 0.84375)] {
                scene.camera.near_fade = 0.5 * distance;
                scene.camera.near = distance * (1.0 - 0.5 * share);
                let found = sum(&draw(device, &scene, &hole, preset)) / opaque;
                println!("{preset}, {share} of the fade: {found:.4} for {expected}");
                assert!((found / expected - 1.0).abs() < 0.01, "{preset}: {found}, {expected}");
            }
        }
    });
}

/// The share of unpolarised light that water reflects, by Fresnel's sines and tangents.
fn fresnel(incidence: f64, index: f64) -> f64 {
    let inside = (incidence.sin() / index).asin();
    let (sum, difference) = (incidence + inside, incidence - inside);
    let (s, p) = (difference.sin() / sum.sin(), difference.tan() / sum.tan());
    0.5 * (s * s + p * p)
}

/// What is behind the camera is seen in a far drop's middle by the reflection outside alone, where no light is followed
/// inside.
#[test]
fn a_drop_reflects_as_much_as_fresnel_says() {
    on_device(|device| {
        let behind = painted(256, |d| if d.z > 0.05 { Vec3::ONE } else { Vec3::ZERO });
        let radius = 40.0;
        let mut scene = placed([(DVec3::new(0.0, 0.0, -1000.0), 1.0)], 96);
        scene.camera.vertical_fov = 2.0 * (48.0 / (radius * 1000.0f64)).atan().to_degrees();
        scene.model.internal_reflections = Some(0);
        scene.model.weights = Some(Weights::Physical);
        scene.water.index = Some(Index::One(1.33));
        for preset in [Preset::Exact, Preset::Fast] {
            let picture = draw(device, &scene, &behind, preset);
            let mut worst = 0.0f64;
            for (at, pixel) in (0..).zip(&picture.pixels) {
                let place = DVec2::new((at % 96).into(), (at / 96).into()) + 0.5 - 48.0;
                let b = place.length() / radius;
                if (0.1..0.55).contains(&b) {
                    let expected = fresnel(b.asin(), 1.33);
                    worst = worst.max((f64::from(pixel.y) / expected - 1.0).abs());
                }
            }
            println!("{preset}: off by {worst:.4} at most");
            assert!(worst < 0.01, "{preset}: {worst}");
        }
    });
}
