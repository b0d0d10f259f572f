//! Failing scenes made smaller, by a fault that is made up; and rows that are written, cut off and read.

use raindrops::scene::Scene;

use crate::row::{self, Row};
use crate::shrink::shrink;

/// Forty drops before rain; the fault needs one drop of radius 5 and a lens.
fn scene() -> String {
    let mut text = String::from(
        "seed = 9\ntime = 4.0\n[camera]\ntarget = [0.0, 0.5, -1.0]\nshutter = 0.01\naperture = 0.2\n\
         [image]\nwidth = 128\nheight = 96\n[water]\nindex = 1.5\n[tone_map]\nkey = 0.3\n\
         [rain]\ncount = 4000\n",
    );
    for number in 0..40 {
        let radius = if number == 23 { 5.0 } else { 1.0 };
        text.push_str(&format!(
            "[[drop]]\ncenter = [{number}.0, 0.0, -50.0]\nradius = {radius:.1}\naxis_ratio = 0.8\n\
             velocity = [0.0, -1.0, 0.0]\n"
        ));
    }
    text
}

fn fails(text: &str) -> bool {
    let scene = Scene::parse(text, "a smaller scene");
    scene.is_ok_and(|scene| {
        scene.camera.aperture > 0.0 && scene.drops.iter().any(|drop| drop.radius == 5.0)
    })
}

#[test]
fn only_what_the_fault_needs_is_left() {
    assert!(fails(&scene()));
    let (text, asked) = shrink(&scene(), [100, 20], 500, &mut fails);
    let scene = Scene::parse(&text, "the smallest").expect("a scene");
    assert!(fails(&text), "{text}");
    assert_eq!((scene.drops.len(), scene.drops[0].radius), (1, 5.0), "{text}");
    assert!(asked < 120, "{asked} scenes tried");
    for key in
        ["seed", "time", "target", "shutter", "water", "tone_map", "rain", "axis_ratio", "velocity"]
    {
        assert!(!text.contains(key), "{key} is not needed:\n{text}");
    }
    // The window is around the worst place.
    let [left, top, right, bottom] = scene.camera.window;
    assert_eq!([128.0 * left, 96.0 * top, 128.0 * right, 96.0 * bottom], [64.0, 0.0, 128.0, 64.0]);
}

#[test]
fn no_more_scenes_are_tried_than_may_be() {
    let mut asked = 0;
    let (text, told) = shrink(&scene(), [0, 0], 5, &mut |text| {
        asked += 1;
        fails(text)
    });
    assert_eq!((asked, told), (5, 5));
    assert!(fails(&text));
}

#[test]
fn what_does_not_fail_without_all_of_it_stays() {
    let whole = scene();
    let (text, _) = shrink(&whole, [0, 0], 500, &mut |smaller| smaller == whole);
    assert_eq!(text, whole);
}

/// A run that was stopped in the middle of a line goes on behind the last whole one.
#[test]
fn rows_survive_a_stop() {
    let folder = tempfile::tempdir().expect("a folder");
    let row = |number| Row { number, tags: vec!["placed".into()], ..Row::default() };
    row::append(folder.path(), &row(1)).expect("a row");
    row::append(folder.path(), &row(2)).expect("a row");
    let path = folder.path().join(row::ROWS);
    let text = std::fs::read_to_string(&path).expect("rows");
    std::fs::write(&path, &text[..text.len() - 9]).expect("a file");
    let numbers = || -> Vec<u64> {
        row::read(folder.path()).expect("rows").iter().map(|row| row.number).collect()
    };
    assert_eq!(numbers(), [1]);
    row::append(folder.path(), &row(3)).expect("a row");
    assert_eq!(numbers(), [1, 3]);
}
