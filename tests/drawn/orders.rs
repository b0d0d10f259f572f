//! `exact` follows as many internal reflections as matter: its pictures are not bounded by the order at which it ends.

use crate::common::picture::picture_of;
use crate::common::{on_device, one_drop, painted};
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
    painted(128, |direction| {
        let cosine = direction.dot(towards.normalize());
        Vec3::splat((0.02 + 6.0 * (8.0 * (cosine - 1.0)).exp()) as f32)
    })
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

/// A window that is some 10,000 times as bright as its room is seen in light that carries 10^-5 of a ray.
#[test]
fn a_dark_room_shows_its_window_in_high_orders() {
    on_device(|device| {
        const DIM: f64 = 1e-3;
        let is_window = |d: DVec3| d.z < 0.0 && d.x.abs() < -0.2 * d.z && d.y.abs() < -0.25 * d.z;
        let environment =
            painted(128, |d| Vec3::splat(if is_window(d) { 10.0 } else { DIM } as f32));
        let mut scene = one_drop(DVec3::new(1.5, -0.8, -10.0), 1.0);
        scene.image = ImageSize { width: 96, height: 96 };
        scene.camera.vertical_fov = 30.0;
        scene.model.preset = Preset::Exact;
        let truth = Truth { samples: 64, ..Truth::default() };
        let traced = Tracer::new(&scene, &environment, truth).trace(&|_| {});
        let drawn = picture_of(device, &scene, &environment);
        // Where the drop shows neither the room alone nor the window itself. At the window's edges the drawn light is
        // spread a little further: a median knows nothing of them.
        let is_dim = |radiance: f32| (1.2..20.0).contains(&(f64::from(radiance) / DIM));
        let pixels = traced.picture.pixels.iter().zip(&drawn.pixels).zip(&traced.coverage);
        let mut found: Vec<f64> = pixels
            .filter(|((truth, _), covered)| **covered > 0.999 && is_dim(truth.y))
            .map(|((truth, drawn), _)| (f64::from(drawn.y) - DIM) / (f64::from(truth.y) - DIM))
            .collect();
        found.sort_by(f64::total_cmp);
        println!("{found:.2?}");
        assert!(found.len() > 80, "{} pixels", found.len());
        let median = found[found.len() / 2];
        assert!((0.8..1.2).contains(&median), "{median} of the light");
    });
}
