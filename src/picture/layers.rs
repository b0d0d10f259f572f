//! Rain as layers for a compositor: one EXR with premultiplied rain over nothing and what a pixel's nearest drop is.

use std::io::Cursor;
use std::path::Path;

use exr::prelude::{
    AnyChannel, AnyChannels, Encoding, FlatSamples, Layer, LayerAttributes, WritableImage,
};
use half::f16;

use crate::files::write_whole;
use crate::picture::{Picture, place};
use crate::{Error, Result};

/// Rain without what is behind it, row by row from the top.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Layers {
    /// Pixels across.
    pub width: u32,
    /// Pixels down.
    pub height: u32,
    /// Premultiplied light and opacity; over a plate: `rgb + (1 - a) · plate`.
    pub color: Vec<[f16; 4]>,
    /// Depth of the nearest drop's centre along the view axis, in scene units; infinite where there is none.
    pub depth: Vec<f32>,
    /// By how many pixels that drop's centre moves, to the right and down.
    pub motion: Vec<[f16; 2]>,
    /// Drops in the air that cover a part of the pixel, those behind one on a pane too.
    pub count: Vec<u32>,
    /// Number of the nearest one; 0 where there is none. A drop on a pane is nearer than all others: where it covers a part,
    /// number, depth and motion are its own.
    pub id: Vec<u64>,
    /// Part of the pixel that drops on a pane cover; empty without a pane.
    pub glass: Vec<f16>,
    /// Whether numbers have 64 bits: those of real rain.
    pub has_wide_ids: bool,
}

impl Layers {
    /// No rain, of this size.
    pub fn empty(width: u32, height: u32) -> Self {
        let pixels = width as usize * height as usize;
        Self {
            width,
            height,
            color: vec![[f16::ZERO; 4]; pixels],
            depth: vec![f32::INFINITY; pixels],
            motion: vec![[f16::ZERO; 2]; pixels],
            count: vec![0; pixels],
            id: vec![0; pixels],
            glass: Vec::new(),
            has_wide_ids: false,
        }
    }

    /// Copies a part to its place: column and row of its first pixel.
    pub fn place(&mut self, origin: [u32; 2], part: &Self) {
        let (whole, width) = (self.width, part.width);
        place(&mut self.color, whole, origin, &part.color, width);
        place(&mut self.depth, whole, origin, &part.depth, width);
        place(&mut self.motion, whole, origin, &part.motion, width);
        place(&mut self.count, whole, origin, &part.count, width);
        place(&mut self.id, whole, origin, &part.id, width);
        self.has_wide_ids |= part.has_wide_ids;
        if !part.glass.is_empty() {
            self.glass.resize(self.color.len(), f16::ZERO);
            place(&mut self.glass, whole, origin, &part.glass, width);
        }
    }

    /// The rain over a plate of its size.
    pub fn over(&self, plate: &Picture) -> Picture {
        let over = |(color, plate): (&[f16; 4], &glam::Vec3)| {
            let [r, g, b, a] = color.map(f16::to_f32);
            glam::Vec3::new(r, g, b) + (1.0 - a) * *plate
        };
        Picture { pixels: self.color.iter().zip(&plate.pixels).map(over).collect(), ..*plate }
    }

    /// Writes one EXR: `R G B A` and `motion.X motion.Y` as float16, `Z` as float32, `count`, `id` and, where numbers have
    /// 64 bits, `id_high` as integers; with a pane `pane.A` as float16. For tools that hold float32 alone, whose integers are exact up to 2²⁴, the number
    /// again by 24 bits each: `id.low`, `id.high` and, where numbers have 64 bits, `id.top`. Blender takes all channels
    /// of one name before the dot for one unless a single letter follows it, so the same stands in `id24.X` to `id24.Z`.
    ///
    /// # Errors
    /// [`Error::File`] if it cannot be encoded or written.
    pub fn write_exr(&self, path: &Path) -> Result<()> {
        let half =
            |of: &dyn Fn(usize) -> f16| FlatSamples::F16((0..self.color.len()).map(of).collect());
        let color = |channel: usize| half(&|at| self.color[at][channel]);
        let motion = |axis: usize| half(&|at| self.motion[at][axis]);
        let mut channels = vec![
            AnyChannel::new("R", color(0)),
            AnyChannel::new("G", color(1)),
            AnyChannel::new("B", color(2)),
            AnyChannel::new("A", color(3)),
            AnyChannel::new("Z", FlatSamples::F32(self.depth.clone())),
            AnyChannel::new("motion.X", motion(0)),
            AnyChannel::new("motion.Y", motion(1)),
            AnyChannel::new("count", FlatSamples::U32(self.count.clone())),
            AnyChannel::new("id", FlatSamples::U32(self.id.iter().map(|id| *id as u32).collect())),
        ];
        if !self.glass.is_empty() {
            channels.push(AnyChannel::new("pane.A", half(&|at| self.glass[at])));
        }
        let part = |shift: u32| {
            let bits = |id: &u64| (id >> shift & 0xff_ffff) as f32;
            FlatSamples::F32(self.id.iter().map(bits).collect())
        };
        let parts = [("id.low", "id24.X"), ("id.high", "id24.Y"), ("id.top", "id24.Z")];
        let needed = if self.has_wide_ids { 3 } else { 2 };
        for ((name, letter), shift) in parts[..needed].iter().zip([0, 24, 48]) {
            channels.extend([name, letter].map(|name| AnyChannel::new(*name, part(shift))));
        }
        if self.has_wide_ids {
            let high = self.id.iter().map(|id| (id >> 32) as u32).collect();
            channels.push(AnyChannel::new("id_high", FlatSamples::U32(high)));
        }
        write_channels(path, (self.width, self.height), channels)
    }

    /// Writes depth alone, as channel `Z`.
    ///
    /// # Errors
    /// [`Error::File`] if it cannot be encoded or written.
    pub fn write_depth(&self, path: &Path) -> Result<()> {
        let depth = AnyChannel::new("Z", FlatSamples::F32(self.depth.clone()));
        write_channels(path, (self.width, self.height), vec![depth])
    }
}

/// In one thread and in order, so that the same channels give the same bytes.
pub(super) fn write_channels(
    path: &Path,
    (width, height): (u32, u32),
    channels: Vec<AnyChannel<FlatSamples>>,
) -> Result<()> {
    let layer = Layer::new(
        (width as usize, height as usize),
        LayerAttributes::default(),
        Encoding::SMALL_LOSSLESS,
        AnyChannels::sort(channels.into_iter().collect()),
    );
    let mut bytes = Cursor::new(Vec::new());
    exr::prelude::Image::from_layer(layer)
        .write()
        .non_parallel()
        .to_buffered(&mut bytes)
        .map_err(|error| Error::write(path, error))?;
    write_whole(path, bytes.get_ref())
}
