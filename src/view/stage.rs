//! What is drawn in the window: one renderer, or one for each side of the split view.
//!
//! A renderer is fixed in size, drops and models. When these change it is made anew, and the one
//! before stays on show until the new one stands; where a wish cannot be granted (models that do not
//! go together, memory) it stays for good, and the reason is told.

use std::sync::Arc;

use crate::Result;
use crate::environment::Environment;
use crate::gpu::{Device, Image};
use crate::picture::flip::{PIXELS_PER_DEGREE, flip};
use crate::picture::{Picture, linear_of_srgb};
use crate::plan::{FramePlan, Output, plan};
use crate::renderer::{FrameReport, Renderer};
use crate::scene::camera::Camera;
use crate::scene::{EnvironmentChoice, ImageSize, ModelChoice, Scene};

/// A renderer, its plan, and what its last finished frame told.
pub struct Pane {
    /// Models and passes.
    pub plan: FramePlan,
    /// Of the last finished frame.
    pub report: FrameReport,
    renderer: Renderer,
}

/// The renderers of the window.
pub struct Stage {
    device: Arc<Device>,
    environment: Environment,
    environment_of: EnvironmentChoice,
    panes: Vec<Pane>,
    /// What the panes were last asked to be made for, granted or not.
    made_for: Vec<Scene>,
    /// What they last drew.
    drawn: Vec<Scene>,
    /// Why the last wish could not be granted.
    pub problem: Option<String>,
}

/// What the split view's models differ by.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Difference {
    /// Mean FLIP of the first against the second, 0 to 1.
    pub flip: f64,
    /// Largest difference of a display value, of 255.
    pub largest: u8,
}

impl Stage {
    /// A stage for `scene`, with its environment.
    pub fn new(device: &Arc<Device>, scene: &Scene) -> Result<Self> {
        Ok(Self {
            device: device.clone(),
            environment: Environment::open(&scene.environment)?,
            environment_of: scene.environment.clone(),
            panes: Vec::new(),
            made_for: Vec::new(),
            drawn: Vec::new(),
            problem: None,
        })
    }

    /// Draws `scene` at a size in pixels, with the second model beside it if there is one. True if
    /// the pictures are others than before: renderers were made anew.
    ///
    /// # Errors
    /// Only those after which nothing can go on, and the first scene's.
    pub fn draw(
        &mut self,
        scene: &Scene,
        second: Option<ModelChoice>,
        size: (u32, u32),
    ) -> Result<bool> {
        let panes = if second.is_some() { crate::passes::present::SPLIT_PANES } else { 1 };
        let image = ImageSize { width: size.0.div_ceil(panes), height: size.1 };
        let first = Scene { image, ..scene.clone() };
        let second = second.map(|model| Scene { model, ..first.clone() });
        let mut scenes: Vec<Scene> = [Some(first), second].into_iter().flatten().collect();

        let fixed: Vec<Scene> = scenes.iter().map(fixed_part).collect();
        let is_new = fixed != self.made_for || self.panes.is_empty();
        if is_new {
            self.made_for = fixed;
            match self.make(&scenes) {
                Ok(panes) => {
                    self.panes = panes;
                    self.drawn.clear();
                    self.problem = None;
                }
                Err(error) if self.panes.is_empty() || error.is_lost() => return Err(error),
                Err(error) => self.problem = Some(error.to_string()),
            }
        }
        if self.problem.is_some() {
            // What is on show goes on, where the camera and the clock are now.
            scenes = self.drawn.iter().map(|old| moved(old, scene)).collect();
        }
        if scenes != self.drawn {
            for (pane, scene) in self.panes.iter_mut().zip(&scenes) {
                if let Some(report) = pane.renderer.submit(scene)? {
                    pane.report = report;
                }
            }
            self.drawn = scenes;
        }
        Ok(is_new && self.problem.is_none())
    }

    /// Opens the environment that the scenes to come have. Where that cannot be, the one before stays.
    pub fn open_environment(&mut self, choice: &EnvironmentChoice) -> Result<()> {
        if *choice != self.environment_of {
            self.environment = Environment::open(choice)?;
            self.environment_of = choice.clone();
        }
        Ok(())
    }

    fn make(&self, scenes: &[Scene]) -> Result<Vec<Pane>> {
        let pane = |scene: &Scene| {
            scene.validate("the window")?;
            let plan = plan(scene, &self.environment, Output::Display)?;
            let renderer = Renderer::new(&self.device, scene, &self.environment, &plan)?;
            Ok(Pane { plan, report: FrameReport::default(), renderer })
        };
        scenes.iter().map(pane).collect()
    }

    /// Goes on with another device in place of one that is lost: what is on show is made anew, whatever
    /// was wished for since.
    pub fn renew(&mut self, device: &Arc<Device>) -> Result<()> {
        // Freed before as much is asked for again.
        self.panes.clear();
        self.device = device.clone();
        self.panes = self.make(&self.drawn)?;
        for (pane, scene) in self.panes.iter_mut().zip(&self.drawn) {
            pane.renderer.submit(scene)?;
        }
        Ok(())
    }

    /// Makes everything anew when it is next drawn, as after a change of shaders.
    pub fn invalidate(&mut self) {
        self.made_for.clear();
    }

    /// Waits for the frames under way, so that the reports are those of what is on show.
    pub fn finish(&mut self) -> Result<()> {
        for pane in &mut self.panes {
            pane.report = pane.renderer.finish()?;
        }
        Ok(())
    }

    /// The renderers: one, or two side by side.
    pub fn panes(&self) -> &[Pane] {
        &self.panes
    }

    /// The pictures on show.
    pub fn pictures(&self) -> Vec<&Image> {
        self.panes.iter().filter_map(|pane| pane.renderer.display()).collect()
    }

    /// Which environment there is.
    pub fn environment_choice(&self) -> &EnvironmentChoice {
        &self.environment_of
    }

    /// The environment's name.
    pub fn environment_name(&self) -> &str {
        self.environment.name()
    }

    /// How the pictures of the split view differ; none without it.
    pub fn difference(&self) -> Result<Option<Difference>> {
        let [first, second] = self.panes.as_slice() else { return Ok(None) };
        let [a, b] = [first.renderer.read_display()?, second.renderer.read_display()?];
        let size = self.drawn[0].image;
        let linear = |byte: u8| linear_of_srgb(f32::from(byte) / 255.0);
        let picture = |bytes: &[u8]| Picture {
            width: size.width,
            height: size.height,
            pixels: bytes.chunks_exact(3).map(|p| [p[0], p[1], p[2]].map(linear).into()).collect(),
        };
        let errors = flip(&picture(&b), &picture(&a), PIXELS_PER_DEGREE);
        let flip = errors.iter().sum::<f64>() / errors.len() as f64;
        let largest = a.iter().zip(&b).map(|(a, b)| a.abs_diff(*b)).max().unwrap_or(0);
        Ok(Some(Difference { flip, largest }))
    }
}

/// The scene without what a renderer takes anew with every frame.
fn fixed_part(scene: &Scene) -> Scene {
    let mut other = Scene { camera: Camera::default(), time: 0.0, ..Scene::default() };
    other.tone_map.exposure = Some(1.0);
    moved(scene, &other)
}

/// `scene` with the camera, the time, the key and, if both have one, the fixed exposure of another.
fn moved(scene: &Scene, other: &Scene) -> Scene {
    let mut moved = Scene { camera: other.camera, time: other.time, ..scene.clone() };
    moved.tone_map.key = other.tone_map.key;
    moved.tone_map.exposure = scene.tone_map.exposure.and(other.tone_map.exposure);
    moved
}
