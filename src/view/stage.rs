//! What is drawn in the window: one renderer, or one for each side of the split view.
//!
//! A renderer is fixed in size, drops and models. If these change, new renderers are prepared on
//! another thread (`prepare`), and the ones before go on drawing until the new ones stand. If a request
//! fails (models that do not go together, memory), they stay, and the panel shows the reason.

use std::sync::Arc;
use std::time::Duration;

use super::prepare::{Known, Pane as Shown, Prepared, Preparing, Request, draw_first, plan_of};
use crate::environment::Environment;
use crate::gpu::{Device, Image};
use crate::picture::flip::{PIXELS_PER_DEGREE, flip};
use crate::picture::{Picture, linear_of_srgb};
use crate::scene::camera::Camera;
use crate::scene::{EnvironmentChoice, ImageSize, ModelChoice, Pane, Scene};
use crate::{Error, Result};

/// The renderers of the window.
pub struct Stage {
    // Dropped first: its thread uses the device.
    preparing: Option<Preparing>,
    panes: Vec<Shown>,
    /// What the panes were made for; none while there are none.
    made_for: Option<Request>,
    /// The last request that could not be granted, and why.
    refused: Option<(Request, Error)>,
    /// What the panes last drew.
    drawn: Vec<Scene>,
    environment: Option<Arc<Environment>>,
    environment_of: EnvironmentChoice,
    /// Counts the changes of shaders.
    generation: u32,
    device: Arc<Device>,
}

/// What came of drawing.
#[derive(Debug, Default)]
pub struct Drawn {
    /// The pictures are others than before: new renderers stand.
    pub is_new: bool,
    /// A request was refused just now.
    pub refused: Option<String>,
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
    /// An empty stage. What `environment` names is read with the first request.
    pub fn new(device: &Arc<Device>, environment: EnvironmentChoice) -> Self {
        Self {
            preparing: None,
            panes: Vec::new(),
            made_for: None,
            refused: None,
            drawn: Vec::new(),
            environment: None,
            environment_of: environment,
            generation: 0,
            device: device.clone(),
        }
    }

    /// Draws `scene` at a size in pixels, with the second model beside it if there is one. Until
    /// renderers for them stand, those before draw, where the camera and the clock are now.
    ///
    /// # Errors
    /// Only those after which nothing can go on, and the first request's.
    pub fn draw(
        &mut self,
        scene: &Scene,
        second: Option<ModelChoice>,
        size: (u32, u32),
    ) -> Result<Drawn> {
        let panes = if second.is_some() { crate::passes::present::SPLIT_PANES } else { 1 };
        let image = ImageSize { width: size.0.div_ceil(panes), height: size.1 };
        let first = Scene { image, ..scene.clone() };
        let second = second.map(|model| Scene { model, ..first.clone() });
        let scenes: Vec<Scene> = [Some(first), second].into_iter().flatten().collect();
        let fixed = scenes.iter().map(fixed_part).collect();
        let request = Request { fixed, generation: self.generation };

        let drawn = self.take_prepared(&request)?;
        if self.made_for.as_ref() == Some(&request) {
            self.refused = None;
        } else if self.preparing.is_none() && !self.is_refused(&request) {
            let known = self.known(request.generation);
            self.preparing = Some(Preparing::start(&self.device, request, scenes, known)?);
        }
        let shown = self.made_for.iter().flat_map(|made| &made.fixed);
        let scenes: Vec<Scene> = shown.map(|fixed| moved(fixed, scene)).collect();
        if scenes != self.drawn {
            for (pane, scene) in self.panes.iter_mut().zip(&scenes) {
                pane.submit(scene)?;
            }
            self.drawn = scenes;
        }
        Ok(drawn)
    }

    /// What is on show and may stay. Other shaders may make other tables.
    fn known(&self, generation: u32) -> Option<Known> {
        let is_current = self.made_for.as_ref().is_some_and(|made| made.generation == generation);
        let panes = if is_current { &self.panes[..] } else { &[] };
        Some(Known {
            environment: (self.environment_of.clone(), self.environment.clone()?),
            shown: panes.first().map(Shown::shown),
            plans: panes.iter().map(|pane| pane.plan.clone()).collect(),
        })
    }

    /// Takes what has been prepared, if it is what is still asked for, or if there is nothing to show.
    fn take_prepared(&mut self, request: &Request) -> Result<Drawn> {
        let Some(preparing) = self.preparing.take_if(|preparing| preparing.is_done()) else {
            return Ok(Drawn::default());
        };
        let (of, outcome) = preparing.take();
        let is_asked_for = of == *request;
        match outcome {
            Ok(Some(Prepared { environment, panes })) if is_asked_for || self.panes.is_empty() => {
                if let Some(first) = of.fixed.first() {
                    self.environment_of = first.environment.clone();
                }
                self.environment = Some(environment);
                self.panes = panes;
                self.made_for = Some(of);
                self.drawn.clear();
                Ok(Drawn { is_new: true, refused: None })
            }
            Err(error) if error.is_lost() || (is_asked_for && self.panes.is_empty()) => Err(error),
            Err(error) if is_asked_for => {
                let refused = Some(error.to_string());
                self.refused = Some((of, error));
                Ok(Drawn { is_new: false, refused })
            }
            // Asked for no longer.
            Ok(_) | Err(_) => Ok(Drawn::default()),
        }
    }

    fn is_refused(&self, request: &Request) -> bool {
        self.refused.as_ref().is_some_and(|(refused, _)| refused == request)
    }

    /// What is being prepared, step by step, and for how long; none if nothing is.
    pub fn waits_for(&self) -> Option<(String, Duration)> {
        self.preparing.as_ref().map(Preparing::step)
    }

    /// Why the last request was refused.
    pub fn problem(&self) -> Option<String> {
        self.refused.as_ref().map(|(_, error)| error.to_string())
    }

    /// The environment of the last good request, if the one that was refused has another, which
    /// could not be read.
    pub fn environment_instead(&self) -> Option<&EnvironmentChoice> {
        let (_, error) = self.refused.as_ref()?;
        let is_its = matches!(error, Error::Environment { .. } | Error::File { .. });
        (is_its && self.environment.is_some()).then_some(&self.environment_of)
    }

    /// Goes on with another device in place of one that is lost: what is on show is made anew, whatever
    /// was asked for since.
    pub fn renew(&mut self, device: &Arc<Device>) -> Result<()> {
        // Freed before as much is asked for again.
        self.preparing = None;
        self.panes.clear();
        self.device = device.clone();
        match &self.environment {
            Some(environment) if !self.drawn.is_empty() => {
                let mut shown = None;
                for scene in &self.drawn {
                    let plan = plan_of(device, environment, scene)?;
                    self.panes.push(draw_first(device, environment, scene, plan, &mut shown)?);
                }
            }
            _ => self.made_for = None,
        }
        Ok(())
    }

    /// Makes everything anew when it is next drawn, as after a change of shaders.
    pub fn invalidate(&mut self) {
        self.generation += 1;
    }

    /// Waits for the frames under way, so that the reports are those of what is on show.
    pub fn finish(&mut self) -> Result<()> {
        self.panes.iter_mut().try_for_each(Shown::finish)
    }

    /// The renderers: one, or two side by side.
    pub fn panes(&self) -> &[Shown] {
        &self.panes
    }

    /// The pictures on show.
    pub fn pictures(&self) -> Vec<&Image> {
        self.panes.iter().filter_map(Shown::picture).collect()
    }

    /// The environment's name; empty until it is read.
    pub fn environment_name(&self) -> &str {
        self.environment.as_ref().map_or("", |environment| environment.name())
    }

    /// How the pictures of the split view differ; none without it.
    pub fn difference(&self) -> Result<Option<Difference>> {
        let [first, second] = self.panes.as_slice() else { return Ok(None) };
        let [a, b] = [first.read()?, second.read()?];
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
    // Whether there is an exposure is a matter of models; how long it is, of frames.
    other.camera.shutter = if scene.shutter() > 0.0 { 1.0 } else { 0.0 };
    // So is a lens, and how wide it is.
    other.camera.aperture = if scene.camera.aperture > 0.0 { 1.0 } else { 0.0 };
    // A pane that is wiped is the same one.
    other.pane = scene.pane.clone().map(|pane| Pane { age: Some(0.0), ..pane });
    moved(scene, &other)
}

/// `scene` with the camera (but no exposure and no lens where it has none), the time, its pace, the age of a pane in the rain, the key and, if both have one, the fixed exposure of another.
fn moved(scene: &Scene, other: &Scene) -> Scene {
    let (time, pace) = (other.time, other.pace);
    let mut moved = Scene { camera: other.camera, time, pace, ..scene.clone() };
    if scene.shutter() == 0.0 {
        (moved.camera.shutter, moved.camera.shutter_angle) = (0.0, None);
    }
    if scene.camera.aperture == 0.0 {
        moved.camera.aperture = 0.0;
    }
    moved.tone_map.key = other.tone_map.key;
    moved.tone_map.exposure = scene.tone_map.exposure.and(other.tone_map.exposure);
    if let (Some(pane), Some(other)) = (&mut moved.pane, &other.pane)
        && pane.has_population()
        && other.has_population()
    {
        pane.age = Some(other.age());
    }
    moved
}
