//! Points that fill five dimensions evenly together: place in the pixel, moment, place on the lens.
//!
//! Sobol's sequence (directions of Joe and Kuo 2008) with Owen's scrambling, one for each pixel and
//! dimension, by a hash (Burley 2020, "Practical hash-based Owen scrambling"). Every block of 2^k points
//! is stratified in place, moment and lens and in most of their combinations; the scrambling makes each
//! point uniform by itself, so the mean is unbiased for any number of samples. A power of two is filled
//! most evenly.

use crate::rain::{pcg4d, unit};

/// Dimensions of a point.
const DIMENSIONS: usize = 5;

/// Degree, coefficients and first directions of each dimension's primitive polynomial, from the second
/// dimension on.
const POLYNOMIALS: [(usize, u32, &[u32]); DIMENSIONS - 1] =
    [(1, 0, &[1]), (2, 1, &[1, 3]), (3, 1, &[1, 3, 1]), (3, 2, &[1, 1, 1])];

/// Scrambled points for every pixel.
#[derive(Clone, Debug)]
pub struct Sobol {
    count: u32,
    seed: u64,
    directions: [[u32; 32]; DIMENSIONS],
}

impl Sobol {
    /// `count` points a pixel (0 is taken as 1).
    pub fn new(count: u32, seed: u64) -> Self {
        // The first dimension is van der Corput's.
        let mut directions = [std::array::from_fn(|bit| 1 << (31 - bit)); DIMENSIONS];
        for (directions, (degree, coefficients, first)) in
            directions[1..].iter_mut().zip(POLYNOMIALS)
        {
            for bit in 0..32 {
                directions[bit] = if bit < degree {
                    first[bit] << (31 - bit)
                } else {
                    let before = directions[bit - degree];
                    (1..degree)
                        .filter(|term| coefficients >> (degree - 1 - term) & 1 == 1)
                        .fold(before ^ before >> degree, |sum, term| sum ^ directions[bit - term])
                };
            }
        }
        Self { count: count.max(1), seed, directions }
    }

    /// The points of a pixel, by its number in the picture; each within the open unit cube.
    pub fn points(&self, pixel: u32) -> impl Iterator<Item = [f64; DIMENSIONS]> {
        let [low, high] = [self.seed as u32, (self.seed >> 32) as u32];
        let [a, b, c, d] = pcg4d([pixel, 0, low, high]);
        let scrambles = [a, b, c, d, pcg4d([pixel, 1, low, high])[0]];
        (0..self.count).map(move |number| {
            let (mut point, mut left) = ([0; DIMENSIONS], number);
            while left != 0 {
                let bit = left.trailing_zeros() as usize;
                for (point, directions) in point.iter_mut().zip(&self.directions) {
                    *point ^= directions[bit];
                }
                left &= left - 1;
            }
            std::array::from_fn(|dimension| unit(scramble(point[dimension], scrambles[dimension])))
        })
    }
}

/// Owen's scrambling: each bit is flipped or not as the bits above it and the seed decide. The hash of
/// Laine and Karras lets bits change those above them only, so it works on the reversed number (constants
/// of Vegdahl 2021).
fn scramble(bits: u32, seed: u32) -> u32 {
    let mut x = bits.reverse_bits();
    x ^= x.wrapping_mul(0x3d20_adea);
    x = x.wrapping_add(seed);
    x = x.wrapping_mul(seed >> 16 | 1);
    x ^= x.wrapping_mul(0x0552_6c56);
    x ^= x.wrapping_mul(0x53a2_2864);
    x.reverse_bits()
}
