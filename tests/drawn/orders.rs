//! `exact` follows as many internal reflections as matter: its pictures are not bounded by the order at which it ends.

use crate::common::picture::picture_of;
use crate::common::{on_device, one_drop};
use glam::{DVec3, Vec3};
use raindrops::environment::Environment;
use raindrops::picture::Picture;
use raindrops::picture::metrics::compare;
use raindrops::picture::tone_map::Exposure;
use raindrops::reference::{Tracer, Truth};
use raindrops::scene::ImageSize;
use raindrops::scene::model::Preset;

/// Dim, with a soft light around a direction: no pixel's rays meet it by chance.
fn soft_light(towards: DVec3) -> Environment {
    let (width, height) = (128, 64);
    let texels = (0..width * height).map(|at| {
        let u = (f64::from(at % width) + 0.5) / f64::from(width);
        let v = (f64::from(at / width) + 0.5) / f64::from(height);
        let (azimuth, polar) = ((u - 0.5) * std::f64::consts::TAU, v * std::f64::consts::PI);
        let direction =
            DVec3::new(polar.sin() * azimuth.sin(), polar.cos(), -polar.sin() * azimuth.cos());
        let cosine = direction.dot(towards.normalize());
        Vec3::splat((0.02 + 6.0 * (8.0 * (cosine - 1.0)).exp()) as f32)
    });
    let texels = texels.collect();
    Environment::from_texels("soft light", width, height, texels).expect("an environment")
}

#[test]
fn a_close_up_shows_all_orders() {
    on_device(|device| {
        let mut worst_of_two = 0.0f64;
        for towards in [DVec3::new(0.3, 0.2, 1.0), DVec3::new(1.0, 0.3, 0.4)] {
            let environment = soft_light(towards);
            let mut scene = one_drop(DVec3::new(0.0, 0.0, -1.6), 1.0);
            scene.image = ImageSize { width: 64, height: 64 };
            scene.camera.vertical_fov = 75.0;
            scene.model.preset = Preset::Exact;
            let truth = Truth { samples: 64, internal_reflections: 400, ..Truth::default() };
            let traced = Tracer::new(&scene, &environment, truth).trace(&|_| {});
            let error = |picture: &Picture| {
                let exposure = Exposure::Clipped(1.0);
                compare(&traced.picture, picture, Some(&traced.coverage), exposure).pixels.rel_mse
            };
            let found = error(&picture_of(device, &scene, &environment));
            assert!(found < 2e-3, "towards {towards}: {found}");
            scene.model.internal_reflections = Some(2);
            let of_two = error(&picture_of(device, &scene, &environment));
            println!("towards {towards}: {found}, by two orders {of_two}");
            worst_of_two = worst_of_two.max(of_two);
        }
        // The control: with two orders it would be over the bound.
        assert!(worst_of_two > 1e-2, "{worst_of_two}");
    });
}
