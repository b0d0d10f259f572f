//! Lists of drops by tile as the passes leave them, unpacked as `glsl/include/tile_buffers.glsl`, `splat.glsl` and
//! `shared_exponent.glsl` say.

use glam::{DVec2, DVec3};
use raindrops::abi::{END, NODE, TILE_ACROSS, TILE_DOWN};
use raindrops::renderer::tile_stages::TileStages;

use crate::tile_serial::Rect;

const TILE: DVec2 = DVec2::new(TILE_ACROSS as f64, TILE_DOWN as f64);
pub const PIXELS: u32 = TILE_ACROSS * TILE_DOWN;

/// A drop in the list of a tile.
pub struct Entry {
    /// Number of its node.
    pub node: u32,
    /// What entries are ordered by: bits of a squared distance, and the drop's index.
    pub key: (u32, u32),
    look: Look,
}

enum Look {
    Splat { place: Rect, direction: usize },
    Block { colors: [u32; PIXELS as usize], coverage: [f64; PIXELS as usize] },
}

/// The pixel of that number of a tile.
pub fn pixel(tile: [u32; 2], number: u32) -> [u32; 2] {
    [tile[0] * TILE_ACROSS + number % TILE_ACROSS, tile[1] * TILE_DOWN + number / TILE_ACROSS]
}

pub fn square([x, y]: [u32; 2]) -> Rect {
    Rect::around(DVec2::new(x.into(), y.into()) + 0.5, DVec2::splat(0.5))
}

/// Each tile and its list, from the entry that came last.
pub fn lists(stages: &TileStages) -> Vec<([u32; 2], Vec<Entry>)> {
    let [first, end] = stages.tiles;
    let across = end[0] - first[0];
    let list = |(number, head): (u32, &u32)| {
        let tile = [first[0] + number % across, first[1] + number / across];
        let mut entries = Vec::new();
        let mut link = *head;
        while link != END {
            entries.push(Entry::new(&stages.nodes, link, tile));
            assert!(entries.len() < stages.nodes.len(), "the list of {tile:?} has no end");
            link = stages.nodes[link as usize];
        }
        (tile, entries)
    };
    (0..).zip(&stages.heads).map(list).collect()
}

impl Entry {
    fn new(nodes: &[u32], link: u32, tile: [u32; 2]) -> Self {
        let (node, which) = (link / NODE, link % NODE);
        let words = &nodes[(node * NODE) as usize..];
        let bits = |word: u32, from: u32, count: u32| word >> from & ((1 << count) - 1);
        let look = if which == 3 {
            let share = |n: usize| f64::from(bits(words[12 + n / 2], 16 * (n as u32 % 2), 16));
            Look::Block {
                colors: std::array::from_fn(|n| words[4 + n]),
                coverage: std::array::from_fn(|n| share(n) / 65535.0),
            }
        } else {
            // From the corner of the first of its tiles, of which this is one.
            let offset = DVec2::new((which & 1).into(), (which >> 1 & 1).into());
            let tile = DVec2::new(tile[0].into(), tile[1].into());
            let half = |from| f64::from(bits(words[2], from, 16) as u16 as i16) / 2048.0;
            let side = |from| f64::from(bits(words[3], from, 10)) / 512.0;
            let center = (tile - offset) * TILE + DVec2::new(half(0), half(16));
            Look::Splat {
                place: Rect::around(center, DVec2::new(side(0), side(10))),
                direction: bits(words[3], 20, 12) as usize,
            }
        };
        Self { node, key: (words[0], words[1]), look }
    }

    pub fn is_splat(&self) -> bool {
        matches!(self.look, Look::Splat { .. })
    }

    /// What it covers of a pixel of its tile.
    pub fn coverage(&self, tile: [u32; 2], number: u32) -> f64 {
        match &self.look {
            Look::Splat { place, .. } => place.overlap(square(pixel(tile, number))),
            Look::Block { colors, coverage } => match colors[number as usize] {
                // What its rays do not meet.
                u32::MAX => 0.0,
                _ => coverage[number as usize],
            },
        }
    }

    /// The light that it adds to a pixel: of a splat the upper and the lower half have a colour each.
    pub fn light(&self, tile: [u32; 2], number: u32, table: &[[u32; 4]]) -> DVec3 {
        match &self.look {
            Look::Splat { place, direction } => {
                let (square, middle) =
                    (square(pixel(tile, number)), 0.5 * (place.low.y + place.high.y));
                let upper = Rect { low: place.low, high: DVec2::new(place.high.x, middle) };
                let lower = Rect { low: DVec2::new(place.low.x, middle), high: place.high };
                let [above, below, ..] = table[*direction];
                upper.overlap(square) * radiance(above) + lower.overlap(square) * radiance(below)
            }
            Look::Block { colors, .. } => {
                self.coverage(tile, number) * radiance(colors[number as usize])
            }
        }
    }
}

/// Three mantissas of nine bits and an exponent.
fn radiance(word: u32) -> DVec3 {
    let mantissa = |from: u32| f64::from(word >> from & 511);
    2f64.powi((word >> 27) as i32 - 24) * DVec3::new(mantissa(0), mantissa(9), mantissa(18))
}
