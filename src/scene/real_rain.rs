//! Rain as weather has it: `[rain] rate = 25` and what goes with it in a scene file.
//!
//! A `[rain]` table is either a number of equal drops in a box (the paper's) or a rate in mm/h. Keys of both
//! in one table are refused: one of them would be ignored.

use std::fmt;

use glam::DVec3;
use schemars::JsonSchema;
use serde::de::value::{MapAccessDeserializer, SeqAccessDeserializer};
use serde::de::{Deserializer, MapAccess, SeqAccess, Visitor};
use serde::{Deserialize, Serialize};

use super::model::{DropShape, Sizes};
use super::{MAX_DROPS, Population, RainSettings};
use crate::abi::MOST_POPULATIONS;
use crate::rain::cells::{FARTHEST, Lattice, lattices};
use crate::rain::classes::{CLASSES, Class, classes};
use crate::rain::law::{Law, marshall_palmer_slope, slope_of_median, ulbrich_intercept};
use crate::rain::thinned;

/// Rates in mm/h: from a trace to the heaviest minute on record.
pub const RATES: std::ops::RangeInclusive<f64> = 0.001..=2000.0;

/// Fastest wind in m/s, over that of any storm on record.
const FASTEST_WIND: f64 = 150.0;

/// Real rain: how much falls, as drops of which sizes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RealRain {
    /// Rain that falls in still air, mm/h.
    pub rate: f64,
    /// The law of the drops' sizes.
    pub sizes: Sizes,
    /// Least and largest diameter, mm.
    pub diameters: [f64; 2],
    /// Exponent μ of the gamma law.
    pub mu: f64,
    /// Median-volume diameter of the gamma law without cut-offs, mm. Where none is given it follows from the rate and μ.
    pub median_diameter: Option<f64>,
    /// Air density, kg/m³: drops fall faster in thin air.
    pub air_density: f64,
    /// Added to the velocity at which each size falls, m/s.
    pub wind: DVec3,
    /// The shape of the drops.
    pub shape: DropShape,
    /// Distance from the camera to the rain's end, m; may be infinite.
    pub extent: f64,
}

impl Default for RealRain {
    fn default() -> Self {
        Self {
            rate: 25.0,
            sizes: Sizes::MarshallPalmer,
            diameters: [0.25, 6.0],
            mu: 3.0,
            median_diameter: None,
            air_density: 1.20,
            wind: DVec3::ZERO,
            shape: DropShape::Equilibrium,
            extent: 300.0,
        }
    }
}

impl RealRain {
    /// The law of sizes, with as many drops as make the rate in this air.
    ///
    /// A gamma law without a median-volume diameter rains less where Λ would have to be under 0, which
    /// [`crate::scene::Scene::validate`] refuses.
    pub fn law(&self) -> Law {
        let Self { rate, mu, air_density, .. } = *self;
        let [from, to] = self.diameters;
        let law = |mu, slope| Law { intercept: 1.0, mu, slope, from, to };
        match (self.sizes, self.median_diameter) {
            (Sizes::Gamma, None) => self.ulbrich().with_slope_of_rate(rate, air_density),
            (Sizes::Gamma, Some(median)) => {
                law(mu, slope_of_median(mu, median)).normalised(rate, air_density)
            }
            (Sizes::MarshallPalmer, _) => {
                law(0.0, marshall_palmer_slope(rate)).normalised(rate, air_density)
            }
            (Sizes::Uniform, _) => law(0.0, 0.0).normalised(rate, air_density),
        }
    }

    /// Ulbrich's law of this μ, before its Λ is known.
    fn ulbrich(&self) -> Law {
        let [from, to] = self.diameters;
        Law { intercept: ulbrich_intercept(self.mu), mu: self.mu, slope: 0.0, from, to }
    }

    /// The drops by the speed at which they fall.
    pub fn classes(&self) -> Vec<Class> {
        let mut classes = classes(&self.law(), self.air_density);
        if self.shape == DropShape::Sphere {
            classes.iter_mut().for_each(|class| class.axis_ratio = 1.0);
        }
        classes
    }

    /// The cells of every class.
    pub fn lattices(&self, seed: u64) -> Vec<Lattice> {
        lattices(seed, 0, &self.law(), &self.classes(), self.wind)
    }

    /// The cells of the rain that has fewer drops, which are seen beyond where its own are thinned.
    pub fn lattices_beyond(&self, seed: u64) -> Vec<Lattice> {
        let law = self.law();
        lattices(seed, CLASSES, &law, &thinned::classes_beyond(&law, self.air_density), self.wind)
    }

    /// Rain that falls through a level plane, mm/h: the rate, less what an updraught holds up.
    pub fn rate_that_falls(&self) -> f64 {
        let law = self.law();
        // g/m³ times m/s is 3.6 mm/h.
        law.rate(self.air_density) - 3.6 * law.water() * self.wind.y
    }

    /// Says what is wrong with a value, and what would be right.
    pub(super) fn validate(&self) -> Result<(), String> {
        let Self { diameters: [from, to], wind, .. } = *self;
        // A narrower law has fewer than a hundred steps of a drop's diameter.
        if to - from < 1e-4 {
            return Err(format!(
                "rain: diameters = [{from}, {to}] must ascend by 0.0001 mm at least: the least, then the largest"
            ));
        }
        self.validate_median()?;
        if wind.length() > FASTEST_WIND {
            return Err(format!(
                "rain: wind = [{}, {}, {}] is over {FASTEST_WIND} m/s; give metres a second",
                wind.x, wind.y, wind.z
            ));
        }
        Ok(())
    }

    /// Says what is wrong with the median-volume diameter, or with a gamma law that has none.
    fn validate_median(&self) -> Result<(), String> {
        let Self { rate, sizes, diameters: [from, to], mu, median_diameter, .. } = *self;
        match (sizes, median_diameter) {
            (Sizes::Gamma, Some(median)) if !(from..=to).contains(&median) => Err(format!(
                "rain: median_diameter = {median} is not within the diameters, {from} to {to} mm"
            )),
            (Sizes::Gamma, None) => {
                let most = self.ulbrich().most_rate(self.air_density);
                if rate <= most {
                    return Ok(());
                }
                let most = if most < 0.01 { format!("{most:.1e}") } else { format!("{most:.2}") };
                Err(format!(
                    "rain: a gamma law with mu = {mu} and drops of {from} to {to} mm rains {most} mm/h at most, not \
                     {rate}: give median_diameter in mm, another mu, or wider diameters"
                ))
            }
            (Sizes::MarshallPalmer | Sizes::Uniform, Some(_)) => {
                Err(format!("rain: median_diameter is for sizes = \"gamma\", not for \"{sizes}\""))
            }
            _ => Ok(()),
        }
    }

    /// Says what is wrong with a camera for this rain.
    pub(super) fn validate_camera(position_m: DVec3) -> Result<(), String> {
        if position_m.abs().max_element() <= FARTHEST {
            return Ok(());
        }
        Err(format!("camera: position is over {FARTHEST:e} m from the origin, where rain ends"))
    }
}

/// The `[rain]` table as it is written.
#[derive(Clone, Default, Deserialize, Serialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub(super) struct RainTable {
    /// Chooses the starting places of drops in a box; 64 bits.
    #[schemars(extend("x-default" = "the scene's, plus the number of populations before"))]
    #[serde(skip_serializing_if = "Option::is_none")]
    seed: Option<u64>,
    /// How many equal drops; excludes `rate`.
    #[schemars(range(max = MAX_DROPS), extend("x-default" = "1,000,000"))]
    #[serde(skip_serializing_if = "Option::is_none")]
    count: Option<u32>,
    /// Half the edges of the box that holds equal drops; it repeats around the camera.
    #[schemars(with = "Option<[f64; 3]>", extend("exclusiveMinimum" = 0, "x-unit" = "scene units", "x-default" = "1025 1025 1025"))]
    #[serde(skip_serializing_if = "Option::is_none")]
    half_extent: Option<DVec3>,
    /// Radius of equal drops; less than every half extent.
    #[schemars(extend("exclusiveMinimum" = 0, "x-unit" = "scene units", "x-default" = "1"))]
    #[serde(skip_serializing_if = "Option::is_none")]
    radius: Option<f64>,
    /// Velocity of equal drops.
    #[schemars(with = "Option<[f64; 3]>", extend("x-unit" = "scene units/s", "x-default" = "0 -9 0"))]
    #[serde(skip_serializing_if = "Option::is_none")]
    velocity: Option<DVec3>,
    /// Rain that falls in still air: real rain without end instead of a box.
    #[schemars(range(min = *RATES.start(), max = *RATES.end()), extend(
        "x-unit" = "mm/h",
        "x-advice" = "for no rain leave the rate out, and give count = 0"
    ))]
    #[serde(skip_serializing_if = "Option::is_none")]
    rate: Option<f64>,
    /// The law of the sizes of real rain.
    #[schemars(extend("x-default" = "`marshall-palmer`"))]
    #[serde(skip_serializing_if = "Option::is_none")]
    sizes: Option<Sizes>,
    /// Least and largest diameter of real rain.
    #[schemars(extend("minimum" = 0.01, "maximum" = 10, "x-unit" = "mm", "x-default" = "0.25 6"))]
    #[serde(skip_serializing_if = "Option::is_none")]
    diameters: Option<[f64; 2]>,
    /// Exponent μ of the gamma law.
    #[schemars(extend("exclusiveMinimum" = -1, "maximum" = 50, "x-default" = "3"))]
    #[serde(skip_serializing_if = "Option::is_none")]
    mu: Option<f64>,
    /// With `sizes = "gamma"`: the median-volume diameter of the law without cut-offs, within `diameters`.
    #[schemars(extend("x-unit" = "mm", "x-default" = "from the rate and `mu`"))]
    #[serde(skip_serializing_if = "Option::is_none")]
    median_diameter: Option<f64>,
    /// Density of the air: drops fall faster in thin air.
    #[schemars(range(min = 0.1, max = 10), extend("x-unit" = "kg/m³", "x-default" = "1.2"))]
    #[serde(skip_serializing_if = "Option::is_none")]
    air_density: Option<f64>,
    /// Added to the velocity at which each size falls; up to 150 m/s.
    #[schemars(with = "Option<[f64; 3]>", extend("x-unit" = "m/s", "x-default" = "0 0 0"))]
    #[serde(skip_serializing_if = "Option::is_none")]
    wind: Option<DVec3>,
    /// The shape of real rain's drops.
    #[schemars(extend("x-default" = "`equilibrium`"))]
    #[serde(skip_serializing_if = "Option::is_none")]
    shape: Option<DropShape>,
    /// Distance from the camera to the rain's end.
    #[schemars(extend("exclusiveMinimum" = 0, "x-infinite" = true, "x-unit" = "m", "x-default" = "300"))]
    #[serde(skip_serializing_if = "Option::is_none")]
    extent: Option<f64>,
}

/// `[rain]`, or `[[rain]]` for each population.
#[derive(Clone, Serialize, JsonSchema)]
#[serde(untagged)]
pub(super) enum RainTables {
    One(Box<RainTable>),
    Several(Vec<RainTable>),
}

impl<'de> Deserialize<'de> for RainTables {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct Tables;

        impl<'de> Visitor<'de> for Tables {
            type Value = RainTables;

            fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                f.write_str("a table `[rain]`, or several `[[rain]]`")
            }

            fn visit_map<A: MapAccess<'de>>(self, map: A) -> Result<RainTables, A::Error> {
                RainTable::deserialize(MapAccessDeserializer::new(map))
                    .map(|table| RainTables::One(table.into()))
            }

            fn visit_seq<A: SeqAccess<'de>>(self, seq: A) -> Result<RainTables, A::Error> {
                Vec::deserialize(SeqAccessDeserializer::new(seq)).map(RainTables::Several)
            }
        }

        deserializer.deserialize_any(Tables)
    }
}

impl TryFrom<RainTables> for RainSettings {
    type Error = String;

    fn try_from(tables: RainTables) -> Result<Self, String> {
        let tables = match tables {
            RainTables::One(table) => return Self::try_from(*table),
            RainTables::Several(tables) => tables,
        };
        let each: Vec<Self> =
            tables.into_iter().map(Self::try_from).collect::<Result<_, String>>()?;
        let most = MOST_POPULATIONS as usize;
        let [first, others @ ..] = &each[..] else {
            return Err("rain: the list is empty; leave it out, or give count = 0".into());
        };
        if each.len() > most {
            return Err(format!("rain: {} populations are over {most}", each.len()));
        }
        if each.len() > 1 && each.iter().any(|rain| rain.real.is_some()) {
            return Err("rain: real rain (rate) stands alone, beside no other [[rain]]".into());
        }
        let mut settings = *first;
        for (place, rain) in settings.others.iter_mut().zip(others) {
            *place = rain.populations().next();
        }
        Ok(settings)
    }
}

impl From<RainSettings> for RainTables {
    fn from(settings: RainSettings) -> Self {
        if settings.others.iter().flatten().next().is_none() {
            return Self::One(Box::new(settings.into()));
        }
        let table = |population| {
            let Population { seed, count, half_extent, radius, velocity } = population;
            let alone =
                RainSettings { seed, count, half_extent, radius, velocity, ..Default::default() };
            RainTable::from(alone)
        };
        Self::Several(settings.populations().map(table).collect())
    }
}

impl TryFrom<RainTable> for RainSettings {
    type Error = String;

    fn try_from(table: RainTable) -> Result<Self, String> {
        let first = |keys: &[(&'static str, bool)]| {
            keys.iter().find(|(_, is_given)| *is_given).map(|(key, _)| *key)
        };
        let of_box = first(&[
            ("seed", table.seed.is_some()),
            ("count", table.count.is_some()),
            ("half_extent", table.half_extent.is_some()),
            ("radius", table.radius.is_some()),
            ("velocity", table.velocity.is_some()),
        ]);
        let of_rate = first(&[
            ("sizes", table.sizes.is_some()),
            ("diameters", table.diameters.is_some()),
            ("mu", table.mu.is_some()),
            ("median_diameter", table.median_diameter.is_some()),
            ("air_density", table.air_density.is_some()),
            ("wind", table.wind.is_some()),
            ("shape", table.shape.is_some()),
            ("extent", table.extent.is_some()),
        ]);
        let Some(rate) = table.rate else {
            if let Some(key) = of_rate {
                return Err(format!("rain: {key} is for rain by its rate; add rate = 25.0 (mm/h)"));
            }
            let default = Self::default();
            return Ok(Self {
                count: table.count.unwrap_or(default.count),
                half_extent: table.half_extent.unwrap_or(default.half_extent),
                radius: table.radius.unwrap_or(default.radius),
                velocity: table.velocity.unwrap_or(default.velocity),
                seed: table.seed,
                ..default
            });
        };
        if let Some(key) = of_box {
            return Err(format!(
                "rain: rate and {key} do not go together: give rate for real rain, or {key} for equal \
                 drops in a box"
            ));
        }
        let sizes = table.sizes.unwrap_or(Sizes::MarshallPalmer);
        if table.mu.is_some() && sizes != Sizes::Gamma {
            return Err(format!("rain: mu is for sizes = \"gamma\", not for \"{sizes}\""));
        }
        let default = RealRain::default();
        Ok(Self::of(RealRain {
            rate,
            sizes,
            diameters: table.diameters.unwrap_or(default.diameters),
            mu: table.mu.unwrap_or(default.mu),
            median_diameter: table.median_diameter,
            air_density: table.air_density.unwrap_or(default.air_density),
            wind: table.wind.unwrap_or(default.wind),
            shape: table.shape.unwrap_or(default.shape),
            extent: table.extent.unwrap_or(default.extent),
        }))
    }
}

impl From<RainSettings> for RainTable {
    fn from(settings: RainSettings) -> Self {
        match settings.real {
            None => Self {
                seed: settings.seed,
                count: Some(settings.count),
                half_extent: Some(settings.half_extent),
                radius: Some(settings.radius),
                velocity: Some(settings.velocity),
                ..Self::default()
            },
            Some(rain) => Self {
                rate: Some(rain.rate),
                sizes: Some(rain.sizes),
                diameters: Some(rain.diameters),
                mu: (rain.sizes == Sizes::Gamma).then_some(rain.mu),
                median_diameter: rain.median_diameter,
                air_density: Some(rain.air_density),
                wind: Some(rain.wind),
                shape: Some(rain.shape),
                extent: Some(rain.extent),
                ..Self::default()
            },
        }
    }
}
