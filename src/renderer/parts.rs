//! A picture drawn part by part, by off-centre projection: equal to the whole to the byte (of tiles), and as large as no
//! image of the device need be.
//!
//! An exposure that is derived is the whole's: first every part's sums of log luminance are found, then each part is
//! drawn with the sums of all of them, added up in the order in which the whole's would be.
//!
//! Lists of tiles grow with what is on the tiles, up to what the device binds at once. A part that needs more is drawn in
//! four parts of its own, so that nothing is lost in pictures of any size.

use std::sync::Arc;

use super::{FrameReport, Lighting, RainField, Renderer, background_of, lattice_of, refuse};
use crate::environment::Environment;
use crate::gpu::Device;
use crate::passes::background::{BackgroundImages, most_stored};
use crate::passes::tile_grid::{self, TILE};
use crate::passes::tone_map::final_sums;
use crate::picture::Picture;
use crate::picture::layers::Layers;
pub use crate::picture::place;
use crate::picture::plate::Plate;
use crate::plan::FramePlan;
use crate::scene::camera::WHOLE;
use crate::scene::model::{Primitive, Simulation};
use crate::scene::{self, ImageSize, Scene};
use crate::{Error, Result};

/// Edges of parts are multiples of this many pixels, so that no tile is in two of them.
const STEP: u32 = 8;

/// The parts of a picture that the device has no room for at once.
pub const HALVES: Grid = Grid { columns: 2, rows: 2 };

/// A number of parts across and down.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Grid {
    /// Parts across.
    pub columns: u32,
    /// Parts down.
    pub rows: u32,
}

impl Grid {
    /// The windows of the parts of a whole picture, row by row.
    ///
    /// # Errors
    /// [`Error::Scene`] if a part would be smaller than 8 x 8 pixels.
    pub fn windows(self, image: ImageSize) -> Result<Vec<[f64; 4]>> {
        if self.columns > image.width.div_ceil(STEP) || self.rows > image.height.div_ceil(STEP) {
            let Self { columns, rows } = self;
            let ImageSize { width, height } = image;
            let problem = format!(
                "{columns} x {rows} parts of {width} x {height} pixels are under {STEP} pixels"
            );
            return Err(Error::scene("tiles", problem));
        }
        let edge = |number: u32, parts: u32, pixels: u32| {
            let steps = u64::from(pixels.div_ceil(STEP)) * u64::from(number) / u64::from(parts);
            f64::from((steps as u32 * STEP).min(pixels)) / f64::from(pixels)
        };
        let across = |number| edge(number, self.columns, image.width);
        let down = |number| edge(number, self.rows, image.height);
        let columns = 0..self.columns;
        Ok((0..self.rows)
            .flat_map(|row| columns.clone().map(move |column| (column, row)))
            .map(|(column, row)| [across(column), down(row), across(column + 1), down(row + 1)])
            .collect())
    }

    /// Parts of about the size of a window, but not under 8 pixels.
    fn like(window: [f64; 4], image: ImageSize) -> Self {
        let number = |low: f64, high: f64, pixels: u32| {
            ((1.0 / (high - low)).round() as u32).clamp(1, pixels.div_ceil(STEP))
        };
        Self {
            columns: number(window[0], window[2], image.width),
            rows: number(window[1], window[3], image.height),
        }
    }
}

/// Four parts of a window, or two; none of one that is a step wide and high.
fn parts_of([left, top, right, bottom]: [f64; 4], image: ImageSize) -> Option<Vec<[f64; 4]>> {
    let halves = |from: f64, to: f64, pixels: u32| {
        let pixels = f64::from(pixels);
        let step = f64::from(STEP);
        let middle = (0.5 * (from + to) * pixels / step).round() * step / pixels;
        match from < middle && middle < to {
            true => vec![[from, middle], [middle, to]],
            false => vec![[from, to]],
        }
    };
    let columns = halves(left, right, image.width);
    let parts: Vec<_> = halves(top, bottom, image.height)
        .into_iter()
        .flat_map(|[top, bottom]| {
            columns.iter().map(move |[left, right]| [*left, top, *right, bottom])
        })
        .collect();
    (parts.len() > 1).then_some(parts)
}

/// Draws parts of pictures, all by one plan.
pub struct Parts<'a> {
    device: &'a Arc<Device>,
    environment: &'a Environment,
    plan: &'a FramePlan,
    /// What parts of all sizes show.
    shown: Option<(Arc<Lighting>, Arc<RainField>)>,
    /// What is behind the drops in place of the scenes' files.
    plate: Option<&'a Plate>,
    /// What is behind the drops, and of which scene's files.
    background: Option<(scene::background::Background, Option<Arc<BackgroundImages>>)>,
    /// Where motion ends, of a plan for layers.
    until: Option<Scene>,
    /// That of the last part, and what it is made for: the picture's size and its place among the tiles.
    renderer: Option<(PartSize, Renderer)>,
}

/// Called with the place of a part's first pixel, a renderer that has drawn it, and its report.
pub type Take<'t> = dyn FnMut([u32; 2], &Renderer, FrameReport) -> Result<()> + 't;

type PartSize = ((u32, u32), [u32; 2]);

impl<'a> Parts<'a> {
    /// Draws nothing yet.
    pub fn new(device: &'a Arc<Device>, environment: &'a Environment, plan: &'a FramePlan) -> Self {
        Self {
            device,
            environment,
            plan,
            shown: None,
            plate: None,
            background: None,
            until: None,
            renderer: None,
        }
    }

    /// This picture with light and rain that other pictures show too; the rain is made again for a scene of other drops.
    pub fn showing(self, lighting: &Arc<Lighting>, rain: &Arc<RainField>) -> Self {
        Self { shown: Some((lighting.clone(), rain.clone())), ..self }
    }

    /// This picture with what is behind the drops from memory, in place of the files that scenes name. It has the size of their
    /// pictures.
    pub fn before(self, plate: &'a Plate) -> Self {
        Self { plate: Some(plate), ..self }
    }

    /// Draws the picture of `scene`, whose window is the whole, by the parts of `grid`; `take` is called with the place
    /// of each part's first pixel, a renderer that has drawn it, and its report. Parts that lack room are parted further.
    ///
    /// # Errors
    /// [`Error::Scene`] if the scene has a window of its own, or if the plan's positions come from the frame before;
    /// those of [`Grid::windows`], [`Renderer::new`], [`Renderer::submit`], and of `take`.
    pub fn draw_all(&mut self, scene: &Scene, grid: Grid, take: &mut Take<'_>) -> Result<()> {
        let refuse = |problem: &str| Err(Error::scene("tiles", problem));
        if scene.camera.window != WHOLE {
            return refuse("camera.window is a part already; leave out one of the two");
        }
        if self.plan.simulation == Simulation::Stored {
            return refuse("stored positions go on with every part; take simulation integer");
        }
        let mut windows = grid.windows(scene.image)?;
        let exposure = self.exposure(scene, &mut windows)?;
        windows.reverse();
        while let Some(window) = windows.pop() {
            let part = part(scene, window);
            let (renderer, report) = self.draw(&part, exposure.as_ref())?;
            match parts_of(window, scene.image) {
                Some(parts) if report.lacks_room() => windows.extend(parts.into_iter().rev()),
                _ => take(part.view().origin, renderer, report)?,
            }
        }
        Ok(())
    }

    /// From now on motion is that to `until`, which differs from what is drawn in camera and time alone.
    pub fn move_until(&mut self, until: Scene) {
        self.until = Some(until);
    }

    /// The radiance that what is behind the drops is clipped to, if it is brighter; known once something is drawn.
    pub fn clips_background(&self) -> Option<f32> {
        let brightest = self.background.as_ref()?.1.as_ref()?.brightest;
        let (_, renderer) = self.renderer.as_ref()?;
        let most = most_stored(renderer.view.surroundings.radiance_scale);
        (brightest > most).then_some(most)
    }

    /// Draws the window of `scene`, exposed as the whole.
    ///
    /// # Errors
    /// Like [`Parts::draw_all`].
    pub fn draw_window(&mut self, scene: &Scene) -> Result<(&Renderer, FrameReport)> {
        let exposure = if scene.camera.window == WHOLE {
            None
        } else {
            let grid = Grid::like(scene.camera.window, scene.image);
            self.exposure(scene, &mut grid.windows(scene.image)?)?
        };
        let (renderer, report) = self.draw(scene, exposure.as_ref())?;
        Ok((renderer, report))
    }

    /// What is read of `scene` drawn at once, or, if the device has no room for all of it at once, `by` parts.
    fn whole_or_by<T>(
        &mut self,
        scene: &Scene,
        read: fn(&Renderer) -> Result<T>,
        by: fn(&mut Self, &Scene, Grid) -> Result<(T, FrameReport)>,
    ) -> Result<(T, FrameReport)> {
        let (renderer, report) = self.draw_window(scene)?;
        if !report.lacks_room() {
            return Ok((read(renderer)?, report));
        }
        match self.can_part(scene) {
            true => by(self, scene, HALVES),
            false => Ok((read(self.last()?)?, report)),
        }
    }

    /// Linear radiance of `scene`, drawn at once, or in parts if the device has no room for all of it at once.
    ///
    /// # Errors
    /// Like [`Parts::draw_all`].
    pub fn radiance(&mut self, scene: &Scene) -> Result<(Picture, FrameReport)> {
        self.whole_or_by(scene, Renderer::read_radiance, Self::radiance_by)
    }

    /// Like [`Parts::radiance`], of a plan for layers.
    ///
    /// # Errors
    /// Like [`Parts::draw_all`].
    pub fn layers(&mut self, scene: &Scene) -> Result<(Layers, FrameReport)> {
        self.whole_or_by(scene, Renderer::read_layers, Self::layers_by)
    }

    /// Linear radiance, drawn part by part.
    ///
    /// # Errors
    /// Like [`Parts::draw_all`].
    pub fn radiance_by(&mut self, scene: &Scene, grid: Grid) -> Result<(Picture, FrameReport)> {
        let mut whole = empty_picture(scene.image);
        let report = self.draw_by(scene, grid, &mut |origin, renderer| {
            let part = renderer.read_radiance()?;
            place(&mut whole.pixels, whole.width, origin, &part.pixels, part.width);
            Ok(())
        })?;
        Ok((whole, report))
    }

    /// Layers, drawn part by part.
    ///
    /// # Errors
    /// Like [`Parts::draw_all`].
    pub fn layers_by(&mut self, scene: &Scene, grid: Grid) -> Result<(Layers, FrameReport)> {
        let mut whole = Layers::empty(scene.image.width, scene.image.height);
        let report = self.draw_by(scene, grid, &mut |origin, renderer| {
            whole.place(origin, &renderer.read_layers()?);
            Ok(())
        })?;
        Ok((whole, report))
    }

    /// Like [`Parts::radiance`], of a plan for display: sRGB bytes.
    ///
    /// # Errors
    /// Like [`Parts::draw_all`].
    pub fn display(&mut self, scene: &Scene) -> Result<(Vec<u8>, FrameReport)> {
        self.whole_or_by(scene, Renderer::read_display, Self::display_by)
    }

    /// sRGB bytes, drawn part by part.
    ///
    /// # Errors
    /// Like [`Parts::draw_all`].
    pub fn display_by(&mut self, scene: &Scene, grid: Grid) -> Result<(Vec<u8>, FrameReport)> {
        let ImageSize { width, height } = scene.image;
        let mut shown = vec![[0_u8; 3]; width as usize * height as usize];
        let report = self.draw_by(scene, grid, &mut |origin, renderer| {
            let bytes = renderer.read_display()?;
            let pixels: &[[u8; 3]] = bytemuck::cast_slice(&bytes);
            place(&mut shown, width, origin, pixels, renderer.size().0);
            Ok(())
        })?;
        Ok((shown.into_flattened(), report))
    }

    /// Draws part by part; `take` is called with the place of each part's first pixel and a renderer that has drawn it. The
    /// report is of all of them.
    ///
    /// # Errors
    /// Like [`Parts::draw_all`].
    pub fn draw_by(
        &mut self,
        scene: &Scene,
        grid: Grid,
        take: &mut dyn FnMut([u32; 2], &Renderer) -> Result<()>,
    ) -> Result<FrameReport> {
        let mut all = FrameReport::default();
        self.draw_all(scene, grid, &mut |origin, renderer, report| {
            all.counts.add(&report.counts);
            all.cutoff_px = report.cutoff_px;
            all.room = all.room.max(report.room);
            take(origin, renderer)
        })?;
        Ok(all)
    }

    /// Whether [`Parts::draw_all`] takes the scene, in parts of 2 x 2.
    pub fn can_part(&self, scene: &Scene) -> bool {
        let ImageSize { width, height } = scene.image;
        let is_stored = self.plan.simulation == Simulation::Stored;
        scene.camera.window == WHOLE && !is_stored && width.min(height) > STEP
    }

    /// The renderer of the last part.
    fn last(&self) -> Result<&Renderer> {
        match &self.renderer {
            Some((_, renderer)) => Ok(renderer),
            None => refuse("nothing is drawn yet"),
        }
    }

    /// The sums of log luminance of the whole picture, in the whole's order, if an exposure is to be derived. Windows that lack
    /// room become several.
    fn exposure(&mut self, scene: &Scene, windows: &mut Vec<[f64; 4]>) -> Result<Option<Vec<f32>>> {
        if !self.plan.log_average {
            return Ok(None);
        }
        let tiles_of = |size: u32, edge: u32| size.div_ceil(edge) as usize;
        let whole_across = tiles_of(scene.image.width, TILE.0);
        let mut sums = match self.plan.primitive {
            Primitive::Tile => vec![0.0; whole_across * tiles_of(scene.image.height, TILE.1)],
            _ => Vec::new(),
        };
        let mut left: Vec<_> = windows.drain(..).rev().collect();
        while let Some(window) = left.pop() {
            let part = part(scene, window);
            let view = part.view();
            let (renderer, report) = self.draw(&part, None)?;
            if let (true, Some(parts)) = (report.lacks_room(), parts_of(window, scene.image)) {
                left.extend(parts.into_iter().rev());
                continue;
            }
            windows.push(window);
            let found = renderer.read_log_sums()?;
            if self.plan.primitive != Primitive::Tile {
                sums.extend(found);
                continue;
            }
            // The part draws no pixel of the tiles around its own: they add 0.
            let (first, end) = tile_grid::of_view(&view);
            let [column, row] = first.map(|tile| tile as usize);
            for (number, found) in found.chunks_exact((end[0] - first[0]) as usize).enumerate() {
                let at = (row + number) * whole_across + column;
                sums[at..at + found.len()].iter_mut().zip(found).for_each(|(sum, log)| *sum += log);
            }
        }
        Ok(Some(sums))
    }

    /// Makes the renderer that draws the window of `scene`, so that its first picture need not wait for it.
    ///
    /// # Errors
    /// See [`Renderer::new`].
    pub fn prepare(&mut self, scene: &Scene) -> Result<()> {
        let made = self.take_renderer(scene)?;
        self.renderer = Some(made);
        Ok(())
    }

    fn take_renderer(&mut self, scene: &Scene) -> Result<(PartSize, Renderer)> {
        let size = (scene.picture_size(), lattice_of(scene));
        // One at a time: two might not fit beside each other.
        let kept = self.renderer.take();
        let kept = kept.filter(|(kept, of)| *kept == size && of.rain().is_of(scene));
        if let Some(kept) = kept {
            return Ok(kept);
        }
        if self.shown.as_ref().is_none_or(|(_, rain)| !rain.is_of(scene)) {
            let lighting = match self.shown.take() {
                Some((lighting, _)) => lighting,
                None => Arc::new(Lighting::new(self.device, self.environment)?),
            };
            self.shown = Some((lighting, Arc::new(RainField::new(self.device, scene))));
        }
        if self.background.as_ref().is_none_or(|(of, _)| *of != scene.background) {
            let images = match self.plate {
                Some(plate) => {
                    let size = (scene.image.width, scene.image.height);
                    Some(Arc::new(BackgroundImages::of_plate(self.device, plate, size)?))
                }
                _ => background_of(self.device, scene)?,
            };
            self.background = Some((scene.background.clone(), images));
        }
        let (lighting, rain) = self.shown.as_ref().expect("just made");
        let (_, background) = self.background.as_ref().expect("just read");
        Ok((size, Renderer::before(lighting, rain, background.as_ref(), scene, self.plan)?))
    }

    fn draw(
        &mut self,
        scene: &Scene,
        exposure: Option<&Vec<f32>>,
    ) -> Result<(&Renderer, FrameReport)> {
        let (size, mut renderer) = self.take_renderer(scene)?;
        let pixels = scene.image.width as f32 * scene.image.height as f32;
        renderer.whole_sums =
            exposure.map(|sums| (final_sums(sums, self.device.report.machine), pixels));
        let report = match &self.until {
            Some(until) => {
                let mut until = until.clone();
                until.camera.window = scene.camera.window;
                renderer.draw_until(scene, &until)?
            }
            None => renderer.draw(scene)?,
        };
        let (_, renderer) = self.renderer.insert((size, renderer));
        Ok((renderer, report))
    }
}

/// The scene with another window.
fn part(scene: &Scene, window: [f64; 4]) -> Scene {
    let mut part = scene.clone();
    part.camera.window = window;
    part
}

/// A picture of this size to put parts into.
pub fn empty_picture(image: ImageSize) -> Picture {
    let ImageSize { width, height } = image;
    let pixels = vec![glam::Vec3::ZERO; width as usize * height as usize];
    Picture { width, height, pixels }
}
