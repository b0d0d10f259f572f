//! The picture in a host's frame is the one that `render` makes.

use glam::DVec2;
use raindrops::renderer::{FrameInput, FrameReport, ViewInfo};
use raindrops::scene::Pane;
use raindrops::scene::model::Preset;
use raindrops::scene::pane::PaneDrop;

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

/// A windscreen before rain, as `render` shows it: at another age, and with drops that the host places, whose pane may change while
/// a frame is under way.
#[test]
fn a_pane_is_that_of_render() {
    let glass = Pane { distance: Some(0.3), tilt: Some(20.0), ..Pane::default() };
    let rained = |age: f64| Pane {
        rate: Some(50.0),
        age: Some(age),
        extent: Some([0.4, 0.3]),
        ..glass.clone()
    };
    let placed = |number: u32| {
        let drop = |of: u32| PaneDrop {
            at: 0.03 * DVec2::new(f64::from(of) - 1.0, f64::from(number) - 1.0),
            radius: 0.004 + 0.002 * f64::from(number),
            contact_angle: None,
        };
        Pane { drops: (0..number + 2).map(drop).collect(), ..glass.clone() }
    };
    let rained = [4.0, 4.0, 4.0, 9.0, 2.0].map(rained);
    let placed = [0, 0, 0, 2, 1].map(placed);
    for (preset, panes) in
        [(Preset::Fast, &rained), (Preset::Exact, &rained), (Preset::Fast, &placed)]
    {
        let mut scenes = film(preset);
        scenes.truncate(panes.len());
        scenes.iter_mut().zip(panes).for_each(|(scene, pane)| scene.pane = Some(pane.clone()));
        // Drops are all that differs from here on.
        let before = scenes[2].clone();
        for scene in &mut scenes[3..] {
            (scene.camera, scene.time) = (before.camera, before.time);
        }
        let expected = rendered(&scenes);
        let mut bare = scenes[0].clone();
        bare.pane = None;
        assert!(rendered(&[bare])[0] != expected[0], "the pane is not to be seen");
        assert!(expected[2] != expected[3] && expected[3] != expected[4], "one drop is as another");
        on_host(preset, |host, device| {
            let mut embedded = Embedded::new(host, device, &scenes[0], &ViewInfo::default());
            for (number, scene) in scenes.iter().enumerate() {
                if number >= 3 {
                    // SAFETY: it is refused before anything is recorded.
                    let refused = unsafe {
                        let input = FrameInput::new(scene, embedded.output());
                        embedded.view.record(embedded.commands[0], 0, &input)
                    };
                    assert!(refused.is_err_and(|error| error.to_string().contains("renew_pane")));
                    // A frame that was recorded before shows what it was recorded for.
                    embedded.record(host, 0, &scenes[number - 1]);
                    embedded.view.renew_pane(scene).expect("drops");
                    embedded.record(host, 1, scene);
                    for (slot, shown) in [number - 1, number].into_iter().enumerate() {
                        let (picture, _) = embedded.finish(host, slot);
                        assert!(picture == expected[shown], "{preset} slot {slot} of {number}");
                    }
                }
                let (picture, _) = embedded.frame(host, number % 2, scene);
                let differ = picture.iter().zip(&expected[number]).filter(|(a, b)| a != b).count();
                assert!(differ == 0, "{preset} frame {number}: {differ} pixels differ");
            }
            // The glass itself is the view's.
            let mut thicker = scenes[4].clone();
            thicker.pane.as_mut().expect("a pane").thickness += 0.001;
            assert!(embedded.view.renew_pane(&thicker).is_err());
            host.destroy_image(embedded.target);
        });
    }
}
