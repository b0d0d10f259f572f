//! A pane in the rain as time goes by: whatever was shown before, the drops are those of a pane of this age.

use raindrops::plan::{Output, plan};
use raindrops::renderer::parts::Parts;
use raindrops::scene::Scene;
use raindrops::scene::model::Preset;

use crate::common::picture::{frame, picture_of, renderer};
use crate::common::{on_device, waves};
use crate::pane_drawn::{SQUARE_ON, scene, text};

/// Rain of 50 mm/h on 0.2 x 0.2 m, in metres.
fn rained(simulation: &str, camera: &str) -> Scene {
    let rain = format!(
        "{SQUARE_ON}\nrate = 50.0\nvelocity = [0, 0, -14]\nage = 1.5\nextent = [0.2, 0.2]\nsimulation = \"{simulation}\""
    );
    let mut scene = scene(&text(camera, &rain, &[]));
    scene.model.take_preset(Preset::Fast);
    scene.model.samples = None;
    scene
}

#[test]
fn another_age_has_the_drops_of_a_new_renderer() {
    let sky = waves();
    on_device(|device| {
        for camera in ["", "aperture = 0.02\nfocus = inf"] {
            let mut scene = rained("static", camera);
            let mut renderer = renderer(device, &scene, &sky);
            let mut pictures = Vec::new();
            // On, back, to the wiped pane and from it on.
            for age in [1.5, 4.0, 2.5, 0.0, 4.0] {
                scene.pane.as_mut().expect("a pane").age = Some(age);
                let picture = frame(&mut renderer, &scene).0;
                assert!(picture == picture_of(device, &scene, &sky), "{camera}: {age} s");
                pictures.push(picture);
            }
            assert!(pictures[1] == pictures[4] && pictures[0] != pictures[1]);
            assert!(pictures[2] != pictures[1] && pictures[3] != pictures[2]);
            // Another pane is none of this renderer's.
            scene.pane.as_mut().expect("a pane").rate = Some(20.0);
            assert!(renderer.submit(&scene).is_err());
        }
    });
}

#[test]
fn a_running_pane_is_another_in_each_frame() {
    let sky = waves();
    on_device(|device| {
        let film = rained("running", "");
        let plan = plan(&film, &sky, Output::Radiance).expect("a plan");
        let mut parts = Parts::new(device, &sky, &plan);
        let mut covers = Vec::new();
        for number in [0, 30, 60] {
            let shown = film.film.frame(&film, number);
            let picture = parts.radiance(&shown).expect("a picture").0;
            // A pane of that age that does not run.
            let mut still = rained("static", "");
            let pane = still.pane.as_mut().expect("a pane");
            pane.age = Some(1.5 + f64::from(number) / 30.0);
            (still.time, still.model) = (shown.time, shown.model);
            assert!(picture == picture_of(device, &still, &sky), "frame {number}");
            covers.push(shown.pane_drops().len());
        }
        assert!(covers.windows(2).all(|two| two[0] != two[1]), "{covers:?}");
    });
}
