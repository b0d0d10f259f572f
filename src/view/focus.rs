//! The lens under the viewer's hand: how wide it is, and the drop that it is focused on.

use egui::Ui;
use glam::{DVec2, DVec3};

use super::nearest::nearest;
use crate::scene::Scene;
use crate::scene::camera::View;

/// A click this far from a drop's outline, in pixels, still means it: most drops are smaller than a pixel.
const NEAR_PX: f64 = 6.0;

/// How wide the lens is, and where it is focused.
pub(super) fn lens(ui: &mut Ui, scene: &mut Scene) {
    ui.horizontal(|ui| {
        ui.label("aperture");
        let slider = egui::Slider::new(&mut scene.camera.aperture, 0.0..=10.0).logarithmic(true);
        ui.add(slider.smallest_positive(1e-4)).on_hover_text("0: a pinhole");
    });
    if scene.camera.aperture > 0.0 {
        ui.horizontal(|ui| {
            ui.label("focus");
            let slider = egui::Slider::new(&mut scene.camera.focus, 0.01..=1e4).logarithmic(true);
            ui.add(slider).on_hover_text("or click at a drop");
        });
    }
}

/// Focuses the camera on the nearest drop at a place of the picture that the scene's image is of, in pixels. False if none
/// is there.
pub(super) fn focus_on(scene: &mut Scene, place: DVec2) -> bool {
    let view = scene.view();
    let Some((center, _)) = nearest(scene, |center, radius| met_at(&view, place, center, radius))
    else {
        return false;
    };
    scene.camera.focus = -center.dot(view.back);
    true
}

/// Depth of a drop, its centre relative to the camera, if a place of the picture is on it or next to it; else infinite.
fn met_at(view: &View, place: DVec2, center: DVec3, radius: f64) -> f64 {
    let (at, is_before) = view.point(center);
    let depth = -center.dot(view.back);
    let is_met = is_before && at.distance(place) <= view.focal_px * radius / depth + NEAR_PX;
    if is_met { depth } else { f64::INFINITY }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::{ImageSize, PlacedDrop, RainSettings};

    #[test]
    fn a_click_focuses_on_the_nearest_drop_there() {
        let image = ImageSize { width: 200, height: 100 };
        let at = |x, z| PlacedDrop::sphere(DVec3::new(x, 0.0, z), 0.5);
        let drops = vec![at(0.0, -20.0), at(0.1, -8.0), at(9.0, -9.0), at(0.0, 3.0)];
        let mut scene = Scene { rain: None, drops, image, ..Scene::default() };
        assert!(focus_on(&mut scene, DVec2::new(101.0, 51.0)));
        assert_eq!(scene.camera.focus, 8.0);
        assert!(focus_on(&mut scene, DVec2::new(150.0, 50.0)), "45 degrees to the right");
        assert_eq!(scene.camera.focus, 9.0);
        assert!(!focus_on(&mut scene, DVec2::new(30.0, 20.0)));
        assert_eq!(scene.camera.focus, 9.0, "it stays where it was");
        // One of the rain's box: where the GPU has it.
        scene.drops.clear();
        scene.rain = Some(RainSettings { count: 1, ..RainSettings::default() });
        let (center, ..) = crate::rain::cull::drops_with_visibility(&scene).next().expect("a drop");
        scene.camera.target = scene.view().to_world() * center.as_dvec3();
        assert!(focus_on(&mut scene, DVec2::new(100.0, 50.0)));
        assert!((scene.camera.focus - f64::from(center.length())).abs() < 1e-3);
    }
}
