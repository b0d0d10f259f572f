//! One parameter of a scene swept in steps: how much a picture changes from step to step, over how much the reference does.
//! Where one model takes the place of another within the sweep, a picture may jump; the reference does not.

use raindrops::picture::tone_map::exposure_of;
use raindrops::scene::Scene;
use raindrops::scene::model::Preset;

use super::figures::{Halves, Levels, mean_product, rms_at_most};
use super::folder::Loaded;
use super::measure::Hunt;
use super::models::Model;
use super::row::Step;
use super::trace::Tracing;

/// Steps of a sweep.
pub const STEPS: u32 = 40;

/// Samples a pixel of each half of a step's reference. Their places are the same in every step, so that most of the noise is
/// the same as well. Where the rest of it hides how much the reference changes, as with drops that few samples meet, that is taken
/// to be as much as it may well be.
const SAMPLES: u32 = 16;

/// The reference is taken to change by this many levels at least.
const LEAST_CHANGE: f64 = 0.5;

/// What is swept.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
pub enum Swept {
    /// Radius of all drops, until the largest goes from 0.3 to 40 pixels; of drops in boxes from a third to three times.
    Radius,
    /// Seconds of the exposure, from a thirtieth to twice.
    Shutter,
    /// Diameter of the lens, from a thirtieth to twice.
    Aperture,
    /// Distance of placed drops from the camera, from a half to eight times.
    Distance,
    /// Millimetres an hour, from a quarter to four times.
    Rate,
}

impl Swept {
    /// All of them.
    pub const ALL: [Self; 5] =
        [Self::Radius, Self::Shutter, Self::Aperture, Self::Distance, Self::Rate];

    /// Its name in results.
    pub fn name(self) -> &'static str {
        match self {
            Self::Radius => "radius",
            Self::Shutter => "shutter",
            Self::Aperture => "aperture",
            Self::Distance => "distance",
            Self::Rate => "rate",
        }
    }

    /// Least and largest factor on what the scene has; none where the scene has nothing to sweep.
    fn factors(self, scene: &Scene) -> Option<[f64; 2]> {
        let view = scene.view();
        let at = scene.drawn_time();
        let away = |drop: &raindrops::scene::PlacedDrop| drop.center_at(at).distance(view.position);
        let widest = scene.drops.iter().map(|drop| drop.radius / away(drop)).fold(0.0, f64::max);
        let has_drops = widest > 0.0 && scene.rain.is_none();
        match self {
            Self::Radius if has_drops => {
                let px = widest * view.focal_px;
                Some([0.3 / px, (40.0 / px).min(0.9 / widest)])
            }
            Self::Radius if scene.random_count() > 0 => Some([1.0 / 3.0, 3.0]),
            Self::Shutter if scene.exposed() != 0.0 => {
                let moves = scene.drops.iter().any(|drop| drop.velocity.length() > 0.0);
                (moves || scene.rain.is_some()).then_some([1.0 / 30.0, 2.0])
            }
            Self::Aperture if scene.drawn_lens() > 0.0 => Some([1.0 / 30.0, 2.0]),
            Self::Distance if has_drops => Some([(widest / 0.9).max(0.5), 8.0]),
            Self::Rate if scene.real_rain().is_some_and(|rain| rain.rate <= 400.0) => {
                Some([0.25, 4.0])
            }
            _ => None,
        }
    }

    /// One that the scene has something for, another for each number.
    pub fn of(scene: &Scene, number: u64) -> Option<Self> {
        let all: Vec<Self> =
            Self::ALL.into_iter().filter(|swept| swept.factors(scene).is_some()).collect();
        all.get((number % all.len().max(1) as u64) as usize).copied()
    }

    /// The scene with this parameter times a factor.
    fn at(self, scene: &Scene, factor: f64) -> Scene {
        let mut scene = scene.clone();
        let eye = scene.camera.position;
        let time = scene.drawn_time();
        match self {
            Self::Radius => {
                scene.drops.iter_mut().for_each(|drop| drop.radius *= factor);
                if let Some(rain) = &mut scene.rain {
                    rain.radius *= factor;
                    rain.others.iter_mut().flatten().for_each(|other| other.radius *= factor);
                }
            }
            Self::Shutter => {
                scene.camera.shutter *= factor;
                if let Some(angle) = &mut scene.camera.shutter_angle {
                    *angle = (*angle * factor).min(360.0);
                }
            }
            Self::Aperture => scene.camera.aperture *= factor,
            Self::Distance => {
                for drop in &mut scene.drops {
                    drop.center += (factor - 1.0) * (drop.center_at(time) - eye);
                }
            }
            Self::Rate => {
                if let Some(rain) = scene.rain.as_mut().and_then(|rain| rain.real.as_mut()) {
                    rain.rate *= factor;
                }
            }
        }
        scene
    }
}

/// A step's picture and reference.
struct Shown {
    picture: Levels,
    halves: [Levels; 2],
    is_drop: Vec<bool>,
}

/// The largest step of each model. A factor at which a scene cannot be drawn ends the sweep there.
pub fn sweep(
    hunt: &Hunt,
    name: &str,
    loaded: &Loaded,
    swept: Swept,
    presets: &[Preset],
) -> anyhow::Result<Vec<(String, Step)>> {
    let Some([low, high]) = swept.factors(&loaded.scene) else { return Ok(Vec::new()) };
    let tracing = Tracing { most_samples: SAMPLES, ..hunt.tracing.clone() };
    let mut steps: Vec<Vec<Shown>> = presets.iter().map(|_| Vec::new()).collect();
    let mut factors = Vec::new();
    // One exposure for all, that of the scene.
    let of_scene = tracing.halves(&format!("{name}-swept"), &loaded.scene, &loaded.environment)?;
    let exposure = exposure_of(&loaded.scene.tone_map, &of_scene.mean());
    for step in 0..=STEPS {
        let factor = low * (high / low).powf(f64::from(step) / f64::from(STEPS));
        let scene = swept.at(&loaded.scene, factor);
        if scene.validate("a step").is_err() {
            break;
        }
        let of_step = format!("{name}-{}-{step}", swept.name());
        let halves: Halves = tracing.halves(&of_step, &scene, &loaded.environment)?;
        let levels = halves.halves.each_ref().map(|half| Levels::of(half, exposure));
        let is_drop: Vec<bool> = (0..halves.opacity.len()).map(|at| halves.is_drop(at)).collect();
        for (preset, steps) in presets.iter().zip(&mut steps) {
            let model = Model::new(&hunt.place, &scene, &loaded.environment, *preset)?;
            let picture = Levels::of(&model.draw(1)?.picture, exposure);
            steps.push(Shown { picture, halves: levels.clone(), is_drop: is_drop.clone() });
        }
        factors.push(factor);
    }
    let found = presets.iter().zip(&steps).filter_map(|(preset, steps)| {
        let step = largest(steps, &factors, swept)?;
        Some((preset.name().to_string(), step))
    });
    Ok(found.collect())
}

/// The largest change of the picture over that of the reference, both over the pixels of drops before or after it.
fn largest(steps: &[Shown], factors: &[f64], swept: Swept) -> Option<Step> {
    let all = steps.windows(2).zip(factors.windows(2)).map(|(pair, factors)| {
        let [before, after] = pair else { return Step::default() };
        let is_drop = |at: usize| before.is_drop[at] || after.is_drop[at];
        let change = after.picture.less(&before.picture);
        let [a, b] = [0, 1].map(|half| after.halves[half].less(&before.halves[half]));
        let levels = [mean_product(&change, &change, is_drop).sqrt(), rms_at_most(&a, &b, is_drop)];
        Step {
            of: swept.name().into(),
            largest: levels[0] / levels[1].max(LEAST_CHANGE),
            between: [factors[0], factors[1]],
            levels,
        }
    });
    all.max_by(|a, b| a.largest.total_cmp(&b.largest))
}
