//! The columns of a particle file, by the names that tools write, and the drops that they make.

use std::collections::HashSet;

use glam::DVec3;

use super::MOST;
use crate::scene::PlacedDrop;
use crate::thousands::thousands;

/// Named columns of numbers. A vector is three of them, whose names end in its axis.
#[derive(Debug, Default)]
pub(super) struct Table {
    columns: Vec<(String, Vec<f64>)>,
}

/// What a vector may be called; nothing: its axes alone.
const POSITION: [&str; 5] = ["", "p", "position", "positions", "pos"];
const VELOCITY: [&str; 4] = ["v", "vel", "velocity", "velocities"];
const RADIUS: [&str; 4] = ["pscale", "radius", "radii", "size"];
const DIAMETER: [&str; 3] = ["width", "widths", "diameter"];
const ID: [&str; 2] = ["id", "ids"];
/// How a name of a component may end.
const AXES: [[&str; 3]; 2] = [["x", "y", "z"], ["0", "1", "2"]];

/// How the components of a vector end; numbers alone are no names.
fn ends_of(name: &str) -> &'static [[&'static str; 3]] {
    if name.is_empty() { &AXES[..1] } else { &AXES[..] }
}

/// A name without what is written differently from tool to tool: `P[0]`, `P.x`, `velocity_x`.
fn plain(name: &str) -> String {
    let letters = name.chars().filter(|letter| letter.is_alphanumeric());
    letters.flat_map(char::to_lowercase).collect()
}

/// Whether a column is of use, so that readers may leave out the others.
pub(super) fn is_used(name: &str) -> bool {
    let name = plain(name);
    let is_of = |names: &[&str]| {
        let of = |base: &&str| {
            ends_of(base).iter().flatten().any(|axis| name == format!("{base}{axis}"))
        };
        names.iter().any(of)
    };
    [&RADIUS[..], &DIAMETER, &ID].concat().contains(&&*name) || is_of(&POSITION) || is_of(&VELOCITY)
}

/// Whether these names have a place.
pub(super) fn has_positions<'a>(names: impl Iterator<Item = &'a str>) -> bool {
    let columns = names.map(|name| (plain(name), Vec::new())).collect();
    Table { columns }.vector(&POSITION).is_ok_and(|found| found.is_some())
}

type Vector<'a> = [&'a [f64]; 3];

impl Table {
    /// Adds a column. All must be as long.
    pub fn add(&mut self, name: &str, values: Vec<f64>) -> Result<(), String> {
        if let Some((first, column)) = self.columns.first()
            && column.len() != values.len()
        {
            let counts = [column.len(), values.len()].map(|count| thousands(count as u64));
            return Err(format!(
                "it has {} values of {first} and {} of {name}: not as many of each",
                counts[0], counts[1]
            ));
        }
        self.columns.push((plain(name), values));
        Ok(())
    }

    pub fn is_empty(&self) -> bool {
        self.columns.is_empty()
    }

    fn scalar(&self, names: &[&str]) -> Option<&[f64]> {
        let column = |name: &&str| self.columns.iter().find(|(column, _)| column == name);
        names.iter().find_map(column).map(|(_, values)| &values[..])
    }

    fn vector(&self, names: &[&str]) -> Result<Option<Vector<'_>>, String> {
        for name in names {
            for axes in ends_of(name) {
                let of = axes.map(|axis| self.scalar(&[&*format!("{name}{axis}")]));
                match of {
                    [Some(x), Some(y), Some(z)] => return Ok(Some([x, y, z])),
                    [None, None, None] => {}
                    // A column of its own may happen to be called so.
                    _ if name.is_empty() => {}
                    _ => {
                        return Err(format!(
                            "it has a part of {name} alone: {} are three",
                            axes.map(|axis| format!("{name}{axis}")).join(", ")
                        ));
                    }
                }
            }
        }
        Ok(None)
    }

    pub fn has_velocities(&self) -> bool {
        self.vector(&VELOCITY).is_ok_and(|found| found.is_some())
    }

    /// The drops, with lengths times `scale`; `radius` of those that have none.
    pub fn drops(&self, scale: f64, radius: Option<f64>) -> Result<Vec<PlacedDrop>, String> {
        let Some([x, y, z]) = self.vector(&POSITION)? else {
            let names: Vec<&str> = self.columns.iter().map(|(name, _)| &**name).collect();
            let named = if names.is_empty() { "nothing".into() } else { names.join(", ") };
            return Err(format!(
                "it has no positions (x y z, P, position) among its columns: {named}"
            ));
        };
        if x.len() as u64 > MOST {
            return Err(format!(
                "it has {} particles, over {}",
                thousands(x.len() as u64),
                thousands(MOST)
            ));
        }
        let velocity = self.vector(&VELOCITY)?;
        let (radii, diameters) = (self.scalar(&RADIUS), self.scalar(&DIAMETER));
        if radii.or(diameters).is_none() && radius.is_none() {
            return Err(
                "it has no radii (pscale, radius, size, width): give particles.radius".into()
            );
        }
        let ids = self.ids()?;
        let problem = |row: usize, what: String| Err(format!("particle {}: {what}", row + 1));
        let mut drops = Vec::with_capacity(x.len());
        for row in 0..x.len() {
            let at = |[x, y, z]: Vector<'_>| scale * DVec3::new(x[row], y[row], z[row]);
            let radius = match (radii, diameters, radius) {
                (Some(radii), ..) => scale * radii[row],
                (None, Some(diameters), _) => 0.5 * scale * diameters[row],
                (None, None, radius) => radius.unwrap_or(1.0),
            };
            let drop = PlacedDrop {
                center: at([x, y, z]),
                radius,
                velocity: velocity.map_or(DVec3::ZERO, at),
                id: ids.as_ref().map(|ids| ids[row]),
                ..PlacedDrop::default()
            };
            if !drop.center.is_finite() {
                return problem(row, format!("its position is {}", drop.center));
            }
            if !drop.velocity.is_finite() {
                return problem(row, format!("its velocity is {}", drop.velocity));
            }
            if !radius.is_finite() || radius <= 0.0 {
                return problem(row, format!("its radius is {radius}, not finite and over 0"));
            }
            drops.push(drop);
        }
        Ok(drops)
    }

    /// Ids as they are drawn. One is no number of a drop: 0 becomes the largest number there is.
    fn ids(&self) -> Result<Option<Vec<u32>>, String> {
        let Some(ids) = self.scalar(&ID) else { return Ok(None) };
        let mut seen = HashSet::with_capacity(ids.len());
        let mut found = Vec::with_capacity(ids.len());
        for (row, id) in ids.iter().enumerate() {
            let number = *id as u32;
            if f64::from(number) != *id || number == u32::MAX {
                return Err(format!(
                    "particle {}: id {id} is no whole number from 0 to {}",
                    row + 1,
                    u32::MAX - 1
                ));
            }
            if !seen.insert(number) {
                return Err(format!("particle {}: another one has its id, {id}", row + 1));
            }
            found.push(if number == 0 { u32::MAX } else { number });
        }
        Ok(Some(found))
    }
}
