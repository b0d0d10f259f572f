//! How much rain a row of a series has: a number of equal drops, or a rate in mm/h.

use super::Row;
use crate::Result;
use crate::scene::real_rain::RealRain;
use crate::scene::{RainSettings, Scene};
use crate::thousands::thousands;

/// How much rain.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Amount {
    /// Random drops in the scene's boxes.
    Drops(u32),
    /// Real rain, mm/h.
    Rate(f64),
}

impl Amount {
    /// That of a row, whose scene has `placed` drops placed by hand.
    pub fn of_row(drops: u32, rate_mm_h: Option<f64>, placed: u32) -> Self {
        rate_mm_h.map_or(Self::Drops(drops.saturating_sub(placed)), Self::Rate)
    }

    /// The scene with so much rain; what else it says of its rain it keeps.
    ///
    /// # Errors
    /// See [`Scene::set_random_count`].
    pub fn apply(self, scene: &mut Scene) -> Result<()> {
        match self {
            Self::Drops(count) => scene.set_random_count(count)?,
            Self::Rate(rate) => {
                let rain = scene.real_rain().unwrap_or_default();
                scene.rain = Some(RainSettings::of(RealRain { rate, ..rain }));
            }
        }
        Ok(())
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

#[cfg(test)]
mod tests {
    use super::*;

    /// `bench` compares a row's drops in view with the CPU's count of the scene that the row's number gives back.
    #[test]
    fn a_row_of_several_populations_gives_back_its_scene() {
        let text = "[[rain]]\ncount = 30\n[[rain]]\ncount = 20\n[[drop]]\ncenter = [0, 0, -5]";
        let scene = Scene::parse(text, "a scene").expect("a scene");
        let mut again = scene.clone();
        Amount::of_row(scene.drop_count(), None, 1).apply(&mut again).expect("as many");
        assert_eq!(again, scene);
        Amount::Drops(25).apply(&mut again).expect("more than the second has");
        let counts: Vec<_> = again.populations().iter().map(|rain| rain.count).collect();
        assert_eq!(counts, [5, 20]);
        assert!(Amount::Drops(19).apply(&mut again).is_err());
    }
}
