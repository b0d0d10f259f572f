//! Preset `auto`: what the scene shows → candidates → expected error and time of each → a choice, with its
//! reason.
//!
//! With an accepted error it is the quickest that keeps it. Without one it is the truest that a frame's time
//! affords on the device, and never less than preset `fast`, unless the scene names a budget that `fast`
//! is over. What is expected comes from what the scene shows ([`Demand`]), its sky ([`Background`]), the tables
//! of [`super::errors`] and the device's [`Costs`]. Whoever has a device measures what was chosen
//! (`measure::resolve`).

use serde::{Deserialize, Serialize};

use super::background::Background;
use super::costs::{Costs, Rays};
use super::cutoff::Cutoff;
use super::demand::{Demand, SizeClass, contrast_at};
use super::errors::{Error, Left, expected};
use super::rays::MOST_RAYS_PX;
use super::{FramePlan, Light, NEAR_RADII};
use crate::environment::Environment;
use crate::environment::bright::split;
use crate::scene::model::{Optics, Order, Preset, Primitive, Reflection, Simulation};
use crate::scene::{ModelChoice, Scene};
use crate::thousands::counted;

/// Milliseconds of a frame where the scene names neither an error nor a budget.
const FRAME_MS: f64 = 1000.0 / 60.0;

/// A model that takes no more than this share of another's time takes as long as that.
const HARDLY: f64 = 1.03;
/// A drop drawn as a point or quad takes so many splats, on CPU drivers (docs/results).
const BILLBOARD_IN_SPLATS: f64 = 14.0;

/// What was chosen, and why. Kept beside a sequence, so that all its frames have the same models.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Choice {
    /// How the light leaving a drop is found.
    pub optics: Optics,
    /// What a drop is drawn as.
    pub primitive: Primitive,
    /// Rays a pixel.
    pub samples: u32,
    /// In plain words.
    pub reason: String,
    /// What was asked for and may not be kept.
    pub doubt: Option<String>,
    /// What is left out of a drop's light.
    pub light: Light,
}

/// One way to draw all drops on tiles.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Candidate {
    optics: Optics,
    samples: u32,
    reflection: Reflection,
    internal_reflections: u32,
}

/// A candidate, with what it is expected to do.
#[derive(Clone, Copy, Debug)]
pub struct Prospect {
    candidate: Candidate,
    /// RMS error of sRGB values, 0 to 1.
    pub error: f64,
    /// Milliseconds a frame.
    pub ms: f64,
}

impl Prospect {
    /// This prospect with an error that is better known.
    pub fn with_error(self, error: f64) -> Self {
        Self { error, ..self }
    }
}

/// What `auto` takes for `scene`, as expected; `None` for another preset.
pub fn choose(scene: &Scene, environment: &Environment, costs: &Costs) -> Option<Choice> {
    let model = &scene.model;
    if model.preset != Preset::Auto {
        return None;
    }
    let choice = if asks_for_billboards(model) {
        let doubt = model.error.map(|error| {
            format!("error {error} is out of reach of the billboards that the scene asks for")
        });
        Choice { doubt, ..billboards("the scene's own choice of billboards") }
    } else {
        let prospects = prospects(scene, environment, costs);
        match model.error {
            Some(accepted) => keep(accepted, model.budget_ms, &prospects, "expected"),
            None => afford(model.budget_ms, &prospects),
        }
    };
    let reason = format!("{} (times of {})", choice.reason, costs.of);
    Some(Choice { reason, ..choice }.doubted(model))
}

/// What `scene` asks, its real rain included.
fn demand_of(scene: &Scene, environment: &Environment) -> Demand {
    let mut demand = Demand::of(scene, NEAR_RADII);
    if let Some(rain) = scene.real_rain() {
        let cutoff = Cutoff::thinned(scene, &rain, environment);
        demand.add_real_rain(&rain, &cutoff, &scene.view());
    }
    demand
}

/// Milliseconds that a frame by `plan` is expected to take; of points and quads very roughly.
pub fn expected_ms(
    scene: &Scene,
    environment: &Environment,
    costs: &Costs,
    plan: &FramePlan,
) -> f64 {
    let demand = demand_of(scene, environment);
    let FramePlan { optics, samples, light, .. } = *plan;
    let Light { internal_reflections, reflection, .. } = light;
    match plan.primitive {
        Primitive::Tile => {
            let candidate = Candidate { optics, samples, reflection, internal_reflections };
            costs.frame_ms(&demand, |class| candidate.rays(class))
        }
        Primitive::Point | Primitive::Quad => {
            let visible = f64::from(samples) * BILLBOARD_IN_SPLATS * demand.visible;
            costs.frame_ms(&Demand { visible, ..demand }, |_| None)
        }
    }
}

/// Every candidate for `scene`, quickest first.
pub fn prospects(scene: &Scene, environment: &Environment, costs: &Costs) -> Vec<Prospect> {
    let demand = demand_of(scene, environment);
    let background = Background::of(scene, environment);
    let contrast = contrast_at(environment, background.exposure);
    let glints = split(environment).map_or(0.0, |bright| bright.strength());
    let prospect = |candidate: Candidate| Prospect {
        candidate,
        error: candidate.error(&demand, contrast, glints).hypot(background.error),
        ms: costs.frame_ms(&demand, |class| candidate.rays(class)),
    };
    let mut all: Vec<Prospect> = candidates().into_iter().map(prospect).collect();
    all.sort_by(|a, b| a.ms.total_cmp(&b.ms));
    all
}

/// The one of `prospects`, quickest first, that keeps an error: the quickest, or what is truer and takes hardly
/// longer. Where none does, the truest. `None` of none.
pub fn pick(accepted: f64, prospects: &[Prospect]) -> Option<usize> {
    let truest = |most_ms: f64| {
        let affordable = (0..prospects.len()).filter(|n| prospects[*n].ms <= most_ms);
        affordable.min_by(|a, b| prospects[*a].error.total_cmp(&prospects[*b].error))
    };
    let quickest = prospects.iter().find(|prospect| prospect.error <= accepted);
    truest(quickest.map_or(f64::INFINITY, |quickest| HARDLY * quickest.ms))
}

/// What [`pick`] takes of `prospects`, quickest first. `how` says where their errors come from.
pub fn keep(accepted: f64, budget_ms: Option<f64>, prospects: &[Prospect], how: &str) -> Choice {
    let Some(number) = pick(accepted, prospects) else { return billboards("no candidates") };
    let chosen = &prospects[number];
    let (error, ms) = (chosen.error, chosen.ms);
    let (what, doubt) = if error > accepted {
        let doubt = format!(
            "error {accepted} is out of reach of every model that goes with this scene: \
                             the truest is at {error:.4}"
        );
        ("the truest, as no model reaches", Some(doubt))
    } else if budget_ms.is_some_and(|budget| budget < ms) {
        let doubt = format!("error {accepted} takes about {ms:.1} ms a frame, over budget_ms");
        ("the quickest within", Some(doubt))
    } else {
        ("the quickest within", None)
    };
    let reason =
        format!("{what} an RMS error of {accepted}: {error:.4} {how}, about {ms:.1} ms a frame");
    chosen.candidate.chosen(reason, doubt)
}

/// The truest that `budget_ms` affords, or a frame of 1/60 s; without a budget never under `fast`.
fn afford(budget_ms: Option<f64>, prospects: &[Prospect]) -> Choice {
    let limit = budget_ms.unwrap_or(FRAME_MS);
    let rung = |candidate: Candidate| LADDER.iter().position(|rung| *rung == candidate);
    let on_ladder = prospects.iter().filter_map(|p| Some((rung(p.candidate)?, p)));
    let affordable = on_ladder.clone().filter(|(_, prospect)| prospect.ms <= limit);
    let words = |prospect: &Prospect, what: &str| {
        let (error, ms) = (prospect.error, prospect.ms);
        format!("{what} of {limit:.1} ms a frame: about {ms:.1} ms, expected RMS error {error:.4}")
    };
    if let Some((_, prospect)) = affordable.max_by_key(|(rung, _)| *rung) {
        return prospect.candidate.chosen(words(prospect, "the truest within a budget"), None);
    }
    if budget_ms.is_none()
        && let Some((_, fast)) = on_ladder.min_by_key(|(rung, _)| *rung)
    {
        return fast.candidate.chosen(words(fast, "preset fast, beyond a budget"), None);
    }
    // The budget is under what `fast` takes: models that leave out light.
    let saving = prospects.iter().filter(|prospect| prospect.ms <= limit);
    if let Some(prospect) = saving.min_by(|a, b| a.error.total_cmp(&b.error)) {
        let reason = words(prospect, "less than fast, the truest within a budget");
        return prospect.candidate.chosen(reason, None);
    }
    let Some(quickest) = prospects.first() else { return billboards("no candidates") };
    let doubt = format!(
        "budget_ms {limit} is out of reach: the quickest takes about {:.1} ms a frame",
        quickest.ms
    );
    quickest.candidate.chosen(words(quickest, "the quickest, beyond a budget"), Some(doubt))
}

/// Whether another axis leaves only billboards.
pub(super) fn asks_for_billboards(model: &ModelChoice) -> bool {
    model.primitive.is_some_and(|primitive| primitive != Primitive::Tile)
        || model.order.is_some_and(|order| order != Order::Sorted)
        || model.simulation == Some(Simulation::Stored)
}

/// The paper's billboards by the closed form and one internal reflection: as quick as its mask, and a
/// little truer.
fn billboards(reason: &str) -> Choice {
    Choice {
        optics: Optics::ClosedForm,
        primitive: Primitive::Point,
        samples: 1,
        light: Light { internal_reflections: 1, ..Light::default() },
        reason: reason.into(),
        doubt: None,
    }
}

impl Choice {
    /// The models and the reason in a line.
    pub fn summary(&self) -> String {
        let Light { internal_reflections, reflection, .. } = self.light;
        format!(
            "{} on {}, {} a pixel, {}, reflection {reflection}: {}",
            self.optics,
            self.primitive,
            counted(self.samples.into(), "ray"),
            counted(internal_reflections.into(), "internal reflection"),
            self.reason
        )
    }

    /// Models that were chosen by hand take the place of its own, and its promise.
    fn doubted(mut self, model: &ModelChoice) -> Self {
        let others = model.overrides();
        if let Some(error) = model.error
            && self.doubt.is_none()
            && !others.is_empty()
        {
            self.doubt =
                Some(format!("error {error} is not promised with one's own {}", others.join(", ")));
        }
        self
    }
}

/// What `auto` goes up by where no error is given: each step takes longer than the one before, and leaves
/// no drop less true. The first is preset `fast`.
const LADDER: [Candidate; 4] = [
    Candidate::up_to(2, Optics::Appearance, 1),
    Candidate::up_to(8, Optics::Appearance, 4),
    Candidate::up_to(8, Optics::ClosedForm, 16),
    Candidate::up_to(8, Optics::ClosedForm, 64),
];

impl Candidate {
    /// With all of a drop's light, but what is reflected within it more often.
    const fn up_to(internal_reflections: u32, optics: Optics, samples: u32) -> Self {
        Self { optics, samples, reflection: Reflection::On, internal_reflections }
    }

    fn chosen(&self, reason: String, doubt: Option<String>) -> Choice {
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
            doubt,
        }
    }

    /// What is followed through the pixels of such drops; none where their prefiltered pictures do.
    fn rays(&self, class: &SizeClass) -> Option<Rays> {
        let by_rays = self.optics == Optics::ClosedForm
            || class.is_near
            || class.radius_px > f64::from(MOST_RAYS_PX);
        let outside = if self.reflection == Reflection::On { 1 } else { 0 };
        // A ray follows no more orders than matter to it: of eight, three on the mean at most.
        let fetches = outside + self.internal_reflections.min(3) + 1;
        by_rays.then_some(Rays { samples: self.samples, fetches })
    }

    /// RMS error over the picture. What each drop has for itself adds up by squares; light that is left
    /// out of all drops adds up as it is, where many are over one another. `glints` is the light of small
    /// bright sources over that of the rest.
    fn error(&self, demand: &Demand, contrast: f64, glints: f64) -> f64 {
        let left = match (self.reflection, self.internal_reflections) {
            (Reflection::Off, _) => Left::Reflection,
            (_, 0) => Left::AllInside,
            (_, 1) => Left::AllButOneInside,
            _ => Left::Nothing,
        };
        let of_class = |class: &SizeClass| {
            let sampling = match (self.rays(class).is_some(), self.samples) {
                (false, _) => Error::Appearance,
                (true, 1) => Error::Rays1,
                (true, 4) => Error::Rays4,
                (true, 16) => Error::Rays16,
                (true, _) => Error::Rays64,
            };
            let error = expected(sampling, left, class.radius_px);
            let square = (contrast * error.of_contrast).powi(2) + glints * error.of_glints.powi(2);
            class.weight.min(1.0) * square
        };
        let each: f64 = demand.classes.iter().map(of_class).sum();
        // The error at 1 pixel stands for smaller drops too: one of them covers a pixel in part, but many fill it.
        let of_all =
            |class: &SizeClass| class.share * contrast * left.of_contrast(class.radius_px.max(1.0));
        let all: f64 = demand.classes.iter().map(of_all).sum();
        each.max(all * all).sqrt()
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
        let reflection = Reflection::Off;
        all.push(Candidate { optics, samples, reflection, internal_reflections: 0 });
        for internal_reflections in [0, 1, 2, 8] {
            all.push(Candidate::up_to(internal_reflections, optics, samples));
        }
    }
    all
}
