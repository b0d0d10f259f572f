//! A bounding-volume tree over drops: which one does a ray meet first, and which ones can the rays of a
//! tile meet at all.
//!
//! A drop that moves while the shutter is open is bounded by the way that it sweeps. Boxes are split at
//! the median of their longest axis. The rain is uniform, so a costlier split
//! (surface area heuristic) finds nothing better, and the median bounds the depth.

use glam::DVec3;

use super::drops::{Drop, Drops};
use super::eye::{Eye, Ray};
use crate::optics::Shape;

/// Most drops in a leaf. Testing a drop costs about as much as testing a box.
const LEAF: usize = 4;

/// Fewest drops that are worth a task of their own while building.
const PARALLEL: usize = 8192;

/// A depth of 2^64 drops; the median split halves, so this cannot overflow.
const MAX_DEPTH: usize = 64;

/// Rounding that the culling forgives, relative to the distance: a drop that grazes a plane is
/// kept, and the exact test decides.
const SLACK: f64 = 1e-12;

/// Where along a ray a drop is met. Orders hits by distance, and equal distances by the drop's
/// number, so that the answer does not depend on the order of traversal.
#[derive(Clone, Copy, Debug, PartialEq, PartialOrd)]
pub struct Hit {
    /// Distance from the ray's origin, in scene units.
    pub distance: f64,
    /// The drop's number.
    pub drop: u32,
}

impl Hit {
    /// Before every hit.
    pub const START: Self = Self { distance: f64::NEG_INFINITY, drop: 0 };
    /// After every hit: nothing was met.
    pub const NONE: Self = Self { distance: f64::INFINITY, drop: u32::MAX };

    /// The later of a hit and of all that are nearer than `distance`.
    pub(super) fn after(self, distance: f64) -> Self {
        if distance > self.distance { Self { distance, drop: 0 } } else { self }
    }
}

/// The rays of a rectangle of the picture: a pyramid from the origin by four planes through it, wider by
/// what the lens blurs.
#[derive(Clone, Copy, Debug)]
pub struct Pyramid {
    /// Unit normals, pointing inwards.
    normals: [DVec3; 4],
    /// Radius of the lens.
    lens: f64,
    focus: f64,
    forward: DVec3,
    /// How far a pane of glass shifts rays aside.
    shift: f64,
}

impl Pyramid {
    /// The pyramid between four directions, given around its edge in either sense.
    pub fn between(corners: [DVec3; 4]) -> Self {
        let middle: DVec3 = corners.iter().sum();
        let normals = [0, 1, 2, 3].map(|i| {
            let normal = corners[i].cross(corners[(i + 1) % 4]).normalize_or_zero();
            if normal.dot(middle) < 0.0 { -normal } else { normal }
        });
        Self { normals, lens: 0.0, focus: f64::INFINITY, forward: DVec3::ZERO, shift: 0.0 }
    }

    /// The rays from all of the eye's lens that meet those of the pyramid in the plane of focus.
    pub fn through(self, eye: &Eye) -> Self {
        Self { lens: eye.lens, focus: eye.focus, forward: -eye.view.back, ..self }
    }

    /// These rays, each shifted aside by up to so much.
    pub(super) fn shifted(self, shift: f64) -> Self {
        Self { shift, ..self }
    }

    /// How far from the origin a ray may begin.
    pub(super) fn origins(&self) -> f64 {
        self.lens + self.shift
    }

    /// How far a ray may be outside of a plane between two depths: the lens seen through the plane of
    /// focus. (A ray from o on the lens is at o (1-u) + p u where its depth is u times the focus, with p
    /// in the pyramid.)
    fn blur(&self, depths: [f64; 2]) -> f64 {
        if self.lens == 0.0 {
            return self.shift;
        }
        let [a, b] = depths.map(|depth| (1.0 - depth / self.focus).abs());
        self.lens * a.max(b) + self.shift
    }

    /// Whether it misses all between two corners.
    pub(super) fn misses_box(&self, lower: DVec3, upper: DVec3) -> bool {
        let (middle, half) = (0.5 * (lower + upper), 0.5 * (upper - lower));
        let (depth, reach) = (middle.dot(self.forward), half.dot(self.forward.abs()));
        let blur = self.blur([depth - reach, depth + reach]);
        self.normals.iter().any(|normal| {
            // The corner that reaches farthest inwards.
            let far = DVec3::select(normal.cmpge(DVec3::ZERO), upper, lower);
            normal.dot(far) < -SLACK * far.length() - blur
        })
    }

    /// Whether it misses a sphere of this `reach` on its whole way between two centres.
    pub(super) fn misses_sphere(&self, ends: [DVec3; 2], reach: f64) -> bool {
        let slack = SLACK * ends[0].length().max(ends[1].length());
        let depths = ends.map(|center| center.dot(self.forward));
        let (nearest, farthest) = (depths[0].min(depths[1]), depths[0].max(depths[1]));
        let blur = self.blur([nearest - reach, farthest + reach]);
        self.normals
            .iter()
            .any(|normal| normal.dot(ends[0]).max(normal.dot(ends[1])) < -reach - slack - blur)
    }
}

/// A node: a box, and either the range of its drops or its two children.
#[derive(Clone, Copy, Debug)]
struct Node {
    lower: DVec3,
    upper: DVec3,
    /// Leaf: first of its drops in `order`. Otherwise: its second child; the first follows it.
    link: u32,
    /// Number of drops; 0 for an inner node.
    count: u32,
}

/// The tree. Drops keep their numbers: the place in the list that it was built from.
#[derive(Clone, Debug, Default)]
pub struct Tree {
    drops: Drops,
    /// The drops' numbers, leaf by leaf.
    order: Vec<u32>,
    nodes: Vec<Node>,
}

impl Tree {
    /// Builds the tree on all cores; O(n log n).
    pub fn new(drops: Drops) -> Self {
        let mut order: Vec<u32> = (0..drops.all.len() as u32).collect();
        let nodes = if order.is_empty() { Vec::new() } else { build(&drops, &mut order, 0) };
        Self { drops, order, nodes }
    }

    /// The drops, by number, and what they share.
    pub fn drops(&self) -> &Drops {
        &self.drops
    }

    /// Where a ray meets the drop of this number from outside; `None` if it misses it, the drop is behind,
    /// or the ray begins within.
    ///
    /// The rule at a sphere's rim is that of [`crate::optics::Intersection::of_ray`]: distance² - along² cancels there, so it only
    /// rejects what is surely outside, and the cross product decides the rest.
    pub fn meet(&self, number: u32, ray: &Ray) -> Option<f64> {
        if !self.drops.is_there(number, ray.moment) {
            return None;
        }
        let drop = &self.drops.all[number as usize];
        let population = self.drops.population(drop);
        let center = drop.center + ray.moment * population.motion;
        if let Some(half_extent) = population.half_extent
            && (center.cmplt(-half_extent).any() || center.cmpge(half_extent).any())
        {
            return None;
        }
        let (center, direction) = (center - ray.origin, ray.direction);
        let along = center.dot(direction);
        let distance2 = center.length_squared();
        let reach = drop.radius * population.shape.reach();
        if distance2 - along * along > reach * reach + SLACK * distance2 {
            return None;
        }
        let to_ray = direction.cross(center).cross(direction) / -drop.radius;
        if population.shape == Shape::Sphere {
            let impact_parameter = to_ray.length();
            let is_met = along > 0.0 && distance2 > reach * reach && impact_parameter <= 1.0;
            return is_met
                .then(|| along - drop.radius * (1.0 - impact_parameter * impact_parameter).sqrt());
        }
        let (near, _) = population.shape.cross(to_ray, direction)?;
        let distance = along + drop.radius * near;
        (distance > 0.0).then_some(distance)
    }

    /// The first hit of the ray that comes after `after`, leaving out the drop numbered `except`;
    /// [`Hit::NONE`] if there is none.
    pub fn first_hit(&self, ray: &Ray, after: Hit, except: Option<u32>) -> Hit {
        let mut best = Hit::NONE;
        let inverse = ray.direction.recip();
        let mut stack = [0_u32; MAX_DEPTH];
        let mut depth = usize::from(!self.nodes.is_empty());
        while depth > 0 {
            depth -= 1;
            let at = stack[depth];
            let node = &self.nodes[at as usize];
            match enter(node, ray.origin, inverse) {
                Some(entry) if entry <= best.distance => {}
                _ => continue,
            }
            if node.count > 0 {
                let first = node.link as usize;
                for &number in &self.order[first..first + node.count as usize] {
                    if Some(number) != except
                        && let Some(distance) = self.meet(number, ray)
                    {
                        best = earlier(best, Hit { distance, drop: number }, after);
                    }
                }
            } else {
                // The nearer child last, so that it is taken first.
                let (first, second) = (at + 1, node.link);
                let near = |child: u32| {
                    let child = &self.nodes[child as usize];
                    (0.5 * (child.lower + child.upper) - ray.origin).dot(ray.direction)
                };
                let ordered =
                    if near(first) <= near(second) { [second, first] } else { [first, second] };
                stack[depth..depth + 2].copy_from_slice(&ordered);
                depth += 2;
            }
        }
        best
    }

    /// Numbers of the drops that rays of the pyramid can meet before `reach` at any moment, nearest first,
    /// each with a bound of the least distance at which it can be met.
    pub fn within(&self, pyramid: &Pyramid, reach: f64, found: &mut Vec<Hit>) {
        found.clear();
        // A ray may begin anywhere on the lens.
        let reach2 = (reach + pyramid.origins()).powi(2);
        let mut stack = [0_u32; MAX_DEPTH];
        let mut depth = usize::from(!self.nodes.is_empty());
        while depth > 0 {
            depth -= 1;
            let at = stack[depth];
            let node = &self.nodes[at as usize];
            let nearest = DVec3::ZERO.clamp(node.lower, node.upper);
            if nearest.length_squared() > reach2 || pyramid.misses_box(node.lower, node.upper) {
                continue;
            }
            if node.count > 0 {
                let first = node.link as usize;
                for &number in &self.order[first..first + node.count as usize] {
                    let drop = &self.drops.all[number as usize];
                    let population = self.drops.population(drop);
                    let ends = [drop.center, drop.center + population.motion];
                    let radius = drop.radius * population.shape.reach();
                    if !pyramid.misses_sphere(ends, radius) {
                        let length = nearest_between(ends);
                        // Rounded down, so that it bounds the distance of every hit from below.
                        let distance = length - radius - SLACK * length - pyramid.origins();
                        if distance < reach {
                            found.push(Hit { distance, drop: number });
                        }
                    }
                }
            } else {
                stack[depth..depth + 2].copy_from_slice(&[at + 1, node.link]);
                depth += 2;
            }
        }
        found.sort_unstable_by(|a, b| a.distance.total_cmp(&b.distance).then(a.drop.cmp(&b.drop)));
    }

    /// Like [`Tree::first_hit`] for a ray of the camera, of the candidates that [`Tree::within`] found for a
    /// pyramid that holds the ray.
    pub fn first_hit_of(&self, candidates: &[Hit], ray: &Ray, after: Hit) -> Hit {
        let mut best = Hit::NONE;
        for candidate in candidates {
            if candidate.distance > best.distance {
                break;
            }
            if let Some(distance) = self.meet(candidate.drop, ray) {
                best = earlier(best, Hit { distance, drop: candidate.drop }, after);
            }
        }
        best
    }
}

/// Least distance from the origin to the way between two points.
pub(super) fn nearest_between([from, to]: [DVec3; 2]) -> f64 {
    let way = to - from;
    if way == DVec3::ZERO {
        return from.length();
    }
    let share = (-from.dot(way) / way.length_squared()).clamp(0.0, 1.0);
    (from + share * way).length()
}

/// The earlier of two hits, of those that come after `after`.
pub fn earlier(best: Hit, hit: Hit, after: Hit) -> Hit {
    if hit > after && hit < best { hit } else { best }
}

/// Distance at which a ray enters a node's box (0 from within); `None` if it misses it. A zero
/// component of the direction makes ±∞, or NaN on a face, which `min` and `max` pass over.
fn enter(node: &Node, origin: DVec3, inverse: DVec3) -> Option<f64> {
    let (a, b) = ((node.lower - origin) * inverse, (node.upper - origin) * inverse);
    let (mut near, mut far) = (0.0_f64, f64::INFINITY);
    for axis in 0..3 {
        near = near.max(a[axis].min(b[axis]));
        far = far.min(a[axis].max(b[axis]));
    }
    // A ray that grazes the box may round to either side of it; the slack takes it in.
    (near <= far * (1.0 + 4.0 * f64::EPSILON)).then_some(near * (1.0 - 4.0 * f64::EPSILON))
}

/// Nodes of the tree over `order`, whose first drop stands at `offset` in the whole order; links
/// of inner nodes count from the front of the returned list.
fn build(drops: &Drops, order: &mut [u32], offset: u32) -> Vec<Node> {
    let (mut lower, mut upper) = (DVec3::INFINITY, DVec3::NEG_INFINITY);
    let (mut least, mut most) = (DVec3::INFINITY, DVec3::NEG_INFINITY);
    for &number in order.iter() {
        let (from, to) = swept(drops, number);
        (lower, upper) = (lower.min(from), upper.max(to));
        let center = 0.5 * (from + to);
        (least, most) = (least.min(center), most.max(center));
    }
    let count = order.len();
    if count <= LEAF {
        return vec![Node { lower, upper, link: offset, count: count as u32 }];
    }
    let axis = (most - least).max_position();
    let half = count / 2;
    let key = |number: &u32| {
        let (from, to) = swept(drops, *number);
        from[axis] + to[axis]
    };
    order.select_nth_unstable_by(half, |a, b| key(a).total_cmp(&key(b)).then(a.cmp(b)));
    let (left, right) = order.split_at_mut(half);
    let right_offset = offset + half as u32;
    let (left, right) = if count >= PARALLEL {
        rayon::join(|| build(drops, left, offset), || build(drops, right, right_offset))
    } else {
        (build(drops, left, offset), build(drops, right, right_offset))
    };
    let mut nodes = Vec::with_capacity(1 + left.len() + right.len());
    nodes.push(Node { lower, upper, link: 1 + left.len() as u32, count: 0 });
    let moved = |by: u32| {
        move |node: Node| Node { link: node.link + if node.count > 0 { 0 } else { by }, ..node }
    };
    nodes.extend(left.iter().copied().map(moved(1)));
    let by = nodes.len() as u32;
    nodes.extend(right.iter().copied().map(moved(by)));
    nodes
}

/// The box that a drop sweeps while the shutter is open.
fn swept(drops: &Drops, number: u32) -> (DVec3, DVec3) {
    let drop: &Drop = &drops.all[number as usize];
    let population = drops.population(drop);
    let (from, to) = (drop.center, drop.center + population.motion);
    let (mut lower, mut upper) = (from.min(to), from.max(to));
    if let Some(half_extent) = population.half_extent {
        (lower, upper) = (lower.max(-half_extent), upper.min(half_extent));
    }
    // A little more than the radius: the drop's own test rounds, too.
    let radius = drop.radius * population.shape.reach();
    let reach = DVec3::splat(radius) + SLACK * (from.abs().max(to.abs()) + radius);
    (lower - reach, upper + reach)
}
