//! Figures of pictures whose error is known, and of pictures without any before a reference that is noisy.

use std::collections::BTreeMap;

use raindrops::glam::Vec3;
use raindrops::picture::tone_map::Exposure;
use raindrops::picture::{Picture, linear_of_srgb};

use crate::bounds::{Miss, misses};
use crate::common::Random;
use crate::figures::{Figures, Halves, Levels, rms_at_most};
use crate::row::{Bytes, ModelRow, Row};

const EDGE: u32 = 64;
const AS_IT_IS: Exposure = Exposure::Clipped(1.0);

/// A picture of levels of 255, by column and row.
fn picture(level: impl Fn(u32, u32) -> f64) -> Picture {
    let pixels = (0..EDGE * EDGE).map(|at| {
        let level = level(at % EDGE, at / EDGE);
        Vec3::splat(linear_of_srgb((level / 255.0) as f32))
    });
    Picture { width: EDGE, height: EDGE, pixels: pixels.collect() }
}

/// A reference of one picture without noise, whose drops are `opacity`.
fn certain(truth: &Picture, opacity: impl Fn(u32, u32) -> f32) -> Halves {
    let opacity = (0..EDGE * EDGE).map(|at| opacity(at % EDGE, at / EDGE)).collect();
    Halves { halves: [truth.clone(), truth.clone()], opacity, samples: 64 }
}

/// A reference with normal noise of so many levels in each half.
fn noisy(truth: impl Fn(u32, u32) -> f64, sigma: f64) -> Halves {
    let mut random = Random(7);
    let halves = [(); 2].map(|()| {
        let values: Vec<f64> = (0..EDGE * EDGE)
            .map(|at| {
                let sum: f64 = (0..12).map(|_| random.unit()).sum();
                truth(at % EDGE, at / EDGE) + sigma * (sum - 6.0)
            })
            .collect();
        picture(|x, y| values[(y * EDGE + x) as usize])
    });
    Halves { halves, opacity: vec![1.0; (EDGE * EDGE) as usize], samples: 64 }
}

fn figures(halves: &Halves, picture: &Picture) -> Figures {
    halves.figures(picture, AS_IT_IS, &halves.noise(AS_IT_IS))
}

fn checkered(x: u32, y: u32) -> f64 {
    if (x + y).is_multiple_of(2) { 20.0 } else { -20.0 }
}

#[track_caller]
fn near(found: f64, wanted: f64, within: f64) {
    assert!((found - wanted).abs() <= within, "{found}, not {wanted}");
}

/// A patch of ten levels as large as a box is ten levels of `box`; half in each of two boxes it is five.
#[test]
fn boxes_of_a_patch() {
    let truth = certain(&picture(|_, _| 100.0), |_, _| 1.0);
    let patch = |left: u32| {
        picture(|x, y| {
            let is_in = (left..left + 8).contains(&x) && (16..24).contains(&y);
            if is_in { 110.0 } else { 100.0 }
        })
    };
    near(figures(&truth, &patch(24)).boxes, 10.0, 0.01);
    near(figures(&truth, &patch(28)).boxes, 5.0, 0.01);
    near(figures(&truth, &patch(24)).rms, 10.0 / 255.0 * (1.0f64 / 64.0).sqrt(), 1e-4);
    let worst = truth.worst_place(&patch(24), AS_IT_IS);
    assert_eq!(worst, [28, 20]);
}

/// Five of nine neighbours on a checkerboard of ±20 levels are alike: dots of 20 - 20/9, and hardly a box.
#[test]
fn dots_of_a_checkerboard() {
    let truth = certain(&picture(|_, _| 100.0), |x, y| {
        // Away from the edges, where there are fewer neighbours.
        f32::from((8..56).contains(&x) && (8..56).contains(&y))
    });
    let found = figures(&truth, &picture(|x, y| 100.0 + checkered(x, y)));
    near(found.dots, 20.0 - 20.0 / 9.0, 0.01);
    near(found.boxes, 0.0, 0.01);
    assert!(found.flip > 0.05, "{found:?}");
    // A checkerboard beside the drops counts for none of their figures.
    let beside =
        figures(&truth, &picture(|x, y| if x < 4 { 100.0 + checkered(x, y) } else { 100.0 }));
    near(beside.dots, 0.0, 1e-3);
    near(beside.flip, 0.0, 1e-3);
    assert!(beside.rms > 0.0);
}

/// A slope is no dots.
#[test]
fn a_slope_has_boxes_and_no_dots() {
    let truth = certain(&picture(|_, _| 100.0), |x, y| {
        f32::from((1..63).contains(&x) && (1..63).contains(&y))
    });
    let found = figures(&truth, &picture(|x, _| 100.0 + 0.5 * f64::from(x)));
    near(found.dots, 0.0, 0.01);
    near(found.boxes, 0.5 * 59.5, 0.01);
}

/// Before a reference with noise of 12 levels the truth itself has hardly an error, although each of its pixels is off by
/// ten; and an error that is there is found as large as it is.
#[test]
fn noise_is_taken_off() {
    let level = |x: u32, y: u32| 90.0 + 0.5 * f64::from(x + y);
    let halves = noisy(level, 12.0);
    let noise = halves.noise(AS_IT_IS);
    // The mean of two halves has noise of 12/√2; less the mean of 3 x 3 it has √(8/9) of it.
    near(255.0 * noise.rms, 12.0 / 2f64.sqrt(), 0.3);
    near(noise.dots, 12.0 / 2f64.sqrt() * (8.0f64 / 9.0).sqrt(), 0.4);
    let right = figures(&halves, &picture(level));
    assert!(right.dots < 3.0 && 255.0 * right.rms < 3.0, "{right:?}, {noise:?}");
    // The largest of 64 means, each of 64 pixels with noise of 1.1 levels, is what both halves agree upon.
    assert!(right.boxes < 4.0, "{right:?}");
    assert!(right.flip < 0.6 * noise.flip, "{right:?}, {noise:?}");
    let wrong = figures(&halves, &picture(|x, y| level(x, y) + checkered(x, y)));
    near(wrong.dots, 20.0 - 20.0 / 9.0, 1.0);
    let patch = |x: u32, y: u32| if x < 16 && y < 16 { 25.0 } else { 0.0 };
    near(figures(&halves, &picture(|x, y| level(x, y) + patch(x, y))).boxes, 25.0, 4.0);
}

/// A change without noise is as large as it is, in one pixel as in all. With noise of 50 levels in each pixel of a few it is not said to be less than it is.
#[test]
fn a_change_of_a_noisy_reference_is_not_underrated() {
    let levels = |level: &dyn Fn(u32, u32) -> f64| Levels::of(&picture(level), AS_IT_IS);
    let counts = |at: usize| at % EDGE as usize / 4 == 0 && at / (EDGE as usize) < 8;
    let change = levels(&|_, _| 108.0).less(&levels(&|_, _| 100.0));
    near(rms_at_most(&change, &change, counts), 8.0, 0.01);
    let one = levels(&|x, y| if x + y == 0 { 108.0 } else { 100.0 }).less(&levels(&|_, _| 100.0));
    near(rms_at_most(&one, &one, counts), 8.0 / 32f64.sqrt(), 0.01);
    let mut random = Random(5);
    let mut noisy = || {
        let noise: Vec<f64> = (0..EDGE * EDGE).map(|_| 100.0 * (random.unit() - 0.5)).collect();
        levels(&|x, y| 128.0 + noise[(y * EDGE + x) as usize]).less(&levels(&|_, _| 120.0))
    };
    let found = (0..50).filter(|_| rms_at_most(&noisy(), &noisy(), counts) >= 8.0).count();
    assert!(found >= 45, "{found} of 50");
}

fn missed(model: &str, figures: Figures, noise: Figures, warnings: &[&str]) -> Vec<Miss> {
    let warnings = warnings.iter().map(ToString::to_string).collect();
    let row = ModelRow { figures, warnings, ..ModelRow::default() };
    misses(&BTreeMap::from([(model.to_string(), row)]), &noise, Some(0.01))
}

/// The bounds of each model, and what takes a miss off the count.
#[test]
fn what_misses_a_bound() {
    let none = Figures::default();
    let fair = Figures { boxes: 7.9, dots: 4.9, flip: 0.149, rms: 0.009 };
    assert!(missed("fast", fair, none, &[]).is_empty());
    let names = |misses: Vec<Miss>| misses.into_iter().map(|miss| miss.figure).collect::<Vec<_>>();
    assert_eq!(names(missed("exact", fair, none, &[])), ["box", "dots", "flip"]);
    let off = Figures { boxes: 8.1, dots: 5.1, flip: 0.151, rms: 0.011 };
    assert_eq!(names(missed("fast", off, none, &[])), ["box", "dots", "flip"]);
    assert_eq!(names(missed("auto", off, none, &[])), ["box", "dots", "flip", "error"]);
    assert!(missed("fast", off, none, &[]).iter().all(Miss::counts));
    assert!(!missed("fast", off, none, &["drops not drawn"]).iter().any(Miss::counts));
    let noise = Figures { boxes: 4.1, ..none };
    let counting = missed("fast", off, noise, &[]).into_iter().filter(Miss::counts);
    assert_eq!(names(counting.collect()), ["dots", "flip"]);
    // A byte is enough, and is more than twice its bound.
    let bytes = Some(Bytes { one_thread: 1, ..Bytes::default() });
    let model = ModelRow { bytes, ..ModelRow::default() };
    let row = Row { models: BTreeMap::from([("exact".into(), model)]), ..Row::default() };
    assert!(row.worst().is_some_and(|miss| miss.figure == "bytes" && miss.times() > 2.0));
}
