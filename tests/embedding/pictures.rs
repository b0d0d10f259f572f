//! The picture in a host's frame is the one that `render` makes.

use raindrops::renderer::{FrameInput, FrameReport, ViewInfo};
use raindrops::scene::Pane;
use raindrops::scene::model::Preset;

use crate::embedded::{Embedded, film, on_host, rendered, scene};

#[test]
fn the_embedded_picture_is_that_of_render() {
    for preset in [Preset::Fast, Preset::Exact, Preset::Paper] {
        let scenes = film(preset);
        let expected = rendered(&scenes);
        on_host(preset, |host, device| {
            let info = ViewInfo { frames_in_flight: 3, ..ViewInfo::default() };
            let mut embedded = Embedded::new(host, device, &scenes[0], &info);
            for (number, scene) in scenes.iter().enumerate() {
                let (picture, report) = embedded.frame(host, number % 3, scene);
                assert!(report.counts.visible > 1000, "{:?}", report.counts);
                let differ = picture.iter().zip(&expected[number]).filter(|(a, b)| a != b).count();
                assert!(differ == 0, "{preset} frame {number}: {differ} pixels differ");
            }
            host.destroy_image(embedded.target);
        });
    }
}

/// What is recorded and thrown away leaves no trace: not in the picture, and not in what is kept from frame to frame.
#[test]
fn commands_that_are_never_submitted_do_no_harm() {
    let scenes = film(Preset::Fast);
    let expected = rendered(&scenes);
    on_host(Preset::Fast, |host, device| {
        let mut embedded = Embedded::new(host, device, &scenes[0], &ViewInfo::default());
        for (number, scene) in scenes.iter().enumerate() {
            // Commands for this view and for another are recorded before each frame.
            for other in [number, (number + 2) % scenes.len()] {
                embedded.record(host, 1, &scenes[other]);
                // SAFETY: it is never submitted.
                let report = unsafe { embedded.view.retired(1) }.expect("no error");
                assert_eq!(report, None, "it was never executed");
            }
            let (picture, _) = embedded.frame(host, 0, scene);
            assert!(picture == expected[number], "frame {number}");
        }
        host.destroy_image(embedded.target);
    });
}

/// The control: without a sky of its own a frame of another view shows the wrong one. Here the sky is kept.
#[test]
fn a_view_that_stands_still_keeps_its_sky() {
    on_host(Preset::Fast, |host, device| {
        let still = scene(Preset::Fast);
        let mut embedded = Embedded::new(host, device, &still, &ViewInfo::default());
        let draws_sky =
            |report: FrameReport| report.passes_ms.iter().any(|(name, _)| *name == "sky");
        let drawn: Vec<bool> =
            (0..4).map(|frame| draws_sky(embedded.frame(host, frame % 2, &still).1)).collect();
        assert_eq!(drawn, [true, false, false, false]);
        host.destroy_image(embedded.target);
    });
}

/// A windscreen before rain: as `render` shows it, and at another age after [`raindrops::renderer::View::age_pane`].
#[test]
fn a_pane_is_that_of_render() {
    let pane = Pane {
        distance: Some(0.3),
        tilt: Some(20.0),
        rate: Some(50.0),
        age: Some(4.0),
        extent: Some([0.4, 0.3]),
        ..Pane::default()
    };
    for preset in [Preset::Fast, Preset::Exact] {
        let mut scenes = film(preset);
        scenes.truncate(3);
        scenes.iter_mut().for_each(|scene| scene.pane = Some(pane.clone()));
        let mut older = scenes[2].clone();
        older.pane = Some(Pane { age: Some(9.0), ..pane.clone() });
        scenes.push(older);
        let expected = rendered(&scenes);
        let mut bare = scenes[0].clone();
        bare.pane = None;
        assert!(rendered(&[bare])[0] != expected[0], "the pane is not to be seen");
        assert!(expected[2] != expected[3], "five seconds of rain are not to be seen");
        on_host(preset, |host, device| {
            let mut embedded = Embedded::new(host, device, &scenes[0], &ViewInfo::default());
            for (number, scene) in scenes.iter().enumerate() {
                if number == 3 {
                    // SAFETY: it is refused before anything is recorded.
                    let refused = unsafe {
                        let input = FrameInput::new(scene, embedded.output());
                        embedded.view.record(embedded.commands[0], 0, &input)
                    };
                    assert!(refused.is_err_and(|error| error.to_string().contains("age_pane")));
                    embedded.record(host, 0, &scenes[2]);
                    let taken = embedded.view.age_pane(scene).expect_err("refused").to_string();
                    assert!(taken.contains("slot 0"), "{taken}");
                    // SAFETY: it is never submitted.
                    unsafe { embedded.view.retired(0) }.expect("no error");
                    embedded.view.age_pane(scene).expect("drops");
                }
                let (picture, _) = embedded.frame(host, number % 2, scene);
                let differ = picture.iter().zip(&expected[number]).filter(|(a, b)| a != b).count();
                assert!(differ == 0, "{preset} frame {number}: {differ} pixels differ");
            }
            host.destroy_image(embedded.target);
        });
    }
}
