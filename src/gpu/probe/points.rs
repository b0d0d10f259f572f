//! Points: how large they may be, whether one whose centre is off the viewport is drawn, and how
//! exactly they are placed and sized.

use std::sync::Arc;

use ash::vk;
use glam::Vec2;
use serde::Serialize;

use super::canvas::Canvas;
use crate::Result;
use crate::gpu::sets::probe_point as slot;
use crate::gpu::{
    Bindings, Buffer, Device, GraphicsPipeline, GraphicsState, Memory, PointRules, Resource,
    shaders,
};

/// Colour format of the marks.
const FORMAT: vk::Format = vk::Format::R32G32B32A32_SFLOAT;
/// Most points of one drawing.
const MOST: usize = 160;
/// A point that is off by this, in its coordinates or at its edge, is not drawn at its size.
const OFF_PX: f32 = 0.25;

/// A part of the canvas.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Cell {
    /// Left and upper edge, width and height, in pixels.
    pub at: [u32; 4],
}

/// A point and the only part of the canvas that it may be seen in, which is also its viewport.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Shot {
    /// Where it may be seen.
    pub cell: Cell,
    /// Its centre, in pixels from the cell's upper left corner.
    pub center: Vec2,
    /// Its diameter in pixels.
    pub size: f32,
}

/// What a pixel of a cell shows: its place in the point, (0, 0) to (1, 1) from the upper left; none
/// where the point is not.
pub type Mark = Option<Vec2>;

impl Shot {
    /// Largest error of the marks, in pixels: of the point coordinates, and infinite where a pixel
    /// whose middle is well inside is missing, or one well outside is there.
    pub fn error_px(&self, marks: &[Mark]) -> f32 {
        let [.., width, _] = self.cell.at;
        let error = |(index, mark): (usize, &Mark)| {
            let index = index as u32;
            let middle = Vec2::new((index % width) as f32, (index / width) as f32) + 0.5;
            let from = middle - self.center;
            let beyond = from.abs().max_element() - 0.5 * self.size;
            match mark {
                Some(at) if beyond < OFF_PX => ((*at - 0.5) * self.size - from).abs().max_element(),
                None if beyond > -OFF_PX => 0.0,
                _ => f32::INFINITY,
            }
        };
        marks.iter().enumerate().map(error).fold(0.0, f32::max)
    }
}

/// Draws points.
struct Shooter<'a> {
    device: &'a Arc<Device>,
    points: Buffer,
    bindings: Bindings,
    pipeline: GraphicsPipeline,
}

impl<'a> Shooter<'a> {
    fn new(device: &'a Arc<Device>) -> Result<Self> {
        let usage = vk::BufferUsageFlags::STORAGE_BUFFER;
        let points = Buffer::new(device, "probe", 16 * MOST as u64, usage, Memory::Upload)?;
        let slots = [(slot::POINTS, Resource::Buffer(&points))];
        let bindings = Bindings::of(device, "probe points", &slots)?;
        let stages = [shaders::PROBE_POINT_VERT, shaders::PROBE_POINT_FRAG];
        let topology = vk::PrimitiveTopology::POINT_LIST;
        let state = GraphicsState { topology, ..GraphicsState::triangles(FORMAT) };
        let pipeline = GraphicsPipeline::new(device, stages, &bindings, 0, &[], &state)?;
        Ok(Self { device, points, bindings, pipeline })
    }

    /// The marks of each shot, row by row of its cell.
    fn shoot(&mut self, shots: &[Shot]) -> Result<Vec<Vec<Mark>>> {
        let records: Vec<[f32; 4]> = shots
            .iter()
            .map(|shot| {
                let [.., width, height] = shot.cell.at.map(|edge| edge as f32);
                let place = 2.0 * shot.center / Vec2::new(width, height) - 1.0;
                [place.x, place.y, shot.size, 0.0]
            })
            .collect();
        self.points.write(0, &records);
        let far = |axis: usize| {
            shots.iter().map(|shot| shot.cell.at[axis] + shot.cell.at[axis + 2]).max().unwrap_or(1)
        };
        let canvas = Canvas::new(self.device, (far(0), far(1)), FORMAT)?;
        let raw = self.device.raw();
        let pixels: Vec<[f32; 4]> = canvas.draw(|commands| {
            self.pipeline.bind(commands, &self.bindings, &[]);
            for (number, shot) in (0..).zip(shots) {
                let [x, y, width, height] = shot.cell.at;
                let scissor = vk::Rect2D {
                    offset: vk::Offset2D { x: x as i32, y: y as i32 },
                    extent: vk::Extent2D { width, height },
                };
                let [x, y, width, height] = shot.cell.at.map(|edge| edge as f32);
                let (min_depth, max_depth) = (0.0, 1.0);
                let viewport = vk::Viewport { x, y, width, height, min_depth, max_depth };
                // SAFETY: within a rendering, with everything bound.
                unsafe {
                    raw.cmd_set_viewport(commands.raw(), 0, &[viewport]);
                    raw.cmd_set_scissor(commands.raw(), 0, &[scissor]);
                    raw.cmd_draw(commands.raw(), 1, 1, number, 0);
                }
            }
        })?;
        let mark = |pixel: [f32; 4]| (pixel[2] > 0.5).then(|| Vec2::new(pixel[0], pixel[1]));
        Ok(shots
            .iter()
            .map(|shot| {
                let [left, top, width, height] = shot.cell.at;
                let row = |y| (left..left + width).map(move |x| (y * far(0) + x) as usize);
                (top..top + height).flat_map(row).map(|index| mark(pixels[index])).collect()
            })
            .collect())
    }
}

/// Pixels of a row of [`limit_shots`] that a point leaves.
const BESIDE_PX: u32 = 16;

/// Rows through points of falling sizes, the claimed limit first.
pub fn limit_shots(claimed: f32) -> Vec<Shot> {
    let width = claimed.ceil() as u32 + BESIDE_PX;
    [claimed, claimed.floor(), 0.75 * claimed, 0.5 * claimed, 0.25 * claimed, 64.0, 16.0, 1.0]
        .into_iter()
        .filter(|size| *size <= claimed)
        .zip(0..)
        .map(|(size, row)| {
            let cell = Cell { at: [0, row, width, 1] };
            Shot { cell, center: Vec2::new(0.5 * width as f32 + 0.3, 0.5), size }
        })
        .collect()
}

/// Points that reach into their cells from every side and a corner, their centres outside.
pub fn off_screen_shots(limit: f32) -> Vec<Shot> {
    let size = limit.min(16.0);
    let out = -0.25 * size;
    let cell = |number: u32| Cell { at: [16 * number, 0, 16, 16] };
    [(out, 8.0), (16.0 - out, 8.0), (8.0, out), (8.0, 16.0 - out), (out, out)]
        .into_iter()
        .zip(0..)
        .map(|((x, y), number)| Shot { cell: cell(number), center: Vec2::new(x, y), size })
        .collect()
}

/// The largest size that the marks of [`limit_shots`] show to be drawn as asked; 0: none.
pub fn limit_of(shots: &[Shot], marks: &[Vec<Mark>]) -> f32 {
    let is_sound = |(shot, marks): &(&Shot, &Vec<Mark>)| shot.error_px(marks) < OFF_PX;
    shots.iter().zip(marks).find(is_sound).map_or(0.0, |(shot, _)| shot.size)
}

/// Finds what the renderer must know.
pub(super) fn rules(device: &Arc<Device>) -> Result<PointRules> {
    let mut shooter = Shooter::new(device)?;
    let limits = &device.report.limits;
    // A device may claim larger points than an image holds.
    let widest = limits.max_image_dimension2_d.saturating_sub(BESIDE_PX);
    let shots = limit_shots(limits.point_size_range[1].min(widest as f32));
    let limit_px = limit_of(&shots, &shooter.shoot(&shots)?);
    let shots = off_screen_shots(limit_px);
    let marks = shooter.shoot(&shots)?;
    let draws = |(shot, marks): (&Shot, &Vec<Mark>)| shot.error_px(marks) < OFF_PX;
    Ok(PointRules { limit_px, draws_off_screen: shots.iter().zip(&marks).all(draws) })
}

/// What a device does with points, and what it says that it does.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Points {
    /// Least and largest size, as claimed.
    pub claimed_px: [f32; 2],
    /// Largest that is drawn at its size.
    pub limit_px: f32,
    /// Width in pixels of a point that was asked to be 64 px larger than the claimed limit.
    pub beyond_limit_px: u32,
    /// Whether a point whose centre is off the viewport is drawn …
    pub draws_off_screen: bool,
    /// … and whether the device says so.
    pub claims_to_draw_off_screen: bool,
    /// Pixels of a point of 0.3 px, least and most over 64 places in a pixel.
    pub sub_pixel: [u32; 2],
    /// Largest error of a point coordinate over points of 1 to 16 px, in pixels.
    pub coordinate_error_px: f32,
    /// Distinct places of a point moved by 1/16 px in 128 steps.
    pub places_a_sixteenth: u32,
    /// Distinct sizes of points of 8 to 9 px in 64 steps, by their coordinates.
    pub sizes_a_pixel: u32,
}

impl Points {
    /// Probes a device.
    pub(super) fn of(device: &Arc<Device>) -> Result<Self> {
        let rules = super::point_rules(device)?;
        let mut shooter = Shooter::new(device)?;
        let limits = &device.report.limits;
        let claimed_px = limits.point_size_range;
        let wide = (claimed_px[1].ceil() as u32 + 96).min(limits.max_image_dimension2_d);
        let cell = Cell { at: [0, 0, wide, 1] };
        let center = Vec2::new(0.5 * wide as f32, 0.5);
        let shot = Shot { cell, center, size: claimed_px[1] + 64.0 };
        let beyond = shooter.shoot(&[shot])?[0].iter().flatten().count();

        // Cells in one row, a pixel or several around each point.
        let in_row = |edge: u32, number: u32| Cell { at: [edge * number, 0, edge, edge] };
        let shots: Vec<_> = (0..64)
            .map(|number| {
                let place = Vec2::new((number % 8) as f32, (number / 8) as f32) / 8.0 + 0.0625;
                Shot { cell: in_row(4, number), center: 1.0 + place, size: 0.3 }
            })
            .collect();
        let counts = shooter.shoot(&shots)?;
        let counts = counts.iter().map(|marks| marks.iter().flatten().count() as u32);
        let sub_pixel = [counts.clone().min().unwrap_or(0), counts.max().unwrap_or(0)];

        let shots: Vec<_> = (0..60)
            .map(|number| {
                let place = Vec2::new(0.37, 0.71) * number as f32;
                let size = 1.0 + 0.25 * number as f32;
                Shot { cell: in_row(24, number), center: 11.0 + place.fract(), size }
            })
            .collect();
        let marks = shooter.shoot(&shots)?;
        let coordinate_error_px =
            shots.iter().zip(&marks).map(|(shot, marks)| shot.error_px(marks)).fold(0.0, f32::max);

        let middle = |marks: &Vec<Mark>| marks[8 * 16 + 8].map_or(0.0, |at| at.x);
        let shots: Vec<_> = (0..128)
            .map(|number| {
                let center = Vec2::new(8.3 + number as f32 / 2048.0, 8.5);
                Shot { cell: in_row(16, number), center, size: 8.0 }
            })
            .collect();
        let places = distinct(shooter.shoot(&shots)?.iter().map(middle));
        let shots: Vec<_> = (0..64)
            .map(|number| {
                let size = 8.0 + number as f32 / 64.0;
                Shot { cell: in_row(16, number), center: Vec2::new(8.25, 8.25), size }
            })
            .collect();
        let size = |marks: &Vec<Mark>| {
            let at = |x: usize| marks[8 * 16 + x].map_or(0.0, |at| at.x);
            at(11) - at(5)
        };
        let sizes = distinct(shooter.shoot(&shots)?.iter().map(size));
        Ok(Self {
            claimed_px,
            limit_px: rules.limit_px,
            beyond_limit_px: beyond as u32,
            draws_off_screen: rules.draws_off_screen,
            claims_to_draw_off_screen: !device.report.claims_to_clip_points,
            sub_pixel,
            coordinate_error_px,
            places_a_sixteenth: places,
            sizes_a_pixel: sizes,
        })
    }
}

/// How many values differ from the one before by more than rounding.
fn distinct(values: impl Iterator<Item = f32>) -> u32 {
    let values: Vec<f32> = values.collect();
    1 + values.windows(2).filter(|pair| (pair[1] - pair[0]).abs() > 1e-5).count() as u32
}
