//! What the composite's passes write, and what is bound for all of them.

use std::sync::Arc;

use ash::vk;

use crate::Result;
use crate::abi::LISTED_TILES;
use crate::gpu::sets::composite as slot;
use crate::gpu::{Bindings, Buffer, Device, Memory, Resource, Slot, Texel, Texels};
use crate::passes::environment::EnvironmentMap;
use crate::passes::glints::{Glints, SplatTable};
use crate::passes::tile_grid::TILE_PIXELS;
use crate::passes::tiles::Tiles;
use crate::passes::tone_map::further_sums;

/// Bytes a pixel, of the picture and of the sky.
const PIXEL_BYTES: u64 = 8;

/// What others have prepared, which the passes read.
#[derive(Clone, Copy)]
pub struct Prepared<'a> {
    /// The whole environment, which is behind the drops.
    pub environment: &'a EnvironmentMap,
    /// What drops see of it as a texture.
    pub seen_by_drops: &'a EnvironmentMap,
    /// The bright sources.
    pub glints: &'a Glints,
    /// What splats show.
    pub splats: &'a SplatTable,
    /// The drops on each tile.
    pub tiles: &'a Tiles,
}

/// What the passes write.
pub(super) struct Buffers {
    pub radiance: Buffer,
    pub nearest: Option<Buffer>,
    pub log_sums: Buffer,
    pub sky: Buffer,
    pub disordered_tiles: Buffer,
    pub drawn_tiles: Buffer,
    pub streak_layer_light: Buffer,
    pub line_sums: Option<Buffer>,
}

impl Buffers {
    pub fn new(
        device: &Arc<Device>,
        tiles: &Tiles,
        pixels: u64,
        has_nearest: bool,
        is_listed: bool,
        has_lines: bool,
    ) -> Result<Self> {
        use vk::BufferUsageFlags as Usage;
        let make = |name, bytes, usage| {
            Buffer::new(device, name, bytes, Usage::STORAGE_BUFFER | usage, Memory::Device)
        };
        let maybe = |is_wanted: bool, name, bytes, usage| {
            is_wanted.then(|| make(name, bytes, usage)).transpose()
        };
        let (count, texels) = (u64::from(tiles.count), Usage::UNIFORM_TEXEL_BUFFER);
        let drawn = 2 * tiles.count + tiles.count.div_ceil(LISTED_TILES);
        let drawn = if is_listed { drawn } else { 1 };
        let lit = if tiles.has_streak_layer() { count } else { 1 };
        // Disordered tiles; behind them, where there are streaks, crowded ones; then what unfinished ones have come to.
        let listed = match tiles.long_lists.bytes() {
            0 => 8 * (count + lit),
            bytes => 16 * count + bytes,
        };
        let moved = Usage::TRANSFER_SRC | Usage::TRANSFER_DST;
        let of_lines = Usage::TRANSFER_DST | texels;
        Ok(Self {
            radiance: make("radiance", PIXEL_BYTES * pixels, Usage::TRANSFER_SRC | texels)?,
            nearest: maybe(has_nearest, "nearest drops", 8 * pixels, Usage::TRANSFER_SRC)?,
            log_sums: make(
                "log luminance sums",
                4 * (count + u64::from(further_sums(device.report.machine))),
                moved | texels,
            )?,
            sky: make("sky", PIXEL_BYTES * TILE_PIXELS * count, texels)?,
            // Before composite lists tiles here, glints lists large drops.
            disordered_tiles: make(
                "disordered tiles",
                listed.max(4 * tiles.room_for_larges()),
                Usage::empty(),
            )?,
            drawn_tiles: make("drawn tiles", 4 * u64::from(drawn), Usage::empty())?,
            streak_layer_light: make("light of streaks", 16 * lit, texels)?,
            line_sums: maybe(has_lines, "sums of lines", 4 * TILE_PIXELS * count, of_lines)?,
        })
    }

    /// What the shaders read a texel at a time, besides what [`Tiles`] has.
    ///
    /// # Errors
    /// See [`Texels::new`].
    pub fn texels(
        &self,
        device: &Arc<Device>,
        Prepared { splats, tiles, .. }: Prepared<'_>,
    ) -> Result<[(Slot, Texels); 5]> {
        let four_words = |name, buffer| Texels::new(device, name, buffer, Texel::FourWords);
        let lines = self.line_sums.as_ref().unwrap_or(&self.sky);
        let links = &tiles.streak_layer.buffer;
        let links = Texels::new(device, "texels of streaks' links", links, Texel::TwoWords)?;
        Ok([
            (slot::SKY_TEXELS, four_words("texels of the sky", &self.sky)?),
            (slot::SPLAT_TEXELS, four_words("texels of splats", &splats.table)?),
            (slot::LINE_TEXELS, four_words("texels of lines", lines)?),
            (
                slot::STREAK_LAYER_TEXELS,
                four_words("texels of their light", &self.streak_layer_light)?,
            ),
            (slot::LINK_TEXELS, links),
        ])
    }

    /// What is bound for all passes.
    pub fn bindings(
        &self,
        device: &Arc<Device>,
        prepared: Prepared<'_>,
        texels: &[(Slot, Texels); 5],
    ) -> Result<Bindings> {
        let Prepared { environment, seen_by_drops, splats, tiles, .. } = prepared;
        let buffers = [
            (slot::RADIANCE, &self.radiance),
            (slot::SKY, &self.sky),
            (slot::LOG_SUMS, &self.log_sums),
            (slot::DISORDERED, &self.disordered_tiles),
            (slot::DRAWN_TILES, &self.drawn_tiles),
            (slot::SPLAT_TABLE, &splats.table),
            (slot::SHAPES, &tiles.shapes.given),
            (slot::STREAK_LAYER_LIGHT, &self.streak_layer_light),
            // Without lines no shader reads it.
            (slot::LINE_SUMS, self.line_sums.as_ref().unwrap_or(&self.sky)),
            // Where it is not wanted no shader writes it.
            (slot::NEAREST_DROPS, self.nearest.as_ref().unwrap_or(&self.sky)),
        ];
        let maps = [(slot::ENVIRONMENT_MAP, seen_by_drops), (slot::WHOLE_MAP, environment)];
        let of_tiles =
            [(slot::NODE_TEXELS, &tiles.texels.nodes), (slot::HEAD_TEXELS, &tiles.texels.heads)];
        let views = of_tiles.into_iter().chain(texels.iter().map(|(slot, view)| (*slot, view)));
        let slots: Vec<_> = buffers
            .map(|(slot, buffer)| (slot, Resource::Buffer(buffer)))
            .into_iter()
            .chain(maps.map(|(slot, map)| (slot, Resource::Sampled(&map.image, &map.sampler))))
            .chain(views.map(|(slot, view)| (slot, Resource::Texels(view))))
            .chain(tiles.shelter_slots([slot::HEIGHT_MAP, slot::SHELTER]))
            .collect();
        Ok(Bindings::of(device, "composite", &slots)?.beside(&tiles.shared))
    }
}
