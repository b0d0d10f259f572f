//! Real rain as one picture sees it: where the camera is among each class's cells, and which cells may hold a
//! drop that the picture shows by itself. The GPU looks into each of them; nothing is kept from frame to frame.
//!
//! A drop is shown by itself if its radius is at least the cut-off in pixels, so each class is seen to a depth
//! of its own. Its cells are listed in layers: [`Slab`].

use glam::{DVec3, Vec3};

use crate::abi::{self, CELLS_GROUP, MAX_BANDS};
pub use crate::abi::{RainClass as ClassRecord, Slab};
use crate::rain::cells::{CellDrop, DIAMETER_UNIT, Lattice, Place};
use crate::rain::cull::{Sight, Visibility};
use crate::rain::flat_sizes::Parted;
use crate::rain::grain::{Grain, Grained, Variances};
use crate::rain::last::Last;
use crate::rain::law::Law;
use crate::rain::medium::{MediumRecord, Outlines};
use crate::rain::pyramid::Pyramid;
use crate::rain::shape::Halves;
use crate::rain::shelter::Roofs;
use crate::rain::thinned::{self, Reach};
use crate::rain::visibility::{Frustum, depth_of_radius};
use crate::rain::{pcg4d, tick_of_seconds};
use crate::scene::Scene;
use crate::scene::model::FarRain;
use crate::scene::projection::View;
use crate::scene::real_rain::RealRain;

/// Most slabs of a picture.
pub const MOST_SLABS: usize = abi::MOST_SLABS as usize;
/// Most groups: a cell's number among all and a drop's in it are 31 bits together.
pub const MOST_GROUPS: usize = (1 << 25) / CELLS_GROUP as usize;
/// Factor by which a cut-off rises until its cells can be numbered, and where it begins to if every drop was to be
/// shown.
const RAISED: f64 = 1.25;
const LEAST_RAISED_PX: f64 = 0.001;
/// What tells the chance of being drawn from other random numbers.
const THINNED: u32 = 0x7468_696e; // "thin"

/// Distance of the image plane in pixels, least radius in pixels of a drop that is shown by itself, that under which drops are
/// thinned, metres in a scene unit; whether drops are flattened.
type Scales = ([f64; 4], bool);

/// The rain of a scene, whatever camera and time.
#[derive(Clone, Debug)]
pub struct Field {
    lattices: Vec<Lattice>,
    law: Law,
    rain: RealRain,
    /// Outlines of the law's drops, where they are drawn flattened.
    outlines: Option<Outlines>,
    /// Median-volume diameter and its lattice's number, where the medium has the noise of single drops.
    grain: Option<(f64, usize)>,
    /// How many lattices are the rain's own. The others are of the rain beyond ([`crate::rain::thinned`]).
    own: usize,
    /// Radius in pixels under which drops are thinned; 0: none are.
    thinned_px: f64,
    // A millisecond of integrals, the same until the camera zooms or its shutter changes.
    bands: Last<Scales, [f32; MAX_BANDS as usize]>,
    medium: Last<Scales, MediumRecord>,
    variances: Last<[f64; 4], Variances>,
}

/// The rain of one picture.
#[derive(Clone, Debug)]
pub struct Seen {
    /// A class each, those that have drops.
    pub classes: Vec<ClassRecord>,
    /// Layers of cells.
    pub slabs: Vec<Slab>,
    /// Least radius of a drop that is shown by itself, in pixels, at its depth on the view axis; 0: all are.
    pub cutoff_px: f32,
    /// Radius under which drops are thinned, and which all of them are drawn with; not under the cut-off.
    pub thinned_px: f32,
    /// Radius of a drop for each unit of its diameter, in scene units.
    pub radius_unit: f32,
    /// Diameter in millimetres of a drop with a radius of one scene unit.
    pub millimetres: f32,
    /// Squared distance to the rain's end, in scene units.
    pub extent2: f32,
    /// Depths that part the drops into bands of equal number, nearest first, in scene units.
    pub band_depths: [f32; MAX_BANDS as usize],
    /// Far rain as a medium; none where it is left out, or all drops are shown.
    pub medium: Option<MediumRecord>,
    /// Its noise.
    pub grain: Option<Grained>,
    /// Drops of the cells that are looked into, on average.
    pub drops_in_cells: f64,
    /// Number of these cells that hold a drop, on average.
    pub cells_with_drops: f64,
    /// How many classes are the rain's own.
    pub own: u32,
    // For the CPU's own look at the drops.
    places: Vec<Place>,
}

impl Seen {
    /// Groups of cells.
    pub fn groups(&self) -> u32 {
        self.slabs.last().map_or(0, |slab| slab.first_group + slab.cells.div_ceil(CELLS_GROUP))
    }

    /// For each group the number of its slab.
    pub fn group_slabs(&self) -> Vec<u32> {
        let of_slab = |(number, slab): (u32, &Slab)| {
            std::iter::repeat_n(number, slab.cells.div_ceil(CELLS_GROUP) as usize)
        };
        (0..).zip(&self.slabs).flat_map(of_slab).collect()
    }
}

impl Field {
    /// The real rain of `scene`; none if it has none.
    pub fn of(scene: &Scene) -> Option<Self> {
        let rain = scene.real_rain()?;
        let lattices = rain.lattices(scene.seed);
        let own = lattices.len();
        Some(Self {
            lattices,
            law: rain.law(),
            rain,
            outlines: None,
            grain: None,
            own,
            thinned_px: 0.0,
            bands: Last::default(),
            medium: Last::default(),
            variances: Last::default(),
        })
    }

    /// This rain with its drops under a radius in pixels thinned. No drop is drawn under [`thinned::LEAST`] of it. 0: as it is.
    pub fn thinned(mut self, scene: &Scene, px: f64) -> Self {
        self.lattices.truncate(self.own);
        if px > 0.0 {
            self.lattices.extend(self.rain.lattices_beyond(scene.seed));
        }
        Self { thinned_px: px, ..self }
    }

    /// This rain with its drops drawn flattened, or not. Flattened ones are wider than their spheres, so that cells farther out of
    /// view may show some. (The drops counted as in view are the spheres, all the same.)
    pub fn flattened(self, is_flattened: bool) -> Self {
        let outlines = is_flattened.then(|| Outlines::new(&self.law));
        Self { outlines, ..self }
    }

    /// What of the rain is a medium from where `scene`'s camera stands, if drops over `cutoff_px` pixels of radius are shown
    /// by themselves.
    pub(crate) fn parted(&self, scene: &Scene, cutoff_px: f64) -> Parted<'_> {
        let reach = Reach::new(scene.view().focal_px, cutoff_px, self.thinned_px);
        Parted { law: &self.law, reach, extent: self.rain.extent }
    }

    /// This rain with the noise of single drops in its medium, or without.
    pub fn grainy(self, is_grainy: bool) -> Self {
        let median = self.law.median_volume_diameter();
        let holds = |lattice: &Lattice| 2e3 * lattice.radius >= median;
        let lattice = self.lattices.iter().position(holds).filter(|_| is_grainy);
        Self { grain: lattice.map(|lattice| (median, lattice)), ..self }
    }

    /// How far the drops of a lattice reach from their centres at most, in metres.
    fn reach(&self, lattice: &Lattice) -> f64 {
        match self.outlines.is_some() {
            true => lattice.radius * Halves::of_diameter(2e3 * lattice.radius).reach(),
            false => lattice.radius,
        }
    }

    /// Thresholds and quantiles of each class, as [`Lattice`] has them.
    pub fn lattices(&self) -> &[Lattice] {
        &self.lattices
    }

    /// What `scene`'s camera sees at the scene's time, where drops of over `cutoff_px` pixels of radius are shown by
    /// themselves; 0: all. Over a larger cut-off ([`Seen::cutoff_px`]) where more cells than can be numbered would
    /// have to be looked into.
    pub fn seen(&self, scene: &Scene, cutoff_px: f64) -> Seen {
        let mut cutoff_px = cutoff_px.max(thinned::LEAST * self.thinned_px);
        loop {
            match self.seen_over(scene, cutoff_px) {
                Some(seen) => return seen,
                None => cutoff_px = (RAISED * cutoff_px).max(LEAST_RAISED_PX),
            }
        }
    }

    /// [`Field::seen`] at exactly this cut-off; none if the cells cannot be numbered.
    fn seen_over(&self, scene: &Scene, cutoff_px: f64) -> Option<Seen> {
        let (view, metres) = (scene.view(), scene.metres);
        let tick = tick_of_seconds(scene.drawn_time());
        let exposed = scene.drawn_exposure();
        let camera = scene.drawn_position() * metres;
        let pyramid = Pyramid::of(&view, scene);
        let mut seen = Seen {
            classes: Vec::new(),
            slabs: Vec::new(),
            cutoff_px: cutoff_px as f32,
            thinned_px: self.thinned_px.max(cutoff_px) as f32,
            radius_unit: (0.5e-3 * DIAMETER_UNIT / metres) as f32,
            millimetres: (2e3 * metres) as f32,
            extent2: (self.rain.extent / metres).powi(2).min(f64::from(f32::MAX)) as f32,
            band_depths: [0.0; MAX_BANDS as usize],
            medium: None,
            grain: None,
            drops_in_cells: 0.0,
            cells_with_drops: 0.0,
            own: self.own as u32,
            places: Vec::new(),
        };
        let mut first_group = 0;
        let sizes = self.sizes(cutoff_px);
        for (class, lattice) in (0..).zip(&self.lattices) {
            // A drop's own depth decides; the largest of the class is seen farthest.
            let sizes = sizes[usize::from(class as usize >= self.own)];
            let depth = match sizes[0] {
                0.0 => self.rain.extent,
                least => depth_of_radius(view.focal_px, 2e3 * lattice.radius, least),
            };
            let depth = depth.min(self.rain.extent);
            let place = lattice.place(camera, tick);
            let moved = scene.drawn_motion_of(lattice.velocity / metres) * metres;
            let reach = self.reach(lattice);
            for slab in pyramid.slabs(lattice, reach, &place, depth, moved) {
                let cells = f64::from(slab.cells);
                seen.drops_in_cells += cells * lattice.mean;
                seen.cells_with_drops -= cells * (-lattice.mean).exp_m1();
                seen.slabs.push(Slab { kind: class, first_group, ..slab });
                first_group += slab.cells.div_ceil(CELLS_GROUP);
                if seen.slabs.len() > MOST_SLABS || first_group as usize > MOST_GROUPS {
                    return None;
                }
            }
            seen.classes.push(lattice.record((reach, depth), sizes, &place, moved, metres));
            seen.places.push(place);
        }
        let is_flattened = self.outlines.is_some();
        let scales = ([view.focal_px, cutoff_px, self.thinned_px, metres], is_flattened);
        if cutoff_px > 0.0 && scene.model.far_rain != Some(FarRain::None) {
            let (law, outlines) = (&self.law, self.outlines.as_ref());
            let px = (view.focal_px, cutoff_px, self.thinned_px);
            let medium = || MediumRecord::new(law, outlines, px, self.rain.extent, metres);
            seen.medium = Some(self.medium.of(scales, medium));
        }
        if let (Some((median, number)), Some(_)) = (self.grain, &seen.medium) {
            let (law, air_density) = (&self.law, self.rain.air_density);
            let level = self.outlines.as_ref().map(|outlines| outlines.extinction()[0]);
            let widened = level.map_or(1.0, |level| level / self.law.extinction());
            let focal_px = view.focal_px;
            let grain = Grain { law, air_density, focal_px, cutoff_px, exposed, widened };
            let (lattice, place) = (&self.lattices[number], &seen.places[number]);
            let way = scene.drawn_motion_of(lattice.velocity / metres).length() * metres;
            let variances =
                self.variances.of([focal_px, cutoff_px, exposed, widened], || grain.variances());
            let record = grain.record(median, lattice, place, way, metres);
            seen.grain = Some(Grained { record, variances });
        }
        seen.band_depths = self.bands.of(scales, || band_depths(&self.lattices, &seen.classes));
        Some(seen)
    }

    /// Every drop that `scene` shows by itself over a cut-off ([`Field::seen`]), with what became of it, as every
    /// driver must find them: centre in view space, and radius, in scene units.
    pub fn drops_with_visibility(
        &self,
        scene: &Scene,
        cutoff_px: f64,
    ) -> Vec<(Vec3, f32, Visibility)> {
        let mut found = Vec::new();
        self.for_each_shown(scene, cutoff_px, &mut |drop| {
            found.push((drop.view, drop.radius, drop.visibility));
        });
        found
    }

    /// The least radius in pixels of any drop that is shown, and that under which drops are thinned: for drops of the rain's
    /// own and for those beyond, which are all under it.
    fn sizes(&self, cutoff_px: f64) -> [[f64; 2]; 2] {
        let of = |least: f64, most: f64| [least.max(cutoff_px), most.max(cutoff_px)];
        let (thinned, own) = (self.thinned_px, thinned::OWN * self.thinned_px);
        [of(own, thinned), of(thinned::LEAST * thinned, own)]
    }

    /// Calls `visit` for each of those drops.
    pub fn for_each_shown(&self, scene: &Scene, cutoff_px: f64, visit: &mut dyn FnMut(ShownDrop)) {
        let seen = self.seen(scene, cutoff_px);
        let view = scene.view();
        let sight = Sight::of(scene);
        let velocities = self.lattices.iter().map(|lattice| lattice.velocity / scene.metres);
        let roofs = Roofs::of(scene, velocities);
        for slab in &seen.slabs {
            let class = slab.kind as usize;
            let (lattice, place) = (&self.lattices[class], &seen.places[class]);
            let [x, y, z, edge] = seen.classes[class].moved;
            let moved = sight.view_space(Vec3::new(x, y, z));
            for number in 0..slab.cells {
                let cell = slab.cell(number, place);
                for drop in lattice.drops(cell) {
                    let radius = drop.diameter as f32 * seen.radius_unit;
                    let relative = relative(&drop, place, edge);
                    let center = sight.view_space(relative);
                    let is_sheltered =
                        || roofs.as_ref().is_some_and(|roofs| roofs.shelter(relative, class));
                    let is_shown = seen.shows(&drop, class, center, radius, view.focal_px as f32);
                    if is_shown && !is_sheltered() {
                        visit(ShownDrop {
                            number: drop_number(slab.kind, cell, drop.number),
                            view: center,
                            from_camera: lattice.between(place, &drop.place) / scene.metres,
                            radius,
                            velocity: lattice.velocity / scene.metres,
                            visibility: sight.visibility_moving(center, moved, radius),
                        });
                    }
                }
            }
        }
    }

    /// Number of drops that a view shows by themselves over a cut-off in pixels, on average.
    pub fn drops_above(&self, view: &View, cutoff_px: f64) -> f64 {
        let frustum = Frustum::of(view, self.rain.extent);
        thinned::drops_drawn(&frustum, &self.law, cutoff_px, self.thinned_px)
    }

    /// Number of drops in view that `scene` shows by themselves, as every driver must count them.
    pub fn count_visible(&self, scene: &Scene, cutoff_px: f64) -> u64 {
        let mut visible = 0;
        self.for_each_shown(scene, cutoff_px, &mut |drop| {
            visible += u64::from(drop.visibility == Visibility::Visible);
        });
        visible
    }
}

/// A drop of real rain that a picture shows by itself; lengths in scene units.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ShownDrop {
    /// Its number, the same at all times and from every eye ([`drop_number`]).
    pub number: u64,
    /// Centre in view space.
    pub view: Vec3,
    /// Centre from the camera, along the world's axes.
    pub from_camera: DVec3,
    /// Radius.
    pub radius: f32,
    /// Scene units a second.
    pub velocity: DVec3,
    /// What becomes of it in the picture.
    pub visibility: Visibility,
}

/// Number of a drop of real rain, from its class, its cell and its number in the cell: `number_of` in `glsl/include/drop_records.glsl`.
///
/// It keeps 17 bits of a cell's number along each axis, so drops that are 131,072 cells apart (eight kilometres with the
/// smallest cells) may have the same number. It is never 0, nor is its low or its high half.
pub fn drop_number(class: u32, cell: [i64; 3], in_cell: u32) -> u64 {
    let [x, y, z] = cell.map(|number| number as u64 & 0x1_ffff);
    u64::from(in_cell + 1) | x << 7 | y << 24 | z << 41 | u64::from(class + 1) << 58
}

impl Seen {
    /// Whether a drop is shown by itself: `shown_alone` of `glsl/include/cells.glsl`.
    fn shows(
        &self,
        drop: &CellDrop,
        class: usize,
        center: Vec3,
        radius: f32,
        focal_px: f32,
    ) -> bool {
        let distance2 = (center.x * center.x + center.y * center.y) + center.z * center.z;
        let [.., least, most] = self.classes[class].limits;
        let (size, depth) = (radius * focal_px, -center.z);
        if size < least * depth || distance2 > self.extent2 {
            return false;
        }
        if size >= most * depth {
            return class < self.own as usize;
        }
        let [bits, ..] = pcg4d([radius.to_bits(), drop.number, class as u32, THINNED]);
        let chance = (bits >> 8) as f32 * (1.0 / 16_777_216.0);
        let fourth = |value: f32| (value * value) * (value * value);
        fourth(most * depth) * chance < fourth(size)
    }
}

impl Slab {
    /// The absolute number of cell `number` of the slab.
    fn cell(&self, number: u32, camera: &Place) -> [i64; 3] {
        let [x, y] = self.across;
        let within = [number % x, number / x % y, number / (x * y)];
        [0, 1, 2].map(|axis: usize| {
            let offset = i64::from(self.first[axis]) + i64::from(within[axis]);
            camera.cell[axis].wrapping_add(offset)
        })
    }
}

/// Centre of a drop relative to the camera along the world's axes, in units of which a cell's edge has `edge`; bit
/// for bit what the GPU computes.
fn relative(drop: &CellDrop, camera: &Place, edge: f32) -> Vec3 {
    let along = |axis: usize| {
        let (at, from) = (drop.place.fraction[axis], camera.fraction[axis]);
        let cells = drop.place.cell[axis].wrapping_sub(camera.cell[axis]) - i64::from(at < from);
        (cells as f32 + at.wrapping_sub(from) as f32 * (1.0 / 4_294_967_296.0)) * edge
    };
    Vec3::new(along(0), along(1), along(2))
}

impl Lattice {
    fn record(
        &self,
        (reach, depth): (f64, f64),
        sizes: [f64; 2],
        place: &Place,
        moved: DVec3,
        metres: f64,
    ) -> ClassRecord {
        let with = |[x, y, z]: [u32; 3], w: u32| [x, y, z, w];
        let [x, y, z] = (moved / metres).as_vec3().to_array();
        ClassRecord {
            cell_low: with(place.cell.map(|cell| cell as u32), self.salt[0]),
            cell_high: with(place.cell.map(|cell| (cell >> 32) as u32), self.salt[1]),
            fraction: with(place.fraction, self.thresholds.len() as u32),
            moved: [x, y, z, (self.edge() / metres) as f32],
            limits: [reach / metres, depth / metres, sizes[0], sizes[1]].map(|limit| limit as f32),
        }
    }
}

/// Depths that part what is seen of all classes into bands of equal number of drops, in scene units.
fn band_depths(lattices: &[Lattice], classes: &[ClassRecord]) -> [f32; MAX_BANDS as usize] {
    let depth_of = |class: &ClassRecord| f64::from(class.limits[1]);
    // How many drops a pyramid to this depth holds, each class to its own depth at most.
    let until = |depth: f64| {
        let of_class = |(lattice, class): (&Lattice, &ClassRecord)| {
            lattice.mean * (depth.min(depth_of(class)) / f64::from(class.moved[3])).powi(3)
        };
        lattices.iter().zip(classes).map(of_class).sum::<f64>()
    };
    let farthest = classes.iter().map(depth_of).fold(0.0, f64::max);
    let all = until(farthest);
    std::array::from_fn(|band| {
        let wanted = all * (band + 1) as f64 / f64::from(MAX_BANDS);
        let (mut low, mut high) = (0.0, farthest);
        for _ in 0..40 {
            let middle = 0.5 * (low + high);
            if until(middle) < wanted { low = middle } else { high = middle }
        }
        high as f32
    })
}
