//! The light that leaves a drop towards a ray, followed back to where it comes from.

use glam::DVec3;

use super::far::SMALL_PX;
use super::glints::{Glints, MOST_REFLECTIONS};
use super::{Around, Drop, Ray, Tracer, Truth, Weights};
use crate::optics::{Exit, Intersection, Shape, Walk};

/// A ray that carries less than this share of its pixel meets no further drops and takes the
/// environment instead. Bounds the fan of rays that [`super::Truth::drops_see_drops`] opens (an error of
/// a thousandth of the difference between the environment and a drop, at most, per such ray).
const FAINT: f64 = 1e-3;

/// A way of light through a drop.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Way {
    /// Reflected on the outside.
    Outside,
    /// Refracted in and out, with so many reflections between.
    Inside(u32),
}

impl Way {
    /// Share of the radiance that arrives this way through a sphere.
    pub(super) fn weight(self, intersection: &Intersection, truth: &Truth) -> f64 {
        match (self, truth.weights) {
            (Self::Outside, _) => intersection.reflectance(),
            (Self::Inside(_), Weights::Paper) => 1.0 - intersection.reflectance(),
            (Self::Inside(k), Weights::Conserving) if k == truth.internal_reflections => {
                let reflectance = intersection.reflectance();
                (1.0 - reflectance) * reflectance.powi(k as i32)
            }
            (Self::Inside(k), _) => intersection.weight_of_internal_reflections(k),
        }
    }
}

impl Tracer<'_> {
    /// Radiance that leaves the drop of this number against a ray that meets it.
    pub(super) fn leaving(
        &self,
        around: &Around,
        ray: &Ray,
        number: u32,
        share: f64,
        depth: u32,
    ) -> DVec3 {
        let drops = around.tree.drops();
        let drop = &drops.all[number as usize];
        let population = drops.population(drop);
        let center = drops.center(drop, ray.moment);
        let glints = self.glints.as_ref();
        let glints = glints.filter(|_| around.glints && self.finds_glints_of(drop));
        let small = around.small.filter(|_| self.radius_px(drop) < SMALL_PX);
        let suns = small.and_then(|small| {
            let light = small.light(population.shape, drop.radius, ray.direction)?;
            Some((small.rest, light))
        });
        let rest = glints.map(Glints::rest).or(suns.map(|(rest, _)| rest));
        let mut sum = suns.map_or(DVec3::ZERO, |(_, light)| light);
        for &(index, colors) in &self.indices {
            let mut of_index = DVec3::ZERO;
            let arriving = |way: Way, weight: f64, direction: DVec3, exit: &dyn Fn() -> DVec3| {
                let share = weight * share;
                of_index += weight
                    * if depth == 0 || share < FAINT {
                        let is_found = !matches!(way, Way::Inside(k) if k > MOST_REFLECTIONS);
                        let rest = rest.filter(|_| is_found || suns.is_some());
                        rest.unwrap_or(self.environment).radiance(direction)
                    } else {
                        let origin = center + drop.radius * exit();
                        let ray = Ray { origin, direction, moment: ray.moment };
                        let next = |after| around.tree.first_hit(&ray, after, Some(number));
                        let reach = f64::INFINITY;
                        let (light, left) =
                            self.gather(around, &ray, share, depth - 1, reach, next);
                        light + left * self.environment.radiance(direction)
                    };
            };
            let seen = center - ray.origin;
            match population.shape {
                Shape::Sphere => {
                    if let Some(met) = Intersection::of_ray(ray.direction, seen, drop.radius) {
                        self.truth.of_sphere(&met.with_index(index), arriving);
                    }
                }
                shape => {
                    let to_ray = ray.direction.cross(seen).cross(ray.direction) / -drop.radius;
                    if let Some((near, _)) = shape.cross(to_ray, ray.direction) {
                        let point = to_ray + near * ray.direction;
                        self.truth.of_shape(shape, point, ray.direction, index, arriving);
                    }
                }
            }
            sum += colors * of_index;
        }
        sum
    }

    /// Radius in pixels of a drop, on the view axis.
    fn radius_px(&self, drop: &Drop) -> f64 {
        self.eye.view.focal_px * drop.radius / drop.center.length()
    }
}

impl Truth {
    /// Every way through a sphere, with its weight, where its light comes from, and where on the unit
    /// sphere that leaves.
    pub(super) fn of_sphere(
        &self,
        intersection: &Intersection,
        mut arriving: impl FnMut(Way, f64, DVec3, &dyn Fn() -> DVec3),
    ) {
        if self.reflection {
            let (way, direction) = (Way::Outside, intersection.reflected());
            arriving(way, way.weight(intersection, self), direction, &|| intersection.normal());
        }
        let last = self.last_order();
        for k in 0..=last {
            let way = Way::Inside(k);
            let direction = intersection.after_internal_reflections(k);
            arriving(way, way.weight(intersection, self), direction, &|| {
                intersection.exit_normal(k)
            });
            // Away from the rim F is a few percent: a dozen orders exhaust float64.
            if intersection.weight_beyond_internal_reflections(k) < f64::EPSILON {
                break;
            }
        }
    }

    /// The light through another shape that is entered at `point`, in radii from its centre.
    pub(super) fn of_shape(
        &self,
        shape: Shape,
        point: DVec3,
        direction: DVec3,
        index: f64,
        mut arriving: impl FnMut(Way, f64, DVec3, &dyn Fn() -> DVec3),
    ) {
        let (entry, inside) = Walk::enter(shape, point, direction, index);
        if self.reflection {
            arriving(Way::Outside, entry.reflectance, entry.reflected, &|| point);
        }
        let Some(mut walk) = inside else { return };
        let last = self.last_order();
        for k in 0..=last {
            let is_rest = k == last && self.weights != Weights::Physical;
            let exit = if is_rest { Some(walk.rest()) } else { walk.next().flatten() };
            if let Some(Exit { point, direction, weight }) = exit {
                arriving(Way::Inside(k), weight, direction, &|| point);
            }
            if walk.left() < f64::EPSILON {
                break;
            }
        }
    }

    /// Most internal reflections.
    fn last_order(&self) -> u32 {
        match self.weights {
            Weights::Paper => 0,
            Weights::Physical | Weights::Conserving => self.internal_reflections,
        }
    }
}
