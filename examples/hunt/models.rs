//! A scene drawn by the models: the picture, its time, and what was said of it.

use std::sync::Arc;
use std::time::Instant;

use raindrops::environment::Environment;
use raindrops::gpu::Device;
use raindrops::measure::resolve;
use raindrops::picture::Picture;
use raindrops::plan::{Choice, Costs, FramePlan, Output, plan_by};
use raindrops::renderer::parts::{Grid, Parts, empty_picture, place};
use raindrops::renderer::{FrameReport, Renderer};
use raindrops::scene::Scene;
use raindrops::scene::camera::WHOLE;
use raindrops::scene::model::Preset;

/// The models that are tried.
pub const PRESETS: [Preset; 3] = [Preset::Fast, Preset::Auto, Preset::Exact];

/// How many parts a picture is drawn in, across and down.
const PARTS: Grid = Grid { columns: 2, rows: 2 };

/// Where scenes are drawn.
#[derive(Clone)]
pub struct Place {
    pub device: Arc<Device>,
    /// By which `auto` chooses: assumed ones, so that its choice is the same on a busy machine.
    pub costs: Costs,
}

/// A scene by a preset, ready to be drawn.
pub struct Model<'a> {
    place: &'a Place,
    environment: &'a Environment,
    pub scene: Scene,
    pub plan: FramePlan,
    choice: Option<Choice>,
}

/// What came of it.
pub struct Drawn {
    pub picture: Picture,
    pub ms: f64,
    pub report: FrameReport,
}

impl<'a> Model<'a> {
    /// Plans a frame of the scene.
    ///
    /// # Errors
    /// See [`resolve`] and [`plan_by`].
    pub fn new(
        place: &'a Place,
        scene: &Scene,
        environment: &'a Environment,
        preset: Preset,
    ) -> raindrops::Result<Self> {
        let mut scene = scene.clone();
        scene.model.take_preset(preset);
        let choice = resolve(&place.device, &scene, environment, &place.costs)?;
        let plan = plan_by(&scene, environment, choice.as_ref(), Output::Radiance)?;
        Ok(Self { place, environment, scene, plan, choice })
    }

    /// Draws it by a new renderer; `times` frames, of which the least time counts.
    ///
    /// # Errors
    /// See [`Renderer::new`] and [`Renderer::draw`].
    pub fn draw(&self, times: u32) -> raindrops::Result<Drawn> {
        let Self { place, environment, scene, plan, .. } = self;
        let mut renderer = Renderer::new(&place.device, scene, environment, plan)?;
        let (mut ms, mut report) = (f64::INFINITY, FrameReport::default());
        for _ in 0..times {
            let since = Instant::now();
            report = renderer.draw(scene)?;
            ms = ms.min(1e3 * since.elapsed().as_secs_f64());
        }
        Ok(Drawn { picture: renderer.read_radiance()?, ms, report })
    }

    /// Draws it part by part; none of a scene that is a part itself.
    ///
    /// # Errors
    /// See [`Parts::draw_all`].
    pub fn draw_by_parts(&self) -> raindrops::Result<Option<Picture>> {
        if self.scene.camera.window != WHOLE {
            return Ok(None);
        }
        let mut whole = empty_picture(self.scene.image);
        let mut parts = Parts::new(&self.place.device, self.environment, &self.plan);
        parts.draw_all(&self.scene, PARTS, &mut |origin, renderer, _| {
            let part = renderer.read_radiance()?;
            place(&mut whole.pixels, whole.width, origin, &part.pixels, part.width);
            Ok(())
        })?;
        Ok(Some(whole))
    }

    /// The models in a line.
    pub fn summary(&self) -> String {
        let FramePlan { optics, samples, light, motion, lens, .. } = &self.plan;
        let rays = format!("{optics}, {samples} a pixel, {} internal", light.internal_reflections);
        let chosen =
            self.choice.as_ref().map_or(String::new(), |choice| format!("; {}", choice.reason));
        format!("{rays}, motion {motion}, lens {lens}{chosen}")
    }

    /// What the command would warn of.
    pub fn warnings(&self, report: &FrameReport) -> Vec<String> {
        let counts = &report.counts;
        let of_count = |count: u64, what: &str| (count > 0).then(|| format!("{count} {what}"));
        let all = [
            self.plan.doubt.clone(),
            self.plan.overlap.clone(),
            of_count(counts.overflow, "drops not drawn, or out of order"),
            of_count(counts.camera_inside, "drops not drawn: the camera is inside"),
            of_count(counts.beside_camera, "drops not drawn: they reach beside the camera"),
        ];
        all.into_iter().flatten().collect()
    }
}

/// Pixels in which two pictures differ by a bit.
pub fn differing(a: &Picture, b: &Picture) -> u32 {
    let bits = |picture: &Picture| -> Vec<[u32; 3]> {
        picture.pixels.iter().map(|pixel| pixel.to_array().map(f32::to_bits)).collect()
    };
    if (a.width, a.height) != (b.width, b.height) {
        return u32::MAX;
    }
    bits(a).iter().zip(bits(b)).filter(|(a, b)| **a != *b).count() as u32
}
