//! From which size on drops of real rain are drawn one by one. Smaller ones are a medium.

use std::f64::consts::PI;

use super::demand::contrast;
use super::shape::LONG_EXPOSURE;
use crate::environment::Environment;
use crate::rain::field::Field;
use crate::rain::medium::{cutoff_of_budget, unseen_radius};
use crate::rain::visibility::Frustum;
use crate::rain::{fall, thinned};
use crate::scene::Scene;
use crate::scene::model::{FarRain, Motion};
use crate::scene::real_rain::RealRain;

/// By how much a drop that is left to the medium may change a pixel, where no error is accepted: a grey level.
const LEAST_SEEN: f64 = 1.0 / 255.0;
/// Least contrast between drops and what is behind them that is reckoned with: there is no even sky.
const LEAST_CONTRAST: f64 = 0.1;
/// The least contrast of streaks of a long exposure. A single one shows less than its drop, but many lie over one another.
/// With this, the error is at most a fifth of that of the medium alone (docs/exposure.md, "Are streaks truer").
const LEAST_CONTRAST_OF_STREAKS: f64 = 0.45;
/// Largest radius under which drops are thinned where the scene does not say it: streaks lie over each other, so that a pixel's
/// noise is not that of a single drop.
const MOST_THINNED_PX: f64 = 0.15;
/// Most drops that a picture draws one by one where no cut-off is given, the paper's largest scene; and where the
/// scene asks for them. What is over it goes into the medium.
const MOST_DROPS: f64 = 4e6;
const MOST_ASKED: f64 = 8e6;

/// The cut-off of a scene's real rain.
#[derive(Clone, Debug, PartialEq)]
pub struct Cutoff {
    /// Least radius in pixels of a drop that is drawn by itself, at its depth on the view axis; 0: every drop is.
    pub px: f64,
    /// Radius under which drops are thinned ([`crate::rain::thinned`]), over `px`; 0: none are.
    pub thinned_px: f64,
    /// Why.
    pub why: String,
    /// Standard deviation of a pixel by the drops that are not drawn: of their opacity, times the contrast.
    pub noise: f64,
    /// Whether the medium that stands for them has this noise.
    pub is_grainy: bool,
}

impl Cutoff {
    /// That of `scene`, whose rain is `rain`: as the scene says, else from the contrast of its environment and the
    /// accepted error; larger where that would be more drops or cells than a picture takes. No drop is thinned.
    ///
    /// A film counts by the camera's shutter and its least pace, so that it keeps its drops while it slows down.
    pub fn of(scene: &Scene, rain: &RealRain, environment: &Environment) -> Self {
        Self::with(scene, rain, contrast_of(environment), 0.0)
    }

    /// [`Cutoff::of`], with drops that are thinned as the scene says, else where their streaks are too faint to be seen.
    pub fn thinned(scene: &Scene, rain: &RealRain, environment: &Environment) -> Self {
        let contrast = contrast_of(environment);
        Self::with(scene, rain, contrast, thinned_px(scene, rain, contrast))
    }

    fn with(scene: &Scene, rain: &RealRain, contrast: f64, thinned_px: f64) -> Self {
        let (px, why) = Self::px_of(scene, rain, contrast, thinned_px);
        let thinned_px = if thinned_px > px { thinned_px } else { 0.0 };
        let frustum = Frustum::of(&scene.view(), rain.extent);
        let deviation = frustum.noise(&rain.law(), rain.air_density, px, exposed(scene).abs());
        let noise = contrast * deviation;
        let is_grainy = match scene.model.far_rain {
            None => noise > scene.model.error.unwrap_or(LEAST_SEEN),
            Some(far_rain) => far_rain == FarRain::Grain,
        };
        Self { px, thinned_px, why, noise, is_grainy }
    }

    /// Least radius in pixels of a drop that stands for itself alone.
    pub fn single_px(&self) -> f64 {
        self.px.max(self.thinned_px)
    }

    fn px_of(scene: &Scene, rain: &RealRain, contrast: f64, thinned_px: f64) -> (f64, String) {
        let (law, frustum) = (rain.law(), Frustum::of(&scene.view(), rain.extent));
        let ((wanted, why), most) = match (scene.model.far_rain, scene.model.cutoff_px) {
            (Some(FarRain::Drops), _) => ((0.0, "far_rain = \"drops\"".into()), MOST_ASKED),
            (_, Some(px)) => ((px, "as the scene says".into()), MOST_ASKED),
            _ => (of_contrast(scene, contrast), MOST_DROPS),
        };
        let wanted = wanted.max(thinned::LEAST * thinned_px);
        let drops = thinned::drops_drawn(&frustum, &law, wanted, thinned_px);
        let (fewer, why) = match drops > most {
            true => (
                cutoff_of_budget(&law, &frustum, most),
                format!(
                    "{:.0} million drops are drawn at most, and {:.3e} million are over {wanted} px",
                    most * 1e-6,
                    drops * 1e-6,
                ),
            ),
            false => (wanted, why),
        };
        let Some(field) = Field::of(scene) else { return (fewer, why) };
        let field = field.thinned(scene, thinned_px);
        let px = f64::from(field.seen(scene, fewer).cutoff_px);
        if px as f32 > fewer as f32 {
            return (
                px,
                format!("{fewer} px would be more cells of the rain than can be numbered"),
            );
        }
        (fewer, why)
    }
}

/// Contrast between drops and what is behind them.
fn contrast_of(environment: &Environment) -> f64 {
    contrast(environment).clamp(LEAST_CONTRAST, 1.0)
}

/// For how long each drop is seen at least: a film may slow down until its drops stand still.
fn exposed(scene: &Scene) -> f64 {
    match scene.film.is_default() {
        true => scene.drawn_exposure(),
        false => scene.drawn_shutter() * scene.film.least_pace(),
    }
}

/// Radius under which drops are thinned; 0: none are. In a streak of so small a drop a pixel changes by what it takes of it, π ρ²
/// over the streak's length in pixels, which is 2ρ over the drop's diameter times its way.
fn thinned_px(scene: &Scene, rain: &RealRain, contrast: f64) -> f64 {
    let model = &scene.model;
    if let Some(px) = model.thinned_px {
        return px;
    }
    let seen = model.error.unwrap_or(LEAST_SEEN);
    let is_instant = model.motion == Some(Motion::Instant) || scene.shutter() < LONG_EXPOSURE;
    if is_instant || seen < LEAST_SEEN || model.far_rain.is_some() || model.cutoff_px.is_some() {
        return 0.0;
    }
    let diameter = rain.law().median_volume_diameter();
    let speed = fall::density_factor(rain.air_density)
        * fall::terminal_speed(diameter, fall::TABLE_AIR_DENSITY);
    let diameters = speed * exposed(scene).abs() / (1e-3 * diameter);
    (2.0 * diameters * seen / (PI * contrast)).min(MOST_THINNED_PX)
}

fn of_contrast(scene: &Scene, contrast: f64) -> (f64, String) {
    let seen = scene.model.error.unwrap_or(LEAST_SEEN);
    let levels = 255.0 * seen;
    let shows = |contrast: f64| {
        format!("no smaller drop shows by {levels:.2}/255 at a contrast of {contrast:.2}")
    };
    let is_instant = scene.model.motion == Some(Motion::Instant);
    if scene.shutter() >= LONG_EXPOSURE && !is_instant && contrast < LEAST_CONTRAST_OF_STREAKS {
        let contrast = LEAST_CONTRAST_OF_STREAKS;
        let why =
            format!("{}, the least for streaks, many of which are seen together", shows(contrast));
        return (unseen_radius(contrast, seen), why);
    }
    (unseen_radius(contrast, seen), shows(contrast))
}
