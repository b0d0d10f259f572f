//! How much a dispatch does at most, of rays and of a tile's list: known before it is recorded, so that no watchdog of a driver,
//! which resets a device after some two seconds, ends a long one.
//!
//! What there is beyond the first piece is found by further dispatches. Of rays: `blocks.comp` fills their arguments, so those for which
//! there is nothing have no workgroups; and a view records only as many as its room for blocks can ask for, most often one.

use super::tile_grid::TILE_PIXELS;
use crate::abi::{MOST_ENTRIES, MOST_LENS_RAYS, MOST_MOVING_RAYS, RAY_PIECES, SAVED};
use crate::plan::FramePlan;
use crate::scene::model::{Lens, Motion};

/// Rays of a dispatch, at most: 7 ms on an NVIDIA H100, where `exact` takes 87 ms for 64 rays a pixel of 4 M drops.
const MOST_RAYS: u64 = 1 << 26;
/// Blocks of a workgroup of `rays.comp`, by its invocations, one a pixel.
const BLOCKS_A_GROUP: u64 = 256 / TILE_PIXELS;
/// Workgroups of a dispatch, on any device.
const MOST_GROUPS: u64 = 32_768;
/// Rays of a pixel of a drop that is no sphere, at least (`LEAST_FLAT_RAYS`).
const LEAST_RAYS: u64 = 4;

/// Rays of a pixel at most. How many one of a drop that moves or is out of focus has is found as they are traced.
pub(crate) fn rays_of_a_pixel(plan: &FramePlan) -> u32 {
    match (plan.lens, plan.motion) {
        (Lens::Pinhole, Motion::Instant) => plan.unsure_rays,
        (Lens::Pinhole, _) => plan.unsure_rays.max(MOST_MOVING_RAYS),
        _ => plan.unsure_rays.max(MOST_LENS_RAYS),
    }
}

/// How blocks that are drawn by rays are shared out among dispatches.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct RayPieces {
    /// Blocks of a dispatch at most.
    pub blocks: u32,
    /// Dispatches.
    pub count: u32,
}

impl RayPieces {
    /// For so much `room` for blocks, of at most `samples` rays a pixel, on a device with so many workgroups along an axis. More
    /// than [`RAY_PIECES`] there cannot be: beyond that each does more.
    pub fn of(room: u64, samples: u32, groups: u32) -> Self {
        let most = MOST_RAYS / (TILE_PIXELS * u64::from(samples).max(LEAST_RAYS));
        let of_groups = BLOCKS_A_GROUP * MOST_GROUPS.min(groups.into());
        let least = room.div_ceil(RAY_PIECES.into());
        let blocks = most.min(of_groups).max(least).next_multiple_of(BLOCKS_A_GROUP);
        Self { blocks: blocks as u32, count: room.div_ceil(blocks).max(1) as u32 }
    }
}

/// Lists of random drops are not so many times as long as they are on the mean.
const UNEVEN: f64 = 64.0;

/// Tiles whose lists are longer than one dispatch goes through.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct LongLists {
    /// Dispatches that go on with them.
    pub walks: u32,
    /// How many of them there may be; 0 without such dispatches.
    pub tiles: u32,
}

impl LongLists {
    /// How lists are gone through that have room for so many `nodes`, `a_tile` on the mean, where `placed` drops may all be on one tile. With each
    /// `factor` of more room there are further walks, should lists be longer all the same.
    pub fn of(nodes: u64, a_tile: f64, placed: usize, factor: u32) -> Self {
        let tiles = nodes / u64::from(MOST_ENTRIES);
        let longest = UNEVEN * a_tile + placed as f64;
        let expected = (longest / f64::from(MOST_ENTRIES)) as u64 + u64::from(factor - 1);
        let walks = expected.min(tiles) as u32;
        Self { walks, tiles: if walks > 0 { tiles as u32 } else { 0 } }
    }

    /// Bytes for what the tiles have come to.
    pub fn bytes(&self) -> u64 {
        u64::from(16 * SAVED) * u64::from(self.tiles)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::environment::Environment;
    use crate::plan::{Output, plan};
    use crate::scene::Scene;

    #[test]
    fn drops_that_are_spread_have_more_rays_a_pixel() {
        let white = Environment::constant(glam::Vec3::ONE);
        let rays = |text: &str| {
            let scene = Scene::parse(&format!("[rain]\ncount = 1000000\n{text}"), "a.toml")
                .expect("a scene");
            rays_of_a_pixel(&plan(&scene, &white, Output::Display).expect("a plan"))
        };
        assert_eq!(rays("[model]\npreset = \"fast\""), 1);
        assert_eq!(rays("[camera]\nshutter = 0.02\n[model]\npreset = \"fast\""), MOST_MOVING_RAYS);
        let lens = "[camera]\naperture = 0.05\nfocus = 3.0\n[model]\npreset = \"fast\"";
        assert_eq!(rays(lens), MOST_LENS_RAYS);
        assert_eq!(rays(&format!("{lens}\nsamples = 256")), 256);
    }

    #[test]
    fn no_dispatch_does_more_than_is_stated_and_none_is_left_out() {
        for room in [1u64, 16_384, 1 << 20, 5_000_000] {
            for samples in [1u32, 4, 16, 64, 256] {
                let RayPieces { blocks, count } = RayPieces::of(room, samples, 65_535);
                let all = u64::from(blocks) * u64::from(count);
                assert!(all >= room && all - room < u64::from(blocks), "{room} {samples}");
                let rays = u64::from(blocks) * TILE_PIXELS * u64::from(samples);
                let is_stated = rays <= MOST_RAYS + 256 * 256 || count == RAY_PIECES;
                assert!(is_stated, "{rays} rays in one of {count}, {room} {samples}");
                assert!(count <= RAY_PIECES && u64::from(blocks) <= BLOCKS_A_GROUP * 65_535);
            }
        }
        // What a frame of today has: one, and the 4 M drops of `exact` with 64 rays several.
        assert_eq!(RayPieces::of(300_000, 4, 65_535).count, 1);
        assert!(RayPieces::of(4_000_000, 64, 65_535).count > 20);
    }

    /// The usual picture has none; where drops are many for their pixels, or may all be on one, there are as many as their list takes.
    #[test]
    fn long_lists_take_further_dispatches() {
        let walks = |nodes, a_tile, placed, factor| LongLists::of(nodes, a_tile, placed, factor);
        let usual = walks(3_000_000, 11.0, 1000, 1);
        assert_eq!((usual.walks, usual.tiles, usual.bytes()), (0, 0, 0));
        // Four million drops on one tile: all entries that there is room for.
        let one = walks(3_000_000, 1_440_000.0, 0, 1);
        assert_eq!((one.walks, one.tiles), (45, 45));
        assert_eq!(one.bytes(), 45 * 17 * 16);
        assert_eq!(walks(3_000_000, 0.0, 131_072, 1).walks, 2);
        // What was told to lack room gets a further one.
        assert_eq!(walks(3_000_000, 11.0, 0, 2).walks, 1);
        assert_eq!(walks(65_535, 1e9, 0, 8).walks, 0);
    }
}
