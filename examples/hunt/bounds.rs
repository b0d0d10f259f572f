//! What a picture may be off by: the bounds that every scene of the search is held to.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

use super::figures::Figures;
use super::row::ModelRow;

/// A figure's name and its bounds, of `fast` (and `auto`) and of `exact`.
pub const BOUNDS: [(&str, [f64; 2]); 5] = [
    ("box", [8.0, 4.0]),
    ("dots", [5.0, 4.0]),
    ("flip", [0.15, 0.08]),
    ("step", [2.0, 1.5]),
    // Pixels that differ between runs.
    ("bytes", [0.0, 0.0]),
];

/// A figure that is over its bound.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize)]
pub struct Miss {
    /// The model whose picture it is of.
    pub model: String,
    /// Which figure.
    pub figure: String,
    /// What it is.
    pub value: f64,
    /// What it may be.
    pub bound: f64,
    /// The reference's noise in this figure is over half of the bound, and the figure is not far above both: it may be the
    /// noise that is over the bound.
    pub is_unsure: bool,
    /// A warning named the model when the scene was drawn.
    pub is_warned: bool,
}

impl Miss {
    /// How many times the bound the figure is; of `bytes`, any difference counts as three times.
    pub fn times(&self) -> f64 {
        if self.bound > 0.0 { self.value / self.bound } else { 3.0 }
    }

    /// Whether it counts.
    pub fn counts(&self) -> bool {
        !self.is_unsure && !self.is_warned
    }
}

/// The bound of a model's figure.
pub fn bound(model: &str, figure: &str) -> f64 {
    let of = BOUNDS.iter().find(|(name, _)| *name == figure);
    of.map_or(f64::INFINITY, |(_, bounds)| bounds[usize::from(model == "exact")])
}

/// The noise of `dots` is taken off a mean over all drops' pixels, not off one box or a few pixels: little of it is left.
pub fn noise_of_dots(noise: &Figures) -> f64 {
    0.25 * noise.dots
}

/// The figures of the models that are over their bounds; `error`: what `auto` was asked to keep.
pub fn misses(
    models: &BTreeMap<String, ModelRow>,
    noise: &Figures,
    error: Option<f64>,
) -> Vec<Miss> {
    let mut found = Vec::new();
    for (name, model) in models {
        let Figures { boxes, dots, flip, rms } = model.figures;
        let mut all = vec![
            ("box", boxes, noise.boxes, bound(name, "box")),
            ("dots", dots, noise_of_dots(noise), bound(name, "dots")),
            ("flip", flip, noise.flip, bound(name, "flip")),
        ];
        if let (Some(error), "auto") = (error, &**name) {
            all.push(("error", rms, noise.rms, error));
        }
        if let Some(step) = &model.step {
            all.push(("step", step.largest, 0.0, bound(name, "step")));
        }
        if let Some(bytes) = &model.bytes {
            all.push(("bytes", bytes.most().into(), 0.0, 0.0));
        }
        for (figure, value, noise, bound) in all {
            if value > bound {
                let is_unsure = noise > 0.5 * bound && value < bound + 2.0 * noise;
                let is_warned = !model.warnings.is_empty();
                let (model, figure) = (name.clone(), figure.to_string());
                found.push(Miss { model, figure, value, bound, is_unsure, is_warned });
            }
        }
    }
    found
}
