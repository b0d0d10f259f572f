//! The rain's drops in clusters: sixteen near one another, and the box around them.
//!
//! All drops fall alike, so which of them are neighbours never changes: the clusters fall with them. One
//! sort when the scene is made lets every frame pass over whole clusters that are out of view.

use std::sync::Arc;

use glam::DVec3;
use rayon::prelude::*;

pub use crate::abi::{CLUSTER, NO_DROP};
use crate::rain::{Rain, start};

/// Drops that share a cell of the grid by which they are sorted, on average. (With two, 4 million took
/// 30 ms longer to sort, and no fewer drops out of view came along.)
const DROPS_A_CELL: f64 = 8.0;

/// Finest grid: 128 cells an edge.
const MAX_BITS: u32 = 7;

/// Cells an edge by which placed drops are sorted, as a power of two.
const PLACED_BITS: u32 = 10;

/// Binary digits of a box's edges.
const EDGE_BITS: u32 = 10;

/// Drop indices, cluster by cluster.
pub struct Clusters {
    /// Indices of the random drops, then of the drops placed by hand; [`CLUSTER`] for each cluster, those
    /// that lack [`NO_DROP`].
    pub order: Vec<u32>,
    /// The box around each cluster of random drops. Placed drops may move apart: theirs are found in each frame.
    pub boxes: Vec<ClusterBox>,
}

/// The box around a cluster's drops at tick 0. Three words: its smallest coordinates, in units of 2^-32 of the rain
/// box. The fourth: its three edges minus one, x in the lowest bits, ten bits each, in units of 2^-10, rounded up; and the
/// number of the population that all of its drops are of, two bits.
pub type ClusterBox = [u32; 4];

impl Clusters {
    /// Sorts the drops of each population, whose indices follow one another, and those that have a `placed` centre, which
    /// follow; all in clusters of their own.
    pub fn new(populations: &[Rain], placed: &[DVec3]) -> Self {
        let (mut order, mut boxes) = (Vec::new(), Vec::new());
        let mut first = 0;
        for (number, rain) in (0..).zip(populations) {
            let mut own = in_order(rain);
            fill_last(&mut own);
            let around = own.par_chunks(CLUSTER as usize).map(|drops| {
                let [x, y, z, edges] = box_around(rain.seed, drops);
                [x, y, z, edges | number << (3 * EDGE_BITS)]
            });
            boxes.par_extend(around);
            let index = |index| if index == NO_DROP { NO_DROP } else { first + index };
            match first {
                0 => order = own,
                _ => order.par_extend(own.into_par_iter().map(index)),
            }
            first += rain.count;
        }
        order.extend(placed_in_order(placed).into_iter().map(|number| first + number));
        fill_last(&mut order);
        Self { order, boxes }
    }

    /// With `count` more drops, from index `first` on, whose places are not known: those that follow one another share a
    /// cluster.
    pub fn followed_by(mut self, first: u32, count: u32) -> Self {
        self.order.extend(first..first + count);
        fill_last(&mut self.order);
        self
    }

    /// The placed drops' places in their list, cluster by cluster, where `first` drops are before them.
    pub fn placed(&self, first: u32) -> Arc<[u32]> {
        let order = &self.order[self.boxes.len() * CLUSTER as usize..];
        order.iter().map(|i| if *i == NO_DROP { NO_DROP } else { i - first }).collect()
    }

    /// Clusters in all, those of the placed drops included.
    pub fn count(&self) -> u32 {
        self.order.len() as u32 / CLUSTER
    }
}

fn fill_last(order: &mut Vec<u32>) {
    order.resize(order.len().next_multiple_of(CLUSTER as usize), NO_DROP);
}

/// Indices of the drops, cell by cell of a grid along a Z-order curve.
fn in_order(rain: &Rain) -> Vec<u32> {
    let bits = (f64::from(rain.count) / DROPS_A_CELL).max(1.0).log2() / 3.0;
    let bits = (bits.round() as u32).clamp(1, MAX_BITS);
    let cell_of: Vec<u32> = (0..rain.count)
        .into_par_iter()
        .map(|index| along_curve(start(rain.seed, index), bits))
        .collect();
    let mut next = vec![0u32; (1 << (3 * bits)) + 1];
    for cell in &cell_of {
        next[*cell as usize + 1] += 1;
    }
    for cell in 1..next.len() {
        next[cell] += next[cell - 1];
    }
    let mut order = vec![0u32; rain.count as usize];
    for (index, cell) in (0..).zip(&cell_of) {
        let place = &mut next[*cell as usize];
        order[*place as usize] = index;
        *place += 1;
    }
    order
}

/// Numbers of placed drops along the same curve through the box that holds them.
fn placed_in_order(centers: &[DVec3]) -> Vec<u32> {
    let low = centers.iter().copied().reduce(DVec3::min).unwrap_or_default();
    let high = centers.iter().copied().reduce(DVec3::max).unwrap_or_default();
    // All in one place: any order. The cast saturates.
    let scale = (high - low).map(|edge| f64::from(u32::MAX) / edge.max(f64::MIN_POSITIVE));
    let key = |center: &DVec3| {
        let place = ((*center - low) * scale).to_array().map(|part| part as u32);
        along_curve(place, PLACED_BITS)
    };
    let mut keyed: Vec<(u32, u32)> =
        centers.par_iter().map(key).zip(0..centers.len() as u32).collect();
    keyed.par_sort_unstable();
    keyed.into_iter().map(|(_, number)| number).collect()
}

/// Number along the curve of the cell that holds a place: the coordinates' first bits, interleaved.
fn along_curve(place: [u32; 3], bits: u32) -> u32 {
    (32 - bits..32).rev().fold(0, |number, bit| {
        let [x, y, z] = place.map(|coordinate| coordinate >> bit & 1);
        number << 3 | z << 2 | y << 1 | x
    })
}

fn box_around(seed: u64, drops: &[u32]) -> ClusterBox {
    let places =
        || drops.iter().filter(|index| **index != NO_DROP).map(|index| start(seed, *index));
    let low =
        places().fold([u32::MAX; 3], |low, place| [0, 1, 2].map(|i: usize| low[i].min(place[i])));
    let high = places().fold([0; 3], |high, place| [0, 1, 2].map(|i: usize| high[i].max(place[i])));
    let edge =
        |axis: usize| ((high[axis] - low[axis]) >> (32 - EDGE_BITS)) << (EDGE_BITS * axis as u32);
    [low[0], low[1], low[2], edge(0) | edge(1) | edge(2)]
}

#[cfg(test)]
mod tests {
    use super::*;

    fn rain(count: u32) -> Rain {
        Rain { seed: 5, count, half_extent: DVec3::ONE, radius: 1.0, velocity: DVec3::ZERO }
    }

    #[test]
    fn every_drop_is_in_a_cluster_once() {
        for (count, placed) in [(0, 0_u32), (0, 3), (1, 0), (16, 16), (20_001, 3)] {
            let centers: Vec<DVec3> =
                (0..placed).map(|i| DVec3::splat(-f64::from(i % 5))).collect();
            let clusters = Clusters::new(&[rain(count)], &centers);
            assert_eq!(clusters.boxes.len() as u32, count.div_ceil(CLUSTER));
            assert_eq!(clusters.count(), count.div_ceil(CLUSTER) + placed.div_ceil(CLUSTER));
            let (random, by_hand) =
                clusters.order.split_at(clusters.boxes.len() * CLUSTER as usize);
            let mut seen: Vec<u32> = random.iter().copied().filter(|i| *i != NO_DROP).collect();
            seen.sort_unstable();
            assert!(seen.into_iter().eq(0..count));
            let mut placed_here: Vec<u32> =
                by_hand.iter().copied().filter(|index| *index != NO_DROP).collect();
            placed_here.sort_unstable();
            assert!(placed_here.into_iter().eq(count..count + placed));
        }
    }

    #[test]
    fn a_cluster_is_of_one_population() {
        let counts = [5_000, 17, 1];
        let clusters = Clusters::new(&counts.map(rain), &[DVec3::ZERO; 2]);
        let firsts = [0, 5_000, 5_017, 5_018];
        let mut seen = [0; 3];
        for (around, drops) in clusters.boxes.iter().zip(clusters.order.chunks(16)) {
            let number = (around[3] >> 30) as usize;
            for index in drops.iter().filter(|index| **index != NO_DROP) {
                assert!((firsts[number]..firsts[number + 1]).contains(index), "{index}: {number}");
                seen[number] += 1;
            }
        }
        assert_eq!(seen, counts);
    }

    #[test]
    fn placed_drops_of_a_cluster_are_neighbours() {
        let centers: Vec<DVec3> = (0..4096u32)
            .map(|index| start(7, index).map(|part| f64::from(part) / 4_294_967_296.0).into())
            .collect();
        let clusters = Clusters::new(&[], &centers);
        let volumes = clusters.order.chunks(CLUSTER as usize).map(|drops| {
            let places = || drops.iter().map(|index| centers[*index as usize]);
            let low = places().reduce(DVec3::min).expect("drops");
            (places().reduce(DVec3::max).expect("drops") - low).element_product()
        });
        // Usual is 0.011; sixteen drops at random have a box of two thirds of the space.
        let mean = volumes.sum::<f64>() / 256.0;
        assert!(mean < 0.02, "{mean}");
    }

    #[test]
    fn boxes_hold_their_drops_and_are_small() {
        let clusters = Clusters::new(&[rain(20_000)], &[]);
        let mut volume = 0.0;
        for ([x, y, z, edges], drops) in clusters.boxes.iter().zip(clusters.order.chunks(16)) {
            let edges = [0, 10, 20].map(|shift| (u64::from(edges >> shift & 1023) + 1) << 22);
            volume += edges.map(|edge| edge as f64 / 4_294_967_296.0).iter().product::<f64>();
            for index in drops {
                let place = start(5, *index);
                for (axis, low) in [x, y, z].into_iter().enumerate() {
                    let above = place[axis].checked_sub(*low).expect("not below");
                    assert!(u64::from(above) < edges[axis]);
                }
            }
        }
        // Some are cut in two by a step of the curve, and long. (Along a Hilbert curve 1.1: no faster.)
        assert!(volume < 5.0, "boxes of {volume} times the space");
    }
}
