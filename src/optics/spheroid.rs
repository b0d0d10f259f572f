//! Drops that are no spheres: a spheroid, or two half spheroids about the axis +y.
//!
//! Falling water is flattened by the air, its base more than its top. A spheroid of equal volume has the
//! axis ratio right; two halves of one width, joined where their tangents are vertical, come three to
//! four times nearer to the equilibrium shape (Chuang and Beard 1990), and are still two quadrics. All
//! lengths are in radii of the sphere of equal volume.
//!
//! Scaling space turns a half into a part of the unit sphere, where a ray meets it by a quadratic
//! equation; directions and normals stay those of unscaled space. The angles at entry and exit differ,
//! so the weights of the orders are products along the path, and light inside may be reflected totally.

use glam::DVec3;

use super::Interface;

/// Most times that light is followed to the surface from within to find an exit for what the last order
/// carries ([`Walk::rest`]). Only light that runs along the surface stays so long.
const MOST_BOUNCES: u32 = 1000;

/// A drop's surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Shape {
    /// The unit sphere.
    Sphere,
    /// A spheroid about the centre.
    Spheroid {
        /// Semi-axis across.
        equatorial: f64,
        /// Semi-axis along +y.
        polar: f64,
    },
    /// Two half spheroids.
    Halves {
        /// Semi-axis across, of both.
        equatorial: f64,
        /// Semi-axis upwards of the upper half.
        top: f64,
        /// Semi-axis downwards of the lower half.
        bottom: f64,
        /// Height at which they are joined, over the centre.
        joint: f64,
    },
}

/// A spheroid, one half of which may be the surface.
#[derive(Clone, Copy)]
struct Quadric {
    equatorial: f64,
    polar: f64,
    middle: f64,
}

impl Quadric {
    /// Where the line `point + t direction` crosses it.
    fn cross(&self, point: DVec3, direction: DVec3) -> Option<(f64, f64)> {
        let scale = DVec3::new(self.equatorial, self.polar, self.equatorial).recip();
        let point = (point - DVec3::Y * self.middle) * scale;
        let direction = direction * scale;
        let a = direction.length_squared();
        // The line's parameter at its point nearest the centre: from there on nothing large cancels.
        let nearest = -point.dot(direction) / a;
        let left = 1.0 - (point + nearest * direction).length_squared();
        (left >= 0.0).then(|| {
            let half = (left / a).sqrt();
            (nearest - half, nearest + half)
        })
    }

    /// The point moved onto it along its radius: what rounding left beside it must not add up.
    fn settled(&self, point: DVec3) -> DVec3 {
        let middle = DVec3::Y * self.middle;
        let scale = DVec3::new(self.equatorial, self.polar, self.equatorial);
        ((point - middle) / scale).normalize_or(DVec3::Y) * scale + middle
    }

    fn normal(&self, point: DVec3) -> DVec3 {
        let scale = DVec3::new(self.equatorial, self.polar, self.equatorial);
        ((point - DVec3::Y * self.middle) / (scale * scale)).normalize_or(DVec3::Y)
    }
}

/// Semi-axes of the spheroid of unit volume radius, equatorial and polar, by their ratio.
pub fn semi_axes(axis_ratio: f64) -> (f64, f64) {
    (axis_ratio.powf(-1.0 / 3.0), axis_ratio.powf(2.0 / 3.0))
}

impl Shape {
    /// The spheroid of unit volume radius with this axis ratio, polar over equatorial.
    pub fn of_axis_ratio(ratio: f64) -> Self {
        if ratio == 1.0 {
            return Self::Sphere;
        }
        let (equatorial, polar) = semi_axes(ratio);
        Self::Spheroid { equatorial, polar }
    }

    /// Radius of a sphere about the centre that holds it.
    pub fn reach(&self) -> f64 {
        match *self {
            Self::Sphere => 1.0,
            Self::Spheroid { equatorial, polar } => equatorial.max(polar),
            // Each half lies in the sphere around the joint's middle.
            Self::Halves { equatorial, top, bottom, joint } => {
                equatorial.max(top).max(bottom) + joint.abs()
            }
        }
    }

    /// The upper and the lower quadric, and the height between them.
    fn quadrics(&self) -> (Quadric, Quadric, f64) {
        let (equatorial, top, bottom, middle) = match *self {
            Self::Sphere => (1.0, 1.0, 1.0, 0.0),
            Self::Spheroid { equatorial, polar } => (equatorial, polar, polar, 0.0),
            Self::Halves { equatorial, top, bottom, joint } => (equatorial, top, bottom, joint),
        };
        let half = |polar| Quadric { equatorial, polar, middle };
        (half(top), half(bottom), middle)
    }

    /// The quadric that the surface is a part of at this point.
    fn quadric_at(&self, point: DVec3) -> Quadric {
        let (upper, lower, joint) = self.quadrics();
        if point.y >= joint { upper } else { lower }
    }

    /// Where the line `point + t direction` enters and leaves the drop.
    ///
    /// The body is convex, so a crossing of either quadric on its own side of the joint is the one.
    pub fn cross(&self, point: DVec3, direction: DVec3) -> Option<(f64, f64)> {
        let (upper, lower, joint) = self.quadrics();
        if !matches!(self, Self::Halves { .. }) {
            return upper.cross(point, direction);
        }
        let above = upper.cross(point, direction);
        let below = lower.cross(point, direction);
        let (Some(above), Some(below)) = (above, below) else {
            // Missing one quadric, the line misses its half and may cross the other's twice.
            let (only, is_upper) = match (above, below) {
                (Some(above), None) => (above, true),
                (None, Some(below)) => (below, false),
                _ => return None,
            };
            let is_own = |t: f64| ((point + t * direction).y >= joint) == is_upper;
            return (is_own(only.0) && is_own(only.1)).then_some(only);
        };
        let pick = |above: f64, below: f64| {
            if (point + above * direction).y >= joint { above } else { below }
        };
        Some((pick(above.0, below.0), pick(above.1, below.1)))
    }

    /// Outward unit normal at a point of the surface.
    pub fn normal(&self, point: DVec3) -> DVec3 {
        self.quadric_at(point).normal(point)
    }
}

/// Light that leaves a drop after some internal reflections, followed against its way.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Exit {
    /// Where on the surface, from the drop's centre.
    pub point: DVec3,
    /// Unit direction outside.
    pub direction: DVec3,
    /// Share of the radiance.
    pub weight: f64,
}

/// A ray inside a drop: an iterator over the surface's points that it comes to, `None` where it is
/// reflected totally. It never ends by itself.
#[derive(Clone, Copy, Debug)]
pub struct Walk {
    shape: Shape,
    index: f64,
    point: DVec3,
    direction: DVec3,
    /// Share of the radiance that is still inside.
    left: f64,
}

impl Walk {
    /// A ray of unit `direction` that meets the drop from outside at `point`, seen from its centre:
    /// what it does at the surface, and the way on inside where there is one. `index` is that inside
    /// over that outside.
    pub fn enter(
        shape: Shape,
        point: DVec3,
        direction: DVec3,
        index: f64,
    ) -> (Interface, Option<Self>) {
        let point = shape.quadric_at(point).settled(point);
        let entry = Interface::meet(direction, shape.normal(point), index);
        let inside = entry.refracted.map(|direction| Self {
            shape,
            index,
            point,
            direction,
            left: 1.0 - entry.reflectance,
        });
        (entry, inside)
    }

    /// Share of the radiance that has not left yet.
    pub fn left(&self) -> f64 {
        self.left
    }

    /// Goes on to the surface, and reflects there.
    fn step(&mut self) -> Option<Exit> {
        let (_, far) = self.shape.cross(self.point, self.direction).unwrap_or((0.0, 0.0));
        let point = self.point + far.max(0.0) * self.direction;
        self.point = self.shape.quadric_at(point).settled(point);
        let normal = self.shape.normal(self.point);
        let at = Interface::meet(self.direction, -normal, 1.0 / self.index);
        let exit = at.refracted.map(|direction| Exit {
            point: self.point,
            direction,
            weight: self.left * (1.0 - at.reflectance),
        });
        self.direction = at.reflected.normalize_or(self.direction);
        self.left *= at.reflectance;
        exit
    }

    /// The next exit, with all that is still inside: what becomes of the orders that are not followed
    /// where none is to be lost.
    pub fn rest(mut self) -> Exit {
        let left = self.left;
        for _ in 0..MOST_BOUNCES {
            if let Some(exit) = self.step() {
                return Exit { weight: left, ..exit };
            }
        }
        Exit { point: self.point, direction: self.direction, weight: left }
    }
}

impl Iterator for Walk {
    type Item = Option<Exit>;

    fn next(&mut self) -> Option<Self::Item> {
        Some(self.step())
    }
}
