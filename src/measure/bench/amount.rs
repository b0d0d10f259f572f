//! How much rain a row of a series has: a number of equal drops, or a rate in mm/h.

use super::Row;
use super::report::thousands;
use crate::scene::real_rain::RealRain;
use crate::scene::{RainSettings, Scene};

/// How much rain.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Amount {
    /// Random drops in the scene's box.
    Drops(u32),
    /// Real rain, mm/h.
    Rate(f64),
}

impl Amount {
    /// That of a row, whose scene has `placed` drops placed by hand.
    pub fn of_row(drops: u32, rate_mm_h: Option<f64>, placed: u32) -> Self {
        rate_mm_h.map_or(Self::Drops(drops - placed), Self::Rate)
    }

    /// The scene with so much rain; what else it says of its rain it keeps.
    pub fn apply(self, scene: &mut Scene) {
        match self {
            Self::Drops(count) => scene.rain.get_or_insert_default().count = count,
            Self::Rate(rate) => {
                let rain = scene.real_rain().unwrap_or_default();
                scene.rain = Some(RainSettings::of(RealRain { rate, ..rain }));
            }
        }
    }

    /// The option of `bench` that measures a series of it, and what stands there.
    pub fn option(self) -> (&'static str, String) {
        match self {
            Self::Drops(count) => ("--drops", count.to_string()),
            Self::Rate(rate) => ("--rain", rate.to_string()),
        }
    }

    /// What a frame of it takes, in drops, very roughly.
    pub fn effort(self) -> f64 {
        match self {
            Self::Drops(count) => f64::from(count) + 1e5,
            Self::Rate(rate) => 2e4 * rate + 1e5,
        }
    }
}

impl Row {
    /// How much rain it has, as tables say it.
    pub fn amount(&self) -> String {
        match self.rate_mm_h {
            Some(rate) => format!("{rate} mm/h"),
            None => thousands(self.drops.into()),
        }
    }

    /// Its place on an axis of rates or of drops.
    pub fn along(&self) -> f64 {
        self.rate_mm_h.unwrap_or(f64::from(self.drops.max(1)))
    }
}
