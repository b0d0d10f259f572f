//! Which drop is in front: of drops equally far, of large ones behind small ones, and whatever else there is.

use glam::{DVec3, Vec3};
use raindrops::environment::Environment;
use raindrops::scene::model::Preset;
use raindrops::scene::{ImageSize, PlacedDrop, RainSettings, Scene};

use super::{apart, draw, placed};
use crate::common::picture::renderer;
use crate::common::{on_device, painted};

/// Red, green, blue and white corners: what drops of another direction show is told apart.
fn corners() -> Environment {
    painted(64, |d| {
        let (x, y) = (d.x > 0.0, d.y > 0.0);
        let color = match (x, y) {
            (true, true) => Vec3::new(8.0, 0.1, 0.1),
            (true, false) => Vec3::new(0.1, 8.0, 0.1),
            (false, true) => Vec3::new(0.1, 0.1, 8.0),
            (false, false) => Vec3::splat(4.0),
        };
        if d.z > 0.3 { color } else { 0.05 * color }
    })
}

/// Two drops are exactly equally far: the one that comes first in the scene is in front, as if it were nearer by a hair. They are in
/// a tile through whose middle the plane passes in which they meet; in others the order is that of their fronts.
#[test]
fn of_drops_equally_far_the_first_is_in_front() {
    on_device(|device| {
        let sky = corners();
        // Mirror images of one another, over one another in the middle of a coarse image, where neighbours
        // are seen in other directions.
        for radius in [1.3, 3.0] {
            let focal = 8.0;
            let depth = 1000.0;
            let signs = [(1.0, 1.0), (-1.0, 1.0), (1.0, -1.0), (-1.0, -1.0)];
            let place = |(x, y): (f64, f64), nearer: f64| {
                let aside = 0.7 * depth / focal;
                let center = DVec3::new(x * aside, y * aside, -depth) * (1.0 - nearer);
                (center, radius * depth / focal * (1.0 - nearer))
            };
            let mut pictures = Vec::new();
            for first in 0..4 {
                let order = [0, 1, 2, 3].map(|at| signs[(first + at) % 4]);
                let scene = |nearer: f64| {
                    let drops = (0..4).zip(order);
                    let drops = drops.map(|(at, sign)| place(sign, nearer * f64::from(4 - at)));
                    let mut scene = placed(drops, 16);
                    scene.image.width = 12;
                    scene
                };
                let tied = draw(device, &scene(0.0), &sky, Preset::Fast);
                let nearer = draw(device, &scene(1e-5), &sky, Preset::Fast);
                let off = apart(&tied, &nearer);
                assert!(off < 0.02, "{radius} px, first {first}: {off} apart");
                pictures.push(tied);
            }
            // The control: who is first of the two on either side does show.
            for (other, shows) in pictures[1..].iter().zip([true, false, true]) {
                let off = apart(&pictures[0], other);
                assert_eq!(off > 0.1, shows, "{radius} px: {off} apart");
            }
        }
    });
}

/// The tile of two drops in one place is drawn again, and counted.
#[test]
fn tiles_that_are_drawn_again_are_counted() {
    on_device(|device| {
        let sky = corners();
        // 0.8 pixels about the middle of a tile.
        let drop = (DVec3::new(250.0, -125.0, -1000.0), 100.0);
        for (drops, again) in [(1, 0), (2, 1)] {
            let mut scene = placed(vec![drop; drops], 16);
            scene.model.preset = Preset::Fast;
            let mut renderer = renderer(device, &scene, &sky);
            renderer.submit(&scene).expect("a frame");
            let tiles = renderer.finish().expect("a report").tiles.expect("tiles");
            assert_eq!(tiles.tiles_again, again, "{tiles:?}");
        }
    });
}

/// A drop placed behind the camera makes the passes ready for drops of all sizes; the picture is the same. Of
/// drops alike some that are larger on the screen lie behind smaller ones, at the edges of a wide view.
#[test]
fn a_drop_out_of_view_changes_nothing() {
    on_device(|device| {
        let sky = painted(128, |d| (2.0 * d).as_vec3().exp());
        let mut scene = Scene {
            rain: Some(RainSettings {
                count: 200_000,
                half_extent: DVec3::splat(100.0),
                radius: 0.45,
                ..RainSettings::default()
            }),
            image: ImageSize { width: 512, height: 512 },
            ..Scene::default()
        };
        scene.camera.vertical_fov = 100.0;
        let alone = draw(device, &scene, &sky, Preset::Fast);
        scene.drops = vec![PlacedDrop::sphere(DVec3::new(0.0, 0.0, 50.0), 3.0)];
        assert!(draw(device, &scene, &sky, Preset::Fast) == alone, "another picture");
        scene.drops[0].center.z = -50.0;
        assert!(draw(device, &scene, &sky, Preset::Fast) != alone, "the control");
    });
}
