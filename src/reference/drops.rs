//! The drops of a scene as the ray tracer takes them: float64 bodies around the camera, that move while
//! the shutter is open.

use glam::DVec3;
use rayon::prelude::*;

use super::shelter::Roof;

use crate::optics::Shape;
use crate::rain::shape::Halves;
use crate::rain::tick_of_seconds;
use crate::scene::model::DropShape;
use crate::scene::{PlacedDrop, Scene};

/// One drop, seen from the camera.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Drop {
    /// Centre relative to the camera as the shutter opens, in scene units along the world's axes.
    pub center: DVec3,
    /// Radius of the sphere of equal volume, in scene units.
    pub radius: f64,
    /// Number of its population.
    pub population: u32,
}

/// What many drops share.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Population {
    /// The surface, in radii.
    pub shape: Shape,
    /// The way of a centre while the shutter is open, as the camera sees it, in scene units.
    pub motion: DVec3,
    /// Half the edges of a box around the camera beyond which a drop is not seen: it is its image at
    /// the opposite wall that is.
    pub half_extent: Option<DVec3>,
}

/// Drops and what they share.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Drops {
    /// Every drop; one that crosses a wall of its box stands here once for each image.
    pub all: Vec<Drop>,
    /// Their populations.
    pub populations: Vec<Population>,
    /// The shares of the exposure from and until which each drop is there that a surface may keep off. Drops beyond the list's
    /// end are there always.
    pub there: Vec<[f64; 2]>,
}

impl Drops {
    /// The population of a drop.
    pub fn population(&self, drop: &Drop) -> &Population {
        &self.populations[drop.population as usize]
    }

    /// Whether the drop of a number is there when a share `moment` of the exposure has gone by, and not kept off by a surface.
    pub fn is_there(&self, number: u32, moment: f64) -> bool {
        let range = self.there.get(number as usize);
        range.is_none_or(|[from, until]| *from <= moment && moment < *until)
    }

    /// Leaves out those drops from the `first` on, of a velocity, that a roof keeps off all the while.
    fn shelter(&mut self, first: usize, roof: &Roof, velocity: DVec3) {
        let found: Vec<_> = self.all[first..]
            .par_iter()
            .filter_map(|drop| Some((*drop, roof.there(drop.center, velocity)?)))
            .collect();
        self.all.truncate(first);
        self.all.extend(found.iter().map(|(drop, _)| *drop));
        self.there.extend(found.iter().map(|(_, there)| *there));
    }

    /// Centre of a drop when a share `moment` of the exposure has gone by.
    pub fn center(&self, drop: &Drop, moment: f64) -> DVec3 {
        drop.center + moment * self.population(drop).motion
    }
}

/// Every drop of the scene but those of real rain, random ones first, in the order of their indices.
///
/// Positions at the scene's time are those of [`crate::rain::Rain::relative`], float32 as the GPU has them,
/// so that a difference between the two pictures is never one of place. Of a random drop only the image
/// nearest the camera exists, as on the GPU: a drop that reaches through a wall of the box does not
/// reappear at the opposite one, and one whose centre crosses it while the shutter is open does.
///
/// A drop at rest whose centre is nearer than `camera.near` is left out here.
pub fn of_scene(scene: &Scene) -> Drops {
    let camera = &scene.camera;
    let mut drops = Drops::default();
    let roof = Roof::of(scene);
    let is_drawn = |center: DVec3, motion: DVec3| {
        motion != DVec3::ZERO || fade(center.length(), camera.near, camera.near_fade) > 0.0
    };
    for rain in scene.populations() {
        let motion = scene.motion_of(rain.velocity);
        let half_extent = (motion != DVec3::ZERO).then_some(rain.half_extent);
        let population = drops.populations.len() as u32;
        drops.populations.push(Population { shape: Shape::Sphere, motion, half_extent });
        let seen = rain.seen_from(camera.position, tick_of_seconds(scene.time));
        let all = (0..rain.count)
            .into_par_iter()
            .map(|index| seen.drop_at(index).as_dvec3())
            .filter(|center| is_drawn(*center, motion))
            .flat_map_iter(|center| images(center, motion, half_extent))
            .map(|center| Drop { center, radius: rain.radius, population });
        let first = drops.all.len();
        drops.all.par_extend(all);
        if let Some(roof) = &roof {
            drops.shelter(first, roof, rain.velocity);
        }
    }
    for placed in scene.placed() {
        let motion = scene.motion_of(placed.velocity);
        let center = placed.center_at(scene.time) - camera.position;
        let shape = shape_of(placed, scene);
        let population = Population { shape, motion, half_extent: None };
        if drops.populations.last() != Some(&population) {
            drops.populations.push(population);
        }
        if is_drawn(center, motion) {
            let population = drops.populations.len() as u32 - 1;
            drops.all.push(Drop { center, radius: placed.radius, population });
        }
    }
    drops
}

impl From<Halves> for Shape {
    fn from(Halves { joint, equatorial, top, bottom }: Halves) -> Self {
        match top == bottom && top == equatorial {
            true => Self::Sphere,
            false => Self::Halves { equatorial, top, bottom, joint },
        }
    }
}

/// The surface of a drop placed by hand.
fn shape_of(placed: &PlacedDrop, scene: &Scene) -> Shape {
    match placed.shape {
        Some(DropShape::Equilibrium) => {
            Halves::of_diameter(2.0 * placed.radius * scene.metres * 1000.0).into()
        }
        Some(DropShape::Sphere) => Shape::Sphere,
        None => Shape::of_axis_ratio(placed.axis_ratio.unwrap_or(1.0)),
    }
}

/// Centres, as the shutter opens, of the images by which a drop is seen one after the other: wherever it
/// leaves the box, another comes in at the opposite wall.
fn images(center: DVec3, motion: DVec3, half_extent: Option<DVec3>) -> Vec<DVec3> {
    let mut images = vec![center];
    let Some(half_extent) = half_extent else { return images };
    let mut image = center;
    loop {
        // When the current image meets its next wall, as a share of the exposure.
        let walls = half_extent * motion.signum();
        let meets = (walls - image) / motion;
        let next = (0..3)
            .filter(|&axis| motion[axis] != 0.0)
            .min_by(|&a, &b| meets[a].total_cmp(&meets[b]));
        match next {
            Some(axis) if meets[axis] < 1.0 => image[axis] -= 2.0 * walls[axis],
            _ => return images,
        }
        images.push(image);
    }
}

/// Opacity of a drop whose centre is `distance` away: 0 nearer than `near`, 1 from `near + width`
/// on, a smoothstep between (the paper's section 5 asks for a fade and leaves its form open).
pub fn fade(distance: f64, near: f64, width: f64) -> f64 {
    if distance < near {
        return 0.0;
    }
    if distance >= near + width {
        return 1.0;
    }
    let x = (distance - near) / width;
    x * x * (3.0 - 2.0 * x)
}
