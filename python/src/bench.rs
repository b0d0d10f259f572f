//! Frame times, as the command `bench` measures them.

use std::sync::Arc;

use pyo3::prelude::*;
use raindrops::device::{Device, user_folder};
use raindrops::environment::Environment;
use raindrops::measure::bench::{Effort, Row, Variant, measure};
use raindrops::measure::{self, costs::costs};
use raindrops::plan::{Output, plan_by};
use raindrops::scene::model::Preset;
use raindrops::scene::real_rain::RealRain;
use raindrops::scene::{RainSettings, Scene as Parsed};

use crate::interrupt::{listening, stop};
use crate::process::{Session, enter, tell_said};
use crate::raise::{Raise as _, exception, tell};
use crate::scene::Scene;

/// How much rain a row has.
enum Amount {
    Own,
    Drops(u32),
    Rate(f64),
}

impl Amount {
    fn apply(&self, scene: &mut Parsed) -> raindrops::Result<()> {
        match self {
            Self::Own => Ok(()),
            Self::Drops(count) => scene.set_random_count(*count),
            Self::Rate(rate) => {
                let rain = scene.real_rain().unwrap_or_default();
                scene.rain = Some(RainSettings::of(RealRain { rate: *rate, ..rain }));
                Ok(())
            }
        }
    }
}

/// Rows of `raindrops-bench/1` as JSON: every amount by every preset, with and without tone mapping.
#[pyfunction]
#[allow(clippy::too_many_arguments, reason = "keywords of Python")]
pub fn bench(
    py: Python<'_>,
    session: &Session,
    scene: &Scene,
    drops: Vec<u32>,
    rates: Vec<f64>,
    presets: Vec<String>,
    seconds: f64,
    frames: usize,
) -> PyResult<String> {
    enter()?;
    let mut wanted = Vec::new();
    for name in presets {
        let preset: Result<Preset, _> = serde_json::from_value(name.into());
        wanted.push(
            preset.map_err(|error| exception(py, "SceneError", &format!("preset: {error}")))?,
        );
    }
    let mut amounts: Vec<Amount> = drops.into_iter().map(Amount::Drops).collect();
    amounts.extend(rates.into_iter().map(Amount::Rate));
    if amounts.is_empty() {
        amounts.push(Amount::Own);
    }
    let effort = Effort { seconds, frames, stop };
    let work = |device: &Arc<Device>| -> raindrops::Result<_> {
        let environment = Environment::of(&scene.scene)?;
        let (mut rows, mut remarks) = (Vec::new(), Vec::new());
        for amount in &amounts {
            let mut variants = Vec::new();
            for preset in &wanted {
                let mut scene = scene.scene.clone();
                scene.model.take_preset(*preset);
                amount.apply(&mut scene)?;
                scene.validate("bench")?;
                scene.read_particles()?;
                scene.read_shelter()?;
                let choice = match preset {
                    Preset::Auto => {
                        let costs = costs(device, user_folder().as_deref(), crate::process::say)?;
                        measure::resolve(device, &scene, &environment, &costs)?
                    }
                    _ => None,
                };
                for output in [Output::Display, Output::Radiance] {
                    let plan = plan_by(&scene, &environment, choice.as_ref(), output)?;
                    remarks.extend(plan.remarks());
                    variants.push(Variant { plan, scene: scene.clone() });
                }
            }
            let measured = measure(device, &environment, &variants, effort, &|_| ())?;
            for (variant, of) in variants.iter().zip(&measured) {
                rows.push(Row::new(variant, &environment, of, None));
            }
        }
        Ok((rows, remarks))
    };
    let measured = listening(py, || session.on_device(work))?;
    tell_said(py)?;
    let (rows, remarks) = measured.raise(py)?;
    tell(py, "", &remarks)?;
    serde_json::to_string(&rows).map_err(|error| exception(py, "Error", &error.to_string()))
}
