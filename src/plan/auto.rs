//! Preset `auto`: the models that a scene requires, chosen by measured error and estimated time.
//!
//! With an accepted error, the quickest model that keeps it. Without one, prefiltered pictures with as
//! much of a drop's light as takes no longer than the paper's method. Both come from what the scene shows
//! ([`Demand`]), how much its environment varies, how much of its light is from small bright sources, and
//! the tables of [`super::errors`].

use super::demand::{Demand, SizeClass, contrast};
use super::errors::{Error, Left, expected};
use super::{Light, NEAR_RADII, RAYS_PX};
use crate::environment::Environment;
use crate::environment::bright::split;
use crate::scene::model::{Optics, Order, Primitive, Reflection, Simulation};
use crate::scene::{ModelChoice, Scene};

/// What was chosen, and why.
#[derive(Clone, Debug, PartialEq)]
pub struct Choice {
    /// How the light leaving a drop is found.
    pub optics: Optics,
    /// What a drop is drawn as.
    pub primitive: Primitive,
    /// Rays a pixel.
    pub samples: u32,
    /// What is left out of a drop's light.
    pub light: Light,
    /// In plain words.
    pub reason: String,
    /// Whether it is expected to keep the accepted error.
    pub keeps: bool,
}

/// Costs in nanoseconds on two cores without a GPU (llvmpipe, docs/performance.md). Only ratios
/// matter, between ways that do the same work with the same units.
mod cost {
    /// The paper's: a drop, a drop in view, a pixel of a drop.
    pub const PAPER: [f64; 3] = [46.0, 900.0, 30.0];
    /// Tiles: a drop in view, a pixel of a drop from its prefiltered picture.
    pub const TILE: [f64; 2] = [200.0, 8.0];
    /// What a drop whose rays are followed costs beyond those.
    pub const BY_RAYS: f64 = 400.0;
    /// A fetch from the environment, with its share of a ray.
    pub const FETCH: f64 = 3.5;
    /// A pixel of the picture: what tiles take for it beyond what the paper's passes do.
    pub const TILE_PIXEL: f64 = 2.0;
}

/// Chooses for `scene`, whose drops look at `environment`.
pub fn choose(scene: &Scene, environment: &Environment) -> Choice {
    let demand = Demand::of(scene, NEAR_RADII);
    if asks_for_billboards(&scene.model) {
        return billboards("the scene's own choice of billboards");
    }
    let contrast = contrast(environment);
    let glints = split(environment).map_or(0.0, |bright| bright.strength());
    let papers_time = papers_time(&demand);
    let candidates = candidates();
    let judged = candidates.iter().map(|candidate| {
        (candidate, expected_error(candidate, &demand, contrast, glints), time(candidate, &demand))
    });
    // Those that keep the error by their time, before the others by their error.
    let merit = |accepted: f64, error: f64, time: f64| {
        if error <= accepted { (false, time) } else { (true, error) }
    };
    if let Some(accepted) = scene.model.error
        && let Some((chosen, error, time)) = judged.clone().min_by(|(_, a, s), (_, b, t)| {
            let (a, b) = (merit(accepted, *a, *s), merit(accepted, *b, *t));
            a.0.cmp(&b.0).then(a.1.total_cmp(&b.1))
        })
    {
        let keeps = error <= accepted;
        let how = if keeps {
            "the quickest within"
        } else {
            "no model is within reach of, the truest for"
        };
        let reason = format!(
            "{how} an RMS error of {accepted} (expected: {error:.4}, {:.1} of the paper's time)",
            time / papers_time.max(1.0)
        );
        return Choice { keeps, ..chosen.chosen(reason) };
    }
    // Unasked, the prefiltered pictures with one internal reflection at most: what more rays and the
    // second reflection add is little for what they take.
    let affordable = judged.filter(|(candidate, _, time)| {
        (candidate.optics, candidate.samples) == (Optics::Appearance, 1)
            && candidate.internal_reflections <= 1
            && *time <= papers_time
    });
    match affordable.min_by(|(_, a, s), (_, b, t)| a.total_cmp(b).then(s.total_cmp(t))) {
        Some((chosen, error, time)) => {
            let share = time / papers_time.max(1.0);
            let reason = format!(
                "prefiltered pictures, with all light that takes no longer than the paper's method \
                 (about {share:.1} of its time; expected RMS error {error:.4})"
            );
            chosen.chosen(reason)
        }
        None if demand.drops > 0.0 => billboards(
            "few large drops: rays through each of their pixels would take longer than the paper's \
             method; an accepted error buys them",
        ),
        None => billboards("no drops"),
    }
}

/// Whether another axis leaves only billboards.
pub(super) fn asks_for_billboards(model: &ModelChoice) -> bool {
    model.primitive.is_some_and(|primitive| primitive != Primitive::Tile)
        || model.order.is_some_and(|order| order != Order::Sorted)
        || model.simulation == Some(Simulation::Stored)
}

/// The paper's billboards by the closed form and one internal reflection: as quick as its mask, and a
/// little truer. For few large drops, whose rays would take longer than their billboards.
fn billboards(reason: &str) -> Choice {
    Choice {
        optics: Optics::ClosedForm,
        primitive: Primitive::Point,
        samples: 1,
        light: Light { internal_reflections: 1, ..Light::default() },
        reason: reason.into(),
        keeps: false,
    }
}

/// One way to draw all drops on tiles.
#[derive(Clone, Copy, Debug)]
struct Candidate {
    optics: Optics,
    samples: u32,
    reflection: Reflection,
    internal_reflections: u32,
}

impl Candidate {
    fn chosen(&self, reason: String) -> Choice {
        Choice {
            optics: self.optics,
            primitive: Primitive::Tile,
            samples: self.samples,
            light: Light {
                internal_reflections: self.internal_reflections,
                reflection: self.reflection,
                ..Light::default()
            },
            reason,
            keeps: true,
        }
    }

    fn by_rays(&self, class: &SizeClass) -> bool {
        self.optics == Optics::ClosedForm || class.is_near || class.radius_px > f64::from(RAYS_PX)
    }

    /// Fetches from the environment a ray.
    fn fetches(&self) -> f64 {
        let outside = if self.reflection == Reflection::On { 1.0 } else { 0.0 };
        outside + f64::from(self.internal_reflections) + 1.0
    }
}

/// Every combination that is worth a thought.
fn candidates() -> Vec<Candidate> {
    let mut all = Vec::new();
    for (optics, samples) in [
        (Optics::Appearance, 1),
        (Optics::Appearance, 4),
        (Optics::ClosedForm, 4),
        (Optics::ClosedForm, 16),
        (Optics::ClosedForm, 64),
    ] {
        for (reflection, internal_reflections) in
            [(Reflection::Off, 0), (Reflection::On, 0), (Reflection::On, 1), (Reflection::On, 2)]
        {
            all.push(Candidate { optics, samples, reflection, internal_reflections });
        }
    }
    all
}

/// RMS error over the picture: those of the sizes, weighted by how much of the picture shows them.
/// `glints` is the light of small bright sources over that of the rest.
fn expected_error(candidate: &Candidate, demand: &Demand, contrast: f64, glints: f64) -> f64 {
    let square = |class: &SizeClass| {
        let sampling = match (candidate.by_rays(class), candidate.samples) {
            (false, _) => Error::Appearance,
            (true, 1) => Error::Rays1,
            (true, 4) => Error::Rays4,
            (true, 16) => Error::Rays16,
            (true, _) => Error::Rays64,
        };
        let left = match (candidate.reflection, candidate.internal_reflections) {
            (Reflection::Off, _) => Left::Reflection,
            (_, 0) => Left::AllInside,
            (_, 1) => Left::AllButOneInside,
            _ => Left::Nothing,
        };
        let error = expected(sampling, left, class.radius_px);
        let square = (contrast * error.of_contrast).powi(2) + glints * error.of_glints.powi(2);
        class.share.min(1.0) * square
    };
    demand.classes.iter().map(square).sum::<f64>().sqrt()
}

fn papers_time(demand: &Demand) -> f64 {
    let pixels: f64 = demand.classes.iter().map(|class| class.pixels.max(0.0)).sum();
    let [drop, visible, pixel] = cost::PAPER;
    drop * demand.drops + visible * demand.visible + pixel * pixels
}

fn time(candidate: &Candidate, demand: &Demand) -> f64 {
    let [visible, pixel] = cost::TILE;
    let of_class = |class: &SizeClass| {
        if candidate.by_rays(class) {
            let ray = cost::FETCH * candidate.fetches();
            let drops = class.pixels / (std::f64::consts::PI * class.radius_px.powi(2));
            let rays = block_pixels(class.radius_px) * f64::from(candidate.samples) * ray;
            class.pixels * pixel + drops * (cost::BY_RAYS + rays)
        } else {
            class.pixels * pixel
        }
    };
    cost::TILE_PIXEL * demand.pixels
        + visible * demand.visible
        + demand.classes.iter().map(of_class).sum::<f64>()
}

/// Pixels of the tiles of 4 x 2 that a drop of radius `r` pixels meets: rays are followed in whole tiles.
fn block_pixels(r: f64) -> f64 {
    (2.0 * r + 4.0) * (2.0 * r + 2.0)
}
