//! Where a drop that is no sphere shows a source: parts of a square around its outline.
//!
//! Light through a sphere has a closed form in one angle (`glints.rs`), through a flattened drop it has none. So the
//! square is cut into parts, and a part into quarters as long as the rays at its corners leave, by any way, about where
//! the source is, but wider spread than that. This guides samples alone: each part is sampled, also one that
//! seems dark, by its exact area. What the search misses costs noise and no light.

use glam::{DVec2, DVec3};

use super::Truth;
use super::glints::MOST_REFLECTIONS;
use super::light::Way;
use crate::optics::Shape;

/// Ways of light that are told apart: reflected outside, and up to so many times inside.
const WAYS: usize = 2 + MOST_REFLECTIONS as usize;

/// Ways of less weight are not looked for.
const FAINT: f64 = 1e-3;

/// Parts along an edge of the square that the search begins with.
const FIRST: u32 = 24;

/// Times that a part is cut into quarters at most.
const CUTS: u32 = 7;

/// How far beyond the spread of its corners' rays a part's rays may leave.
const MARGIN: f64 = 1.5;

/// Edge of a part at a rim that is small enough: there its corners say little.
const RIM: f64 = 0.02;

/// A cap of directions.
#[derive(Clone, Copy, Debug)]
pub(super) struct Cap {
    pub(super) direction: DVec3,
    /// Angular radius.
    pub(super) radius: f64,
}

/// A square part of the square from -1 to 1.
#[derive(Clone, Copy, Debug)]
pub(super) struct Part {
    corner: DVec2,
    edge: f64,
    /// Whether it seems to show a source.
    pub(super) shows: bool,
}

impl Part {
    /// A place in it, from one in the unit square.
    pub(super) fn at(&self, x: f64, y: f64) -> DVec2 {
        self.corner + self.edge * DVec2::new(x, y)
    }

    pub(super) fn area(&self) -> f64 {
        self.edge * self.edge
    }
}

/// A drop and the rays that look at it.
pub(super) struct Outline<'a, F> {
    pub(super) truth: &'a Truth,
    pub(super) shape: Shape,
    pub(super) index: f64,
    /// A point of the ray through a place of the square, in radii from the drop's centre, and the ray's unit direction.
    pub(super) ray: F,
}

/// Where the light of each way comes from.
type Leaving = [Option<DVec3>; WAYS];

impl<F: Fn(DVec2) -> (DVec3, DVec3)> Outline<'_, F> {
    /// The square's parts. Those that show a source are so small that their rays spread over no more than `finest` of it.
    pub(super) fn parts(&self, sources: &[Cap], finest: f64) -> Vec<Part> {
        let edge = 2.0 / f64::from(FIRST);
        let place = |column: u32, row: u32| {
            edge * DVec2::new(f64::from(column), f64::from(row)) - DVec2::ONE
        };
        let row_of = |row: u32| -> Vec<Leaving> {
            (0..=FIRST).map(|column| self.leaving(place(column, row))).collect()
        };
        let mut parts = Vec::new();
        let mut upper = row_of(0);
        for row in 0..FIRST {
            let lower = row_of(row + 1);
            for (column, at) in (0..FIRST).zip(0_usize..) {
                let part = Part { corner: place(column, row), edge, shows: false };
                let corners = [upper[at], upper[at + 1], lower[at], lower[at + 1]];
                self.cut(part, corners, sources, finest, CUTS, &mut parts);
            }
            upper = lower;
        }
        parts
    }

    fn cut(
        &self,
        part: Part,
        corners: [Leaving; 4],
        sources: &[Cap],
        finest: f64,
        cuts: u32,
        parts: &mut Vec<Part>,
    ) {
        let (shows, is_fine) = seen(&corners, part.edge, sources, finest);
        if !shows || is_fine || cuts == 0 {
            parts.push(Part { shows, ..part });
            return;
        }
        let at = |x: f64, y: f64| self.leaving(part.at(x, y));
        let [upper, left, middle, right, lower] =
            [at(0.5, 0.0), at(0.0, 0.5), at(0.5, 0.5), at(1.0, 0.5), at(0.5, 1.0)];
        let [a, b, c, d] = corners;
        let quarters = [
            ((0.0, 0.0), [a, upper, left, middle]),
            ((0.5, 0.0), [upper, b, middle, right]),
            ((0.0, 0.5), [left, middle, c, lower]),
            ((0.5, 0.5), [middle, right, lower, d]),
        ];
        for ((x, y), corners) in quarters {
            let quarter = Part { corner: part.at(x, y), edge: 0.5 * part.edge, shows };
            self.cut(quarter, corners, sources, finest, cuts - 1, parts);
        }
    }

    fn leaving(&self, place: DVec2) -> Leaving {
        let mut found = [None; WAYS];
        self.follow(place, |way, weight, direction| {
            if weight >= FAINT
                && let Some(of_way) = found.get_mut(way.number() as usize)
            {
                *of_way = Some(direction);
            }
        });
        found
    }

    /// Every way of the ray through a place of the square, with its weight and where its light comes from.
    pub(super) fn follow(&self, place: DVec2, mut arriving: impl FnMut(Way, f64, DVec3)) {
        let (point, direction) = (self.ray)(place);
        let Some((near, _)) = self.shape.cross(point, direction) else { return };
        let point = point + near * direction;
        self.truth.of_shape(
            self.shape,
            point,
            direction,
            self.index,
            |way, weight, direction, _| arriving(way, weight, direction),
        );
    }
}

/// Whether a part with these rays at its corners seems to show a source, and whether it is small enough for that.
fn seen(corners: &[Leaving; 4], edge: f64, sources: &[Cap], finest: f64) -> (bool, bool) {
    let (mut shows, mut is_fine) = (false, true);
    for way in 0..WAYS {
        let directions = || corners.iter().filter_map(|corner| corner[way]);
        let count = directions().count();
        if count == 0 {
            continue;
        }
        let middle = directions().sum::<DVec3>().normalize_or(DVec3::Y);
        let apart =
            directions().map(|direction| direction.angle_between(middle)).fold(0.0, f64::max);
        // Towards a rim, that of the outline or of total reflection, the angle at the surface changes as a square root.
        let is_rim = count < 4;
        let spread = apart + if is_rim { 2.0 * (2.0 * edge).sqrt() } else { 0.0 };
        for source in sources {
            if middle.angle_between(source.direction) <= source.radius + MARGIN * spread {
                shows = true;
                is_fine &= apart <= finest * source.radius && !(is_rim && edge > RIM);
            }
        }
    }
    (shows, is_fine)
}
