//! A bounding-volume tree over spheres: which drop does a ray meet first, and which drops can the
//! rays of a tile meet at all.
//!
//! Boxes are split at the median of their longest axis. The rain is uniform, so a costlier split
//! (surface area heuristic) finds nothing better, and the median bounds the depth.

use glam::DVec3;

use super::drops::Sphere;

/// Most spheres in a leaf. Testing a sphere costs about as much as testing a box.
const LEAF: usize = 4;

/// Fewest spheres that are worth a task of their own while building.
const PARALLEL: usize = 8192;

/// A depth of 2^64 spheres; the median split halves, so this cannot overflow.
const MAX_DEPTH: usize = 64;

/// Rounding that the culling forgives, relative to the distance: a sphere that grazes a plane is
/// kept, and the exact test decides.
const SLACK: f64 = 1e-12;

/// Where along a ray a sphere is met. Orders hits by distance, and equal distances by the sphere's
/// number, so that the answer does not depend on the order of traversal.
#[derive(Clone, Copy, Debug, PartialEq, PartialOrd)]
pub struct Hit {
    /// Distance from the ray's origin, in scene units.
    pub distance: f64,
    /// The sphere's number.
    pub sphere: u32,
}

impl Hit {
    /// Before every hit.
    pub const START: Self = Self { distance: f64::NEG_INFINITY, sphere: 0 };
    /// After every hit: nothing was met.
    pub const NONE: Self = Self { distance: f64::INFINITY, sphere: u32::MAX };
}

/// Where a ray meets a sphere that its origin is outside of; `None` if it misses it, the sphere is
/// behind, or the origin is within.
///
/// The same decision at the rim as [`crate::optics::Encounter::of_ray`]: distance² - along² cancels
/// there, so it only rejects what is surely outside, and the cross product decides the rest.
pub fn meet(sphere: &Sphere, origin: DVec3, direction: DVec3) -> Option<f64> {
    let center = sphere.center - origin;
    let along = center.dot(direction);
    let distance2 = center.length_squared();
    let radius2 = sphere.radius * sphere.radius;
    if along <= 0.0
        || distance2 - along * along > radius2 + SLACK * distance2
        || distance2 <= radius2
    {
        return None;
    }
    let to_ray = direction.cross(center).cross(direction) / -sphere.radius;
    let impact_parameter = to_ray.length();
    (impact_parameter <= 1.0)
        .then(|| along - sphere.radius * (1.0 - impact_parameter * impact_parameter).sqrt())
}

/// A pyramid of rays from the origin, by four planes through it.
#[derive(Clone, Copy, Debug)]
pub struct Pyramid {
    /// Unit normals, pointing inwards.
    normals: [DVec3; 4],
}

impl Pyramid {
    /// The pyramid between four directions, given around its edge in either sense.
    pub fn between(corners: [DVec3; 4]) -> Self {
        let middle: DVec3 = corners.iter().sum();
        let normals = [0, 1, 2, 3].map(|i| {
            let normal = corners[i].cross(corners[(i + 1) % 4]).normalize_or_zero();
            if normal.dot(middle) < 0.0 { -normal } else { normal }
        });
        Self { normals }
    }

    fn misses_box(&self, node: &Node) -> bool {
        self.normals.iter().any(|normal| {
            // The corner that reaches farthest inwards.
            let far = DVec3::select(normal.cmpge(DVec3::ZERO), node.upper, node.lower);
            normal.dot(far) < -SLACK * far.length()
        })
    }

    fn misses_sphere(&self, sphere: &Sphere) -> bool {
        let slack = SLACK * sphere.center.length();
        self.normals.iter().any(|normal| normal.dot(sphere.center) < -sphere.radius - slack)
    }
}

/// A node: a box, and either the range of its spheres or its two children.
#[derive(Clone, Copy, Debug)]
struct Node {
    lower: DVec3,
    upper: DVec3,
    /// Leaf: first of its spheres in `order`. Otherwise: its second child; the first follows it.
    link: u32,
    /// Number of spheres; 0 for an inner node.
    count: u32,
}

/// The tree. Spheres keep their numbers: the place in the list that it was built from.
#[derive(Clone, Debug, Default)]
pub struct Tree {
    spheres: Vec<Sphere>,
    /// The spheres' numbers, leaf by leaf.
    order: Vec<u32>,
    nodes: Vec<Node>,
}

impl Tree {
    /// Builds the tree on all cores; O(n log n).
    pub fn new(spheres: Vec<Sphere>) -> Self {
        let mut order: Vec<u32> = (0..spheres.len() as u32).collect();
        let nodes = if spheres.is_empty() { Vec::new() } else { build(&spheres, &mut order, 0) };
        Self { spheres, order, nodes }
    }

    /// The spheres, by number.
    pub fn spheres(&self) -> &[Sphere] {
        &self.spheres
    }

    /// The first hit of the ray that comes after `after`, leaving out the sphere numbered `except`;
    /// [`Hit::NONE`] if there is none. `direction` must be of unit length.
    pub fn first_hit(
        &self,
        origin: DVec3,
        direction: DVec3,
        after: Hit,
        except: Option<u32>,
    ) -> Hit {
        let mut best = Hit::NONE;
        let inverse = direction.recip();
        let mut stack = [0_u32; MAX_DEPTH];
        let mut depth = usize::from(!self.nodes.is_empty());
        while depth > 0 {
            depth -= 1;
            let at = stack[depth];
            let node = &self.nodes[at as usize];
            match enter(node, origin, inverse) {
                Some(entry) if entry <= best.distance => {}
                _ => continue,
            }
            if node.count > 0 {
                let first = node.link as usize;
                for &number in &self.order[first..first + node.count as usize] {
                    let sphere = &self.spheres[number as usize];
                    if Some(number) != except
                        && let Some(distance) = meet(sphere, origin, direction)
                    {
                        best = earlier(best, Hit { distance, sphere: number }, after);
                    }
                }
            } else {
                // The nearer child last, so that it is taken first.
                let (first, second) = (at + 1, node.link);
                let near = |child: u32| {
                    let child = &self.nodes[child as usize];
                    (0.5 * (child.lower + child.upper) - origin).dot(direction)
                };
                let ordered =
                    if near(first) <= near(second) { [second, first] } else { [first, second] };
                stack[depth..depth + 2].copy_from_slice(&ordered);
                depth += 2;
            }
        }
        best
    }

    /// Numbers of the spheres that rays of the pyramid (from the origin) can meet before `reach`, nearest
    /// first, each with the least distance at which it can be met.
    pub fn within(&self, pyramid: &Pyramid, reach: f64, found: &mut Vec<Hit>) {
        found.clear();
        let reach2 = reach * reach;
        let mut stack = [0_u32; MAX_DEPTH];
        let mut depth = usize::from(!self.nodes.is_empty());
        while depth > 0 {
            depth -= 1;
            let at = stack[depth];
            let node = &self.nodes[at as usize];
            let nearest = DVec3::ZERO.clamp(node.lower, node.upper);
            if nearest.length_squared() > reach2 || pyramid.misses_box(node) {
                continue;
            }
            if node.count > 0 {
                let first = node.link as usize;
                for &number in &self.order[first..first + node.count as usize] {
                    let sphere = &self.spheres[number as usize];
                    if !pyramid.misses_sphere(sphere) {
                        let length = sphere.center.length();
                        // Rounded down, so that it bounds the distance of every hit from below.
                        let distance = length - sphere.radius - SLACK * length;
                        if distance < reach {
                            found.push(Hit { distance, sphere: number });
                        }
                    }
                }
            } else {
                stack[depth..depth + 2].copy_from_slice(&[at + 1, node.link]);
                depth += 2;
            }
        }
        found.sort_unstable_by(|a, b| {
            a.distance.total_cmp(&b.distance).then(a.sphere.cmp(&b.sphere))
        });
    }

    /// As [`Tree::first_hit`] for a ray from the origin, of the candidates that
    /// [`Tree::within`] found for a pyramid that holds the ray.
    pub fn first_hit_of(&self, candidates: &[Hit], direction: DVec3, after: Hit) -> Hit {
        let mut best = Hit::NONE;
        for candidate in candidates {
            if candidate.distance > best.distance {
                break;
            }
            let sphere = &self.spheres[candidate.sphere as usize];
            if let Some(distance) = meet(sphere, DVec3::ZERO, direction) {
                best = earlier(best, Hit { distance, sphere: candidate.sphere }, after);
            }
        }
        best
    }
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

/// Nodes of the tree over `order`, whose first sphere stands at `offset` in the whole order; links
/// of inner nodes count from the front of the returned list.
fn build(spheres: &[Sphere], order: &mut [u32], offset: u32) -> Vec<Node> {
    let (mut lower, mut upper) = (DVec3::INFINITY, DVec3::NEG_INFINITY);
    let (mut least, mut most) = (DVec3::INFINITY, DVec3::NEG_INFINITY);
    for &number in order.iter() {
        let Sphere { center, radius, .. } = spheres[number as usize];
        // A little more than the radius: the sphere's own test rounds, too.
        let reach = DVec3::splat(radius) + SLACK * (center.abs() + radius);
        (lower, upper) = (lower.min(center - reach), upper.max(center + reach));
        (least, most) = (least.min(center), most.max(center));
    }
    let count = order.len();
    if count <= LEAF {
        return vec![Node { lower, upper, link: offset, count: count as u32 }];
    }
    let axis = (most - least).max_position();
    let half = count / 2;
    let key = |number: &u32| spheres[*number as usize].center[axis];
    order.select_nth_unstable_by(half, |a, b| key(a).total_cmp(&key(b)).then(a.cmp(b)));
    let (left, right) = order.split_at_mut(half);
    let right_offset = offset + half as u32;
    let (left, right) = if count >= PARALLEL {
        rayon::join(|| build(spheres, left, offset), || build(spheres, right, right_offset))
    } else {
        (build(spheres, left, offset), build(spheres, right, right_offset))
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
