//! Where in a pixel its samples lie: stratified, and a pure function of (pixel, sample, seed), so
//! that a picture does not depend on the number of threads.

use crate::rain::pcg4d;

/// Strata of equal area that fill a pixel, one a sample, for any number of samples.
///
/// The pixel is cut into ⌊√N⌋ rows; the N strata are dealt out to the rows as evenly as they go,
/// and a row is as high as its share of them. For a square number that is the usual jittered grid,
/// whose error falls like N^(-3/4) where an edge crosses the pixel and like 1/N elsewhere
/// (Mitchell 1996, "Consequences of stratified sampling in graphics"), against N^(-1/2) unstratified.
#[derive(Clone, Debug)]
pub struct Strata {
    seed: u64,
    /// Left, upper, width, height of each stratum in pixels.
    cells: Vec<[f64; 4]>,
}

impl Strata {
    /// Strata for `samples` samples a pixel (0 is taken as 1).
    pub fn new(samples: u32, seed: u64) -> Self {
        let samples = u64::from(samples.max(1));
        let rows = samples.isqrt();
        let mut cells = Vec::with_capacity(samples as usize);
        for row in 0..rows {
            let (first, end) = (row * samples / rows, (row + 1) * samples / rows);
            let columns = (end - first) as f64;
            for column in 0..end - first {
                cells.push([
                    column as f64 / columns,
                    first as f64 / samples as f64,
                    1.0 / columns,
                    columns / samples as f64,
                ]);
            }
        }
        Self { seed, cells }
    }

    /// Places of the samples in pixel (0 to 1 from its upper left corner), by the number of the
    /// pixel in its picture.
    pub fn places(&self, pixel: u32) -> impl Iterator<Item = (f64, f64)> {
        let [low, high] = [self.seed as u32, (self.seed >> 32) as u32];
        self.cells.iter().zip(0..).map(move |(&[left, upper, width, height], sample)| {
            let [x, y, ..] = pcg4d([pixel, sample, low, high]);
            // The middle of one of 2^32 intervals: never on the stratum's border.
            let unit = |bits: u32| (f64::from(bits) + 0.5) / 4_294_967_296.0;
            (left + width * unit(x), upper + height * unit(y))
        })
    }
}
