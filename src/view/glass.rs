//! The panel's slider for how long ago the pane was wiped; and why no one flies through it.

use egui::Ui;

use super::weather::held;
use crate::scene::Scene;
use crate::scene::camera::Camera;

/// Longest time since it was wiped that the slider has, s.
const LONGEST: f64 = 600.0;
/// Most drops that arrive in that time, about: computing them takes up to a second.
const MOST_ARRIVALS: f64 = 1e6;

/// The slider, where rain falls on a pane. The drops of another age are computed when it is let go.
pub(super) fn glass(ui: &mut Ui, scene: &mut Scene) {
    let arrivals = scene.pane_arrivals_a_second();
    let Some(pane) = scene.pane.as_mut().filter(|pane| pane.has_population()) else { return };
    let longest = LONGEST.min(MOST_ARRIVALS / arrivals.max(1.0));
    let mut age = pane.age();
    let range = 0.0..=longest.max(age);
    held(ui, "wiped before", &mut age, range, " s");
    if age != pane.age() {
        pane.age = Some(age);
    }
}

/// A wiper passes: the pane is as clean as it was at first. False if no rain falls on one.
pub(super) fn wipe(scene: &mut Scene) -> bool {
    let Some(pane) = scene.pane.as_mut().filter(|pane| pane.has_population()) else { return false };
    pane.age = Some(0.0);
    true
}

/// Stops a camera that would come through the glass where it was before.
pub(super) fn stop_at_glass(scene: &mut Scene, before: &Camera) {
    if !scene.is_behind_glass() {
        (scene.camera.position, scene.camera.target) = (before.position, before.target);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn scene(pane: &str) -> Scene {
        let text = format!("[camera]\nposition = [0, 0, 1]\ntarget = [0, 0, 0]\n[pane]\n{pane}");
        Scene::parse(&text, "pane.toml").expect("a scene")
    }

    #[test]
    fn a_wiper_leaves_placed_drops_alone() {
        let mut rained = scene("distance = 0.3\nrate = 5.0\nage = 9.0");
        assert!(wipe(&mut rained));
        assert_eq!(rained.pane.as_ref().and_then(|pane| pane.age), Some(0.0));
        let mut placed = scene("distance = 0.3\n[[pane.drop]]\nat = [0.0, 0.0]\nradius = 0.01");
        let before = placed.clone();
        assert!(!wipe(&mut placed) && placed == before, "it has no rain, and must get none");
    }

    #[test]
    fn a_camera_stops_at_glass_that_stands() {
        let mut scene = scene("point = [0, 0, 0]\nnormal = [0, 0, -1]\nthickness = 0.01");
        let before = scene.camera;
        scene.camera.position.z = 0.5;
        stop_at_glass(&mut scene, &before);
        assert_eq!(scene.camera.position.z, 0.5);
        scene.camera.position.z = 0.005;
        stop_at_glass(&mut scene, &before);
        assert_eq!(scene.camera, before);
    }
}
