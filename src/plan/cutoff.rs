//! From which size on drops of real rain are drawn one by one. Smaller ones are a medium.

use super::demand::contrast;
use crate::environment::Environment;
use crate::rain::field::Field;
use crate::rain::medium::{cutoff_of_budget, unseen_radius};
use crate::rain::visibility::Frustum;
use crate::scene::Scene;
use crate::scene::model::FarRain;
use crate::scene::real_rain::RealRain;

/// By how much a drop that is left to the medium may change a pixel, where no error is accepted: a grey level.
const LEAST_SEEN: f64 = 1.0 / 255.0;
/// Least contrast between drops and what is behind them that is reckoned with: there is no even sky.
const LEAST_CONTRAST: f64 = 0.1;
/// Most drops that a picture draws one by one where no cut-off is given, the paper's largest scene; and where the
/// scene asks for them. What is over it goes into the medium.
const MOST_DROPS: f64 = 4e6;
const MOST_ASKED: f64 = 8e6;

/// The cut-off of a scene's real rain.
#[derive(Clone, Debug, PartialEq)]
pub struct Cutoff {
    /// Least radius in pixels of a drop that is drawn by itself, at its depth on the view axis; 0: every drop is.
    pub px: f64,
    /// Why.
    pub why: String,
}

impl Cutoff {
    /// That of `scene`, whose rain is `rain`: as the scene says, else from the contrast of its environment, the
    /// accepted error and the exposure; larger where that would be more drops or cells than a picture takes.
    pub fn of(scene: &Scene, rain: &RealRain, environment: &Environment) -> Self {
        let (law, frustum) = (rain.law(), Frustum::of(&scene.view(), rain.extent));
        let (wanted, most) = match (scene.model.far_rain, scene.model.cutoff_px) {
            (Some(FarRain::Drops), _) => {
                (Self { px: 0.0, why: "far_rain = \"drops\"".into() }, MOST_ASKED)
            }
            (_, Some(px)) => (Self { px, why: "as the scene says".into() }, MOST_ASKED),
            _ => (Self::of_contrast(scene, rain, environment), MOST_DROPS),
        };
        let drops = frustum.drops_above(&law, wanted.px);
        let fewer = if drops > most {
            Self {
                px: cutoff_of_budget(&law, &frustum, most),
                why: format!(
                    "{:.0} million drops are drawn at most, and {:.3e} million are over {} px",
                    most * 1e-6,
                    drops * 1e-6,
                    wanted.px
                ),
            }
        } else {
            wanted
        };
        let Some(field) = Field::of(scene) else { return fewer };
        let px = f64::from(field.seen(scene, fewer.px).cutoff_px);
        if px as f32 > fewer.px as f32 {
            let why =
                format!("{} px would be more cells of the rain than can be numbered", fewer.px);
            return Self { px, why };
        }
        fewer
    }

    fn of_contrast(scene: &Scene, rain: &RealRain, environment: &Environment) -> Self {
        let seen = scene.model.error.unwrap_or(LEAST_SEEN);
        let contrast = contrast(environment).clamp(LEAST_CONTRAST, 1.0);
        // A film may slow down until its drops stand still.
        let exposed = if scene.film.is_default() { scene.drawn_exposure() } else { 0.0 };
        let levels = 255.0 * seen;
        Self {
            px: unseen_radius(&rain.law(), rain.air_density, contrast, seen, exposed),
            why: format!("no smaller drop shows by {levels:.2}/255 at a contrast of {contrast:.2}"),
        }
    }
}
