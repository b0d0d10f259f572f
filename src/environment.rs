//! Radiance from every direction at infinity: a latitude-longitude image, made safe.
//!
//! Seen from inside: the centre column is -z, +x lies a quarter to the right of it, the top row is
//! +y: u = 1/2 + atan2(x, -z) / 2π, v = acos(y) / π.

use std::f64::consts::{PI, TAU};

use glam::{DVec3, Vec3};

use crate::picture::Picture;
use crate::scene::EnvironmentChoice;
use crate::{Error, Result};

/// Radiance from every direction, finite and nowhere negative.
#[derive(Clone, Debug)]
pub struct Environment {
    width: u32,
    height: u32,
    texels: Vec<Vec3>,
}

impl Environment {
    /// The same radiance from everywhere: a white furnace.
    pub fn constant(radiance: Vec3) -> Self {
        Self { width: 4, height: 2, texels: vec![radiance; 8] }
    }

    /// A latitude-longitude image from memory; `name` stands for it in messages.
    pub fn from_texels(name: &str, width: u32, height: u32, texels: Vec<Vec3>) -> Result<Self> {
        let safe = texels.iter().all(|texel| texel.is_finite() && texel.min_element() >= 0.0);
        if texels.is_empty() || texels.len() as u64 != u64::from(width) * u64::from(height) || !safe
        {
            return Err(Error::Environment {
                path: name.into(),
                problem: format!("its texels do not make {width} x {height} finite radiances"),
            });
        }
        Ok(Self { width, height, texels })
    }

    /// The radiance that a scene chooses; grey where it leaves the choice open.
    pub fn open(choice: &EnvironmentChoice) -> Result<Self> {
        match (&choice.file, choice.radiance) {
            (Some(path), _) => {
                let picture = Picture::read(path)?;
                let texels = picture.pixels.iter().map(|p| p.max(Vec3::ZERO)).collect();
                Self::from_texels(&path.to_string_lossy(), picture.width, picture.height, texels)
            }
            (None, radiance) => Ok(Self::constant(radiance.unwrap_or(Vec3::splat(0.18)))),
        }
    }

    /// Texels across.
    pub fn width(&self) -> u32 {
        self.width
    }

    /// Texels down.
    pub fn height(&self) -> u32 {
        self.height
    }

    /// Linear radiance, row by row from the top.
    pub fn texels(&self) -> &[Vec3] {
        &self.texels
    }

    /// Radiance from a unit direction: bilinear between texel centres, around the seam, clamped at
    /// the poles, as a sampler does it.
    pub fn radiance(&self, direction: DVec3) -> DVec3 {
        let u = 0.5 + direction.x.atan2(-direction.z) / TAU;
        let v = direction.y.clamp(-1.0, 1.0).acos() / PI;
        let x = u * f64::from(self.width) - 0.5;
        let y = v * f64::from(self.height) - 0.5;
        let (fx, fy) = (x - x.floor(), y - y.floor());
        let texel = |column: f64, row: f64| {
            let column = (column as i64).rem_euclid(i64::from(self.width)) as usize;
            let row = (row as i64).clamp(0, i64::from(self.height) - 1) as usize;
            self.texels[row * self.width as usize + column].as_dvec3()
        };
        let (x, y) = (x.floor(), y.floor());
        let upper = texel(x, y).lerp(texel(x + 1.0, y), fx);
        let lower = texel(x, y + 1.0).lerp(texel(x + 1.0, y + 1.0), fx);
        upper.lerp(lower, fy)
    }
}
