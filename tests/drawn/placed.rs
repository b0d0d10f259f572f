//! Drops that have a place: clusters of them that are out of view are left out, the others are carried to where they are.

use glam::DVec3;
use raindrops::picture::metrics::rel_mse;
use raindrops::rain::cull::count_visible;
use raindrops::scene::model::Preset;
use raindrops::scene::{PlacedDrop, Scene};

use crate::common::picture::{frame, picture_of, renderer, square};
use crate::common::{Random, on_device, waves};

/// Drops that fly apart are culled by clusters, of which none may hide a drop that is in view: at rest, in motion, out of
/// focus, flattened, in a part of the picture, later, and with the camera among them.
#[test]
fn no_drop_in_view_goes_with_its_cluster() {
    let mut random = Random(11);
    let mut within =
        |size: f64| DVec3::from_array([(); 3].map(|()| size * (2.0 * random.unit() - 1.0)));
    let drops: Vec<PlacedDrop> = (0..3000)
        .map(|number| PlacedDrop {
            center: within(12.0),
            radius: 0.004 + 0.2 * f64::from(number % 50 / 49),
            velocity: within(9.0),
            ..PlacedDrop::default()
        })
        .collect();
    let rest = Scene { rain: None, drops, ..square(48) };
    let changed = |change: &dyn Fn(&mut Scene)| {
        let mut scene = rest.clone();
        scene.model.preset = Preset::Fast;
        change(&mut scene);
        scene
    };
    let scenes = [
        changed(&|_| {}),
        changed(&|scene| scene.camera.shutter = 0.2),
        changed(&|scene| scene.time = 0.7),
        changed(&|scene| (scene.camera.aperture, scene.camera.focus) = (0.8, 3.0)),
        changed(&|scene| scene.camera.position = DVec3::new(0.0, 40.0, 0.1)),
        changed(&|scene| scene.camera.window = [0.25, 0.5, 0.75, 1.0]),
        changed(&|scene| scene.camera.vertical_fov = 150.0),
    ];
    let sky = waves();
    on_device(|device| {
        for (number, scene) in scenes.iter().enumerate() {
            let expected = count_visible(scene);
            let (_, counts) = frame(&mut renderer(device, scene, &sky), scene);
            assert_eq!(counts.visible, expected, "scene {number}");
            assert!(expected > 0, "scene {number} shows none");
        }
        // A flattened drop reaches beyond the sphere of its volume: its rim is in view, that sphere is not.
        let flat = PlacedDrop {
            axis_ratio: Some(0.05),
            ..PlacedDrop::sphere(DVec3::new(-4.0, 0.0, -3.0), 0.5)
        };
        let of = |drop| changed(&|scene| scene.drops = vec![drop]);
        let behind = PlacedDrop::sphere(DVec3::new(0.0, 0.0, 40.0), 0.5);
        let [shown, nothing] = [of(flat), of(behind)].map(|scene| picture_of(device, &scene, &sky));
        assert!(shown != nothing, "the rim is not drawn");
    });
}

/// A day later drops are where they are then, to the last of 48 bits: fast ones that have come from far, seen where as many
/// stand.
#[test]
fn drops_are_carried_exactly_for_a_day() {
    let (time, mut random) = (86_400.0, Random(5));
    let mut within =
        |size: f64| DVec3::from_array([(); 3].map(|()| size * (2.0 * random.unit() - 1.0)));
    let standing: Vec<PlacedDrop> = (0..400)
        .map(|_| PlacedDrop::sphere(within(3.0) - DVec3::new(0.0, 0.0, 6.0), 0.03))
        .collect();
    let moving = standing.iter().map(|drop| {
        let velocity = within(40.0);
        PlacedDrop { center: drop.center - velocity * time, velocity, ..*drop }
    });
    let moving: Vec<_> = moving.collect();
    let of = |drops, time| {
        let mut scene = Scene { rain: None, drops, time, ..square(96) };
        scene.model.preset = Preset::Fast;
        scene
    };
    let (then, now) = (of(moving, time), of(standing, 0.0));
    on_device(|device| {
        let expected = count_visible(&then);
        let (picture, counts) = frame(&mut renderer(device, &then, &waves()), &then);
        assert_eq!(counts.visible, expected);
        let (same, _) = frame(&mut renderer(device, &now, &waves()), &now);
        // Usual is 2e-7: 3.5 million units from where they began, the last of 48 bits is 1e-8 of a unit.
        let off = rel_mse(&picture, &same, None);
        assert!(off < 1e-9, "{off}");
    });
}
