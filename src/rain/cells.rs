//! Rain without end: space itself is a hash. Each class of drops has a lattice of cells that falls with it;
//! cell (i, j, k) of class c holds a Poisson number of drops whose places and diameters come from a hash of
//! (seed, c, i, j, k). No box, no repetition, nothing stored: a drop is found where it is looked for, at any
//! time and any distance from where the camera began.
//!
//! All of it is exact in integers, so that every driver and every platform finds the same drops, bit for bit,
//! forwards and backwards in time:
//! - A cell's edge is a power of two of a metre. A place is a 64-bit number of a cell and 32 bits within it.
//! - A class moves a whole number of 2⁻⁶⁴ cells a tick; only the camera's place among the cells is computed,
//!   once a class and frame, in 128 bits. Cells near it differ from it by 32-bit numbers.
//! - The number of drops is the number of thresholds that 32 random bits reach. A diameter is linear between
//!   two of 65 quantiles, by the upper half of a 32-bit product.
//!
//! A shader without 64-bit integers does the same with two words and a carry.

use std::collections::VecDeque;
use std::sync::{Mutex, PoisonError};

use glam::DVec3;

use crate::abi::MOST_CLASSES;
use crate::rain::classes::Class;
use crate::rain::law::Law;
use crate::rain::{Tick, pcg4d};

/// Drops that a cell holds on average, within a factor of 2^1.5: fewer, and most cells that are looked into
/// are empty; more, and too many drops beside the view come along with those in it.
const DROPS_A_CELL: f64 = 3.0;

/// Largest edge, as a power of two: 2^10 m. A class with fewer drops than one in 2^62 m³ has none at all.
const MOST_LOG2_EDGE: i32 = 10;

/// Binary digits of a diameter's segment: 64 segments of equal number a class.
const SEGMENT_BITS: u32 = 6;

/// Diameters are whole multiples of this many mm, 2⁻²⁰: exact in float32 up to 16 mm.
pub const DIAMETER_UNIT: f64 = 1.0 / 1_048_576.0;

/// Quantiles of the diameters of a class, in units of 2⁻²⁰ mm.
type Quantiles = [u32; 1 + (1 << SEGMENT_BITS)];

const _: () = assert!(crate::abi::QUANTILES as usize == size_of::<Quantiles>() / 4);

/// Digits after the binary point of a camera's position in metres.
const POSITION_BITS: i32 = 48;

/// Farthest from the origin that a camera may be on any axis, in metres.
pub const FARTHEST: f64 = 1e12;

/// The cells of one class.
#[derive(Clone, Debug, PartialEq)]
pub struct Lattice {
    /// Hash of the seed and the class's number.
    pub salt: [u32; 2],
    /// The cell's edge is 2 to this power, in metres.
    pub log2_edge: i32,
    /// Drops of a cell, on average.
    pub mean: f64,
    /// A cell holds as many drops as there are thresholds that its random bits reach.
    pub thresholds: Vec<u32>,
    /// Quantiles of the diameter, in units of 2⁻²⁰ mm.
    pub quantiles: Quantiles,
    /// Largest radius, m.
    pub radius: f64,
    /// Velocity, m/s; what the drops move by is `motion`, which rounds it.
    pub velocity: DVec3,
    /// Motion in 2⁻⁶⁴ cells a tick.
    motion: [i128; 3],
}

/// A place among the cells of a class: the cell, and the fraction of its edge in units of 2⁻³².
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Place {
    /// The cell's number on each axis; wraps around.
    pub cell: [i64; 3],
    /// Where in the cell.
    pub fraction: [u32; 3],
}

/// A drop in its cell.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct CellDrop {
    /// Where it is among the cells of its class.
    pub place: Place,
    /// Its number in the cell.
    pub number: u32,
    /// Its diameter in units of 2⁻²⁰ mm.
    pub diameter: u32,
}

impl CellDrop {
    /// Diameter of the sphere of equal volume, mm.
    pub fn diameter_mm(&self) -> f64 {
        f64::from(self.diameter) * DIAMETER_UNIT
    }
}

/// The lattices of all classes that hold drops; they are numbered from `first` on, by which the cells of one differ from those of
/// another.
pub fn lattices(seed: u64, first: u32, law: &Law, classes: &[Class], wind: DVec3) -> Vec<Lattice> {
    (first..)
        .zip(classes)
        .map(|(number, class)| Lattice::new(salt(seed, number), law, class, wind))
        .filter(|lattice| !lattice.thresholds.is_empty())
        .collect()
}

impl Lattice {
    fn new(salt: [u32; 2], law: &Law, class: &Class, wind: DVec3) -> Self {
        let log2_edge = ((DROPS_A_CELL / class.number).log2() / 3.0).round();
        let log2_edge = log2_edge.min(f64::from(MOST_LOG2_EDGE)) as i32;
        let velocity = wind - class.speed * DVec3::Y;
        // 2^64 cells over TICKS_PER_SECOND = 2^32.
        let motion = (velocity * f64::from(32 - log2_edge).exp2()).round();
        let mean = class.number * f64::from(3 * log2_edge).exp2();
        Self {
            salt,
            log2_edge,
            mean,
            thresholds: poisson(mean),
            quantiles: quantiles(law, class),
            radius: 0.5e-3 * class.to,
            velocity,
            motion: motion.to_array().map(|cells| cells as i128),
        }
    }

    /// Edge of a cell, m.
    pub fn edge(&self) -> f64 {
        f64::from(self.log2_edge).exp2()
    }

    /// Where a camera at `position`, in metres, is among the cells at `tick`.
    ///
    /// The position is rounded once, to 2⁻⁴⁸ m, the same for all classes.
    pub fn place(&self, position: DVec3, tick: Tick) -> Place {
        let shift = POSITION_BITS - 32 + self.log2_edge;
        let along = |axis: usize| {
            let metres = (position[axis] * f64::from(POSITION_BITS).exp2()).round() as i128;
            let still = if shift < 0 { metres << -shift } else { metres >> shift };
            still.wrapping_sub(self.motion[axis].wrapping_mul(tick) >> 32)
        };
        let places = [along(0), along(1), along(2)];
        Place { cell: places.map(|p| (p >> 32) as i64), fraction: places.map(|p| p as u32) }
    }

    /// The drops of a cell.
    pub fn drops(&self, cell: [i64; 3]) -> impl Iterator<Item = CellDrop> {
        let key = self.key(cell);
        let count = self.thresholds.partition_point(|threshold| *threshold <= key[3]) as u32;
        (0..count).map(move |number| {
            let [x, y, z, size] = pcg4d([key[0], key[1], key[2], key[3].wrapping_add(1 + number)]);
            let place = Place { cell, fraction: [x, y, z] };
            CellDrop { place, number, diameter: self.diameter(size) }
        })
    }

    /// Four random words of a cell: two rounds of `pcg4d`, the first over the low words of the cell's numbers,
    /// the second over the high ones.
    fn key(&self, cell: [i64; 3]) -> [u32; 4] {
        let low = cell.map(|number| number as u32);
        let high = cell.map(|number| (number >> 32) as u32);
        let [x, y, z, w] = pcg4d([low[0], low[1], low[2], self.salt[0]]);
        pcg4d([x ^ high[0], y ^ high[1], z ^ high[2], w ^ self.salt[1]])
    }

    /// Diameter for 32 random bits: the first ones choose a segment of the quantiles, the others a place in it.
    fn diameter(&self, bits: u32) -> u32 {
        let segment = (bits >> (32 - SEGMENT_BITS)) as usize;
        let (from, to) = (self.quantiles[segment], self.quantiles[segment + 1]);
        let within = u64::from(to - from) * u64::from(bits << SEGMENT_BITS);
        from + (within >> 32) as u32
    }

    /// From one place to another, in metres; exact within 2^21 cells.
    pub fn between(&self, from: &Place, to: &Place) -> DVec3 {
        let along = |axis: usize| {
            let cells = to.cell[axis].wrapping_sub(from.cell[axis]);
            let fractions = i128::from(to.fraction[axis]) - i128::from(from.fraction[axis]);
            ((i128::from(cells) << 32) + fractions) as f64
        };
        DVec3::new(along(0), along(1), along(2)) * f64::from(self.log2_edge - 32).exp2()
    }

    /// Visits every cell within `reach` metres of the camera on each axis whose drops may be in a region.
    /// `meets` tells whether a box, given by its lower and upper corner relative to the camera in metres, may
    /// hold a part of the region; boxes are halved until they are cells. They are larger than the cells by a
    /// drop's radius and by how far drops move, in metres.
    pub fn visit(
        &self,
        camera: &Place,
        reach: f64,
        moved: DVec3,
        meets: &dyn Fn(DVec3, DVec3) -> bool,
        visit: &mut dyn FnMut([i64; 3]),
    ) {
        let edge = self.edge();
        // Relative to the camera's cell; no more than a lattice of a picture needs, and far from overflow.
        let most = (reach / edge).ceil().min(1e9) as i64 + 1;
        let corner = DVec3::from_array(camera.fraction.map(f64::from)) / -4_294_967_296.0;
        let (below, above) =
            (self.radius - moved.min(DVec3::ZERO), self.radius + moved.max(DVec3::ZERO));
        let mut stack = vec![([-most; 3], [most; 3])];
        while let Some((from, to)) = stack.pop() {
            let at = |cell: [i64; 3]| (DVec3::from_array(cell.map(|c| c as f64)) + corner) * edge;
            if !meets(at(from) - below, at(to) + above) {
                continue;
            }
            let edges = [0, 1, 2].map(|axis: usize| to[axis] - from[axis]);
            let longest = (0..3).max_by_key(|axis| edges[*axis]).unwrap_or(0);
            if edges[longest] == 1 {
                let cell = [0, 1, 2].map(|axis: usize| camera.cell[axis].wrapping_add(from[axis]));
                visit(cell);
                continue;
            }
            let (mut middle, mut middle_to) = (from, to);
            middle[longest] += edges[longest] / 2;
            middle_to[longest] = middle[longest];
            stack.push((middle, to));
            stack.push((from, middle_to));
        }
    }
}

/// What tells the cells of one class and seed from those of another.
fn salt(seed: u64, class: u32) -> [u32; 2] {
    const CELLS: u32 = 0x6365_6c6c; // "cell"
    let [x, y, ..] = pcg4d([seed as u32, (seed >> 32) as u32, class, CELLS]);
    [x, y]
}

/// Finds the quantiles of a class. The last ones are kept, because many pictures are of one rain, and all else about its cells takes a
/// fraction of the time.
fn quantiles(law: &Law, class: &Class) -> Quantiles {
    type Found = VecDeque<((Law, [f64; 2]), Quantiles)>;
    static FOUND: Mutex<Found> = Mutex::new(VecDeque::new());
    let found = || FOUND.lock().unwrap_or_else(PoisonError::into_inner);
    let of = (*law, [class.from, class.to]);
    if let Some((_, known)) = found().iter().find(|(other, _)| *other == of) {
        return *known;
    }
    let quantile = |i: usize| {
        let share = i as f64 / f64::from(1 << SEGMENT_BITS);
        (law.quantile_between(0.0, share, class.from, class.to) / DIAMETER_UNIT).round() as u32
    };
    let made = std::array::from_fn(quantile);
    let mut found = found();
    found.push_back((of, made));
    if found.len() > MOST_CLASSES as usize {
        found.pop_front();
    }
    made
}

/// Thresholds for a Poisson number of the given mean: 2³² times the probability of at most 0, 1, 2, … All that
/// 32 bits can reach.
fn poisson(mean: f64) -> Vec<u32> {
    let (mut probability, mut at_most, mut thresholds) = ((-mean).exp(), 0.0, Vec::new());
    for number in 1.. {
        at_most += probability;
        let threshold = (at_most * 4_294_967_296.0).round();
        if threshold >= 4_294_967_296.0 {
            break;
        }
        thresholds.push(threshold as u32);
        probability *= mean / f64::from(number);
    }
    thresholds
}
