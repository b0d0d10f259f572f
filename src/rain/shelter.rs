//! Which drops a surface keeps off: the same as `glsl/include/shelter.glsl`, bit for bit.
//!
//! A texel of the height map is a column of its height and without a bottom; beyond the map there is none. A drop is sheltered
//! if its line of fall, followed back, meets a column: also if it is in one itself. All drops of a kind, of a population or a
//! class, fall along parallel lines. A drop that moves while a shutter is open is sheltered from some point of its line on; what
//! is drawn decides by the middle of the exposure.
//!
//! Only products, sums, comparisons and roundings down of float32, each rounded by itself, in the order of the shader. The
//! shader passes over most walks by the largest heights around; a walk that comes to its end has the same answer.

use std::sync::Arc;

use glam::{DVec2, DVec3, Vec3};

use crate::picture::heights::{HeightMap, NOTHING};
use crate::scene::Scene;

/// Units of height a texel of a line that is upright: beyond all heights, and no infinity.
const UPRIGHT: f64 = 1e20;

/// How the drops of a kind fall: texels along x and z by which one is farther back a unit of height, and units of height a texel.
pub type Line = [f32; 4];

/// How drops fall past a height map, as a camera sees them.
#[derive(Clone, Debug)]
pub struct Falls {
    /// The map's first corner, at height 0, from the camera.
    pub origin: Vec3,
    /// Texels a scene unit.
    pub scale: [f32; 2],
    /// The lines of each kind: of each population, or of each class of real rain.
    pub lines: Vec<Line>,
}

impl Falls {
    /// Drops of these velocities, kind by kind, past a map of so many columns and rows from corner to corner.
    pub fn past(
        scene: &Scene,
        corners: [[f64; 2]; 2],
        [columns, rows]: [usize; 2],
        velocities: impl IntoIterator<Item = DVec3>,
    ) -> Self {
        let [from, to] = corners.map(DVec2::from);
        let scale = DVec2::new(columns as f64, rows as f64) / (to - from);
        let origin = DVec3::new(from.x, 0.0, from.y) - scene.drawn_position();
        Self {
            origin: origin.as_vec3(),
            scale: scale.as_vec2().to_array(),
            lines: velocities.into_iter().map(|velocity| line(velocity, scale)).collect(),
        }
    }
}

/// A scene's surfaces as its camera sees them.
#[derive(Clone, Debug)]
pub struct Roofs {
    map: Arc<HeightMap>,
    highest: f32,
    falls: Falls,
}

impl Roofs {
    /// A scene's surfaces over drops that have these velocities, kind by kind; none without a shelter, or before its map is read.
    pub fn of(scene: &Scene, velocities: impl IntoIterator<Item = DVec3>) -> Option<Self> {
        let shelter = scene.shelter.as_ref()?;
        let map = shelter.map()?.clone();
        let corners = [shelter.from, shelter.to];
        let falls = Falls::past(scene, corners, [map.columns, map.rows], velocities);
        Some(Self { highest: map.highest(), falls, map })
    }

    /// A scene's surfaces over its populations of drops in boxes.
    pub fn of_boxes(scene: &Scene) -> Option<Self> {
        Self::of(scene, scene.populations().into_iter().map(|rain| rain.velocity))
    }

    /// Whether they keep off a drop of a kind; `relative`: its place from the camera along the world's axes.
    pub fn shelter(&self, relative: Vec3, kind: usize) -> bool {
        let Falls { origin, scale, lines } = &self.falls;
        let [across_x, across_z, rise_x, rise_z] = lines[kind];
        let (columns, rows) = (self.map.columns, self.map.rows);
        let (wide, deep) = (columns as f32, rows as f32);
        let x = (relative.x - origin.x) * scale[0];
        let z = (relative.z - origin.z) * scale[1];
        let height = relative.y - origin.y;
        let (ahead_x, ahead_z) = (across_x >= 0.0, across_z >= 0.0);
        let end = |ahead: bool, size: f32| if ahead { size } else { 0.0 };
        let comes = [(end(!ahead_x, wide) - x) * rise_x, (end(!ahead_z, deep) - z) * rise_z];
        let goes = [(end(ahead_x, wide) - x) * rise_x, (end(ahead_z, deep) - z) * rise_z];
        let mut up = comes[0].max(comes[1]).max(0.0);
        if up > goes[0].min(goes[1]) {
            return false;
        }
        let first = |at: f32, across: f32, size: f32| {
            (at + up * across).floor().clamp(0.0, size - 1.0) as i64
        };
        let (mut column, mut row) = (first(x, across_x, wide), first(z, across_z, deep));
        let is_on_map = |column: i64, row: i64| {
            (0..columns as i64).contains(&column) && (0..rows as i64).contains(&row)
        };
        while is_on_map(column, row) {
            let here = height + up;
            if here > self.highest {
                return false;
            }
            if here <= self.map.heights[row as usize * columns + column as usize] {
                return true;
            }
            let next_x = ((column + i64::from(ahead_x)) as f32 - x) * rise_x;
            let next_z = ((row + i64::from(ahead_z)) as f32 - z) * rise_z;
            if next_x <= next_z {
                (up, column) = (next_x, if ahead_x { column + 1 } else { column - 1 });
            } else {
                (up, row) = (next_z, if ahead_z { row + 1 } else { row - 1 });
            }
        }
        false
    }
}

/// How drops of a velocity fall, on a map of so many texels a scene unit.
fn line(velocity: DVec3, scale: DVec2) -> Line {
    let across = DVec2::new(velocity.x, velocity.z) / velocity.y * scale;
    let rise = across.to_array().map(|across| match across.abs() * UPRIGHT > 1.0 {
        true => across.recip(),
        false => UPRIGHT,
    });
    // An upright line has no sign, which its rise must not have either.
    let across =
        across.to_array().map(|across| if across.abs() * UPRIGHT > 1.0 { across } else { 0.0 });
    [across[0] as f32, across[1] as f32, rise[0] as f32, rise[1] as f32]
}

/// The levels of a height map after itself: each texel is the largest of four of the level before. The last of a level that
/// has no pair for it is one of five or more.
pub fn levels(map: &HeightMap) -> Vec<HeightMap> {
    let mut all = Vec::new();
    let mut fine = map;
    while fine.columns.max(fine.rows) > 1 {
        let (columns, rows) = ((fine.columns / 2).max(1), (fine.rows / 2).max(1));
        let mut heights = vec![NOTHING; columns * rows];
        for (index, height) in fine.heights.iter().enumerate() {
            let column = (index % fine.columns / 2).min(columns - 1);
            let row = (index / fine.columns / 2).min(rows - 1);
            let largest = &mut heights[row * columns + column];
            *largest = largest.max(*height);
        }
        all.push(HeightMap { columns, rows, heights });
        fine = &all[all.len() - 1];
    }
    all
}
