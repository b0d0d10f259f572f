//! Renderers made on another thread, while the window goes on hearing events and drawing.
//!
//! Reading an environment, compiling pipelines and filling tables take seconds where nothing is cached.
//! Drivers may compile when a pipeline is first used, so a first frame is drawn here as well. It shares
//! the device's only queue with the window: [`Device::has_long_job`] tells the window when a frame of its
//! own would wait.
//!
//! Drivers that run on the CPU compile on the queue itself, for seconds. With them each renderer of models that are
//! not on show yet is first made and drawn on a device of this thread's own, whose compiled code the driver keeps
//! on disk: a *rehearsal*, after which the first frame on the window's device takes no longer than the second.
//!
//! Light and rain that are on show already are taken over: another size, or a second pane, makes only what has the
//! picture's size.

use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, PoisonError};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

use crate::environment::Environment;
use crate::environment::guess::is_guessed;
use crate::gpu::disk_cache::user_folder;
use crate::gpu::{Device, Image};
use crate::measure::costs::kept;
use crate::plan::{FramePlan, Output, choose, plan_by};
use crate::renderer::{FrameReport, Lighting, RainField, Renderer};
use crate::scene::{EnvironmentChoice, Scene};
use crate::{Error, Result};

/// A renderer, its plan, and the report of its last finished frame.
pub struct Pane {
    /// Models and passes.
    pub plan: FramePlan,
    /// Report on the last finished frame.
    pub report: FrameReport,
    renderer: Renderer,
}

impl Pane {
    /// Draws a frame; its report is of one before.
    pub fn submit(&mut self, scene: &Scene) -> Result<()> {
        if let Some(report) = self.renderer.submit(scene)? {
            self.report = report;
        }
        Ok(())
    }

    /// Waits for the last frame.
    pub fn finish(&mut self) -> Result<()> {
        self.report = self.renderer.finish()?;
        Ok(())
    }

    /// The light and the rain that it shows.
    pub fn shown(&self) -> Shown {
        (self.renderer.lighting().clone(), self.renderer.rain().clone())
    }

    /// The picture on the device.
    pub fn picture(&self) -> Option<&Image> {
        self.renderer.display()
    }

    /// The picture: sRGB, three bytes a pixel.
    pub fn read(&self) -> Result<Vec<u8>> {
        self.renderer.read_display()
    }
}

/// What panes share.
pub type Shown = (Arc<Lighting>, Arc<RainField>);

/// What is on show already, and may stay.
#[derive(Clone)]
pub struct Known {
    /// The environment's choice, and it itself.
    pub environment: (EnvironmentChoice, Arc<Environment>),
    /// Its light, and the rain; none after a change of shaders.
    pub shown: Option<Shown>,
    /// The plans by which it is drawn.
    pub plans: Vec<FramePlan>,
}

/// What renderers are asked for: the scenes without what may change from frame to frame.
#[derive(Clone, Debug, PartialEq)]
pub struct Request {
    /// One scene a pane; all have the same environment.
    pub fixed: Vec<Scene>,
    /// Counts the changes of shaders.
    pub generation: u32,
}

/// What a request comes to.
pub struct Prepared {
    /// The environment of its scenes.
    pub environment: Arc<Environment>,
    /// One for each scene, which has drawn its first frame.
    pub panes: Vec<Pane>,
}

/// What the thread and the window share.
struct Progress {
    step: Mutex<String>,
    is_cancelled: AtomicBool,
}

impl Progress {
    /// Begins a step; false if no one waits for it any more.
    fn begin(&self, step: String) -> bool {
        *self.step.lock().unwrap_or_else(PoisonError::into_inner) = step;
        !self.is_cancelled.load(Ordering::Relaxed)
    }
}

/// A request under way. Dropped, it waits for the thread, which ends with the step that it is at.
pub struct Preparing {
    request: Request,
    progress: Arc<Progress>,
    since: Instant,
    /// None once it is taken; the outcome is none if the request was cancelled.
    thread: Option<JoinHandle<Result<Option<Prepared>>>>,
}

impl Preparing {
    /// Begins to prepare renderers of `scenes`.
    ///
    /// # Errors
    /// [`Error::Window`] if there can be no further thread.
    pub fn start(
        device: &Arc<Device>,
        request: Request,
        scenes: Vec<Scene>,
        known: Option<Known>,
    ) -> Result<Self> {
        let step = Mutex::new("preparing".into());
        let progress = Arc::new(Progress { step, is_cancelled: AtomicBool::new(false) });
        let (device, of_thread) = (device.clone(), progress.clone());
        let thread = std::thread::Builder::new()
            .name("prepare".into())
            .spawn(move || prepare(&device, &scenes, known, &of_thread))
            .map_err(|error| Error::Window(format!("no further thread: {error}")))?;
        Ok(Self { request, progress, since: Instant::now(), thread: Some(thread) })
    }

    /// Whether it has come to an end, so that [`Preparing::take`] does not wait.
    pub fn is_done(&self) -> bool {
        self.thread.as_ref().is_none_or(JoinHandle::is_finished)
    }

    /// What it is at, and for how long it has been at work.
    pub fn step(&self) -> (String, Duration) {
        let step = self.progress.step.lock().unwrap_or_else(PoisonError::into_inner).clone();
        (step, self.since.elapsed())
    }

    /// The request and what came of it.
    pub fn take(mut self) -> (Request, Result<Option<Prepared>>) {
        let request = self.request.clone();
        (request, self.join())
    }

    fn join(&mut self) -> Result<Option<Prepared>> {
        match self.thread.take().map(JoinHandle::join) {
            Some(Ok(outcome)) => outcome,
            Some(Err(panic)) => std::panic::resume_unwind(panic),
            None => Ok(None),
        }
    }
}

impl Drop for Preparing {
    fn drop(&mut self) {
        self.progress.is_cancelled.store(true, Ordering::Relaxed);
        if let Some(thread) = self.thread.take() {
            // No one asks any more; a panic has been reported by its hook.
            let _ = thread.join();
        }
    }
}

/// What the thread does.
fn prepare(
    device: &Arc<Device>,
    scenes: &[Scene],
    known: Option<Known>,
    progress: &Progress,
) -> Result<Option<Prepared>> {
    let choice = scenes.first().map(|scene| scene.environment.clone()).unwrap_or_default();
    // A guess is the plate's, which the choice does not name.
    let is_guess = scenes.first().is_some_and(is_guessed);
    let known = known.filter(|known| known.environment.0 == choice && !is_guess);
    let environment = match &known {
        Some(known) => known.environment.1.clone(),
        None => {
            let file = choice.file.as_ref().and_then(|path| path.file_name());
            let name = file.map_or("the sky".into(), |name| name.to_string_lossy());
            if !progress.begin(format!("reading {name}")) {
                return Ok(None);
            }
            match scenes.first() {
                Some(scene) => Arc::new(Environment::of(scene)?),
                None => Arc::new(Environment::open(&choice)?),
            }
        }
    };
    let rehearsal = match device.report.is_cpu() {
        true => Device::open(device.instance(), device.report.clone()).ok(),
        false => None,
    };
    let (plans, mut shown) = known.map(|known| (known.plans, known.shown)).unwrap_or_default();
    let mut shown_in_rehearsal = None;
    let mut panes = Vec::new();
    for (number, scene) in scenes.iter().enumerate() {
        let which = match scenes.len() {
            1 => String::new(),
            count => format!(" ({} of {count})", number + 1),
        };
        if !progress.begin(format!("preparing {}{which}", scene.model.preset)) {
            return Ok(None);
        }
        let plan = plan_of(device, &environment, scene)?;
        let is_of = |(_, rain): &Shown| rain.is_of(scene);
        let is_on_show = shown.as_ref().is_some_and(is_of)
            && plans.iter().any(|other| other.has_models_of(&plan));
        if let Some(rehearsal) = rehearsal.as_ref().filter(|_| !is_on_show) {
            // SAFETY: the same as on the device that they come from.
            unsafe { rehearsal.replace_shaders(device.replaced_shaders()) };
            // It saves time and decides nothing: what fails here fails below, and is reported there.
            let shown = &mut shown_in_rehearsal;
            let _ = draw_first(rehearsal, &environment, scene, plan.clone(), shown);
        }
        panes.push(draw_first(device, &environment, scene, plan, &mut shown)?);
    }
    Ok(Some(Prepared { environment, panes }))
}

/// What `scene` requires on this device.
pub fn plan_of(device: &Device, environment: &Environment, scene: &Scene) -> Result<FramePlan> {
    scene.validate("the window")?;
    // What is expected, by the times that are kept of the device: nothing is measured beside the window.
    let costs = kept(&device.report, user_folder().as_deref(), |_| ());
    let choice = choose(scene, environment, &costs.unwrap_or_default());
    plan_by(scene, environment, choice.as_ref(), Output::Display)
}

/// A renderer that has drawn `scene`. It shows what is `shown` already, where that is the scene's; else the next may
/// show what this one does.
pub fn draw_first(
    device: &Arc<Device>,
    environment: &Environment,
    scene: &Scene,
    plan: FramePlan,
    shown: &mut Option<Shown>,
) -> Result<Pane> {
    let (lighting, rain) = match shown.take() {
        Some((lighting, rain)) => (lighting, Some(rain).filter(|rain| rain.is_of(scene))),
        None => (Arc::new(Lighting::new(device, environment)?), None),
    };
    let rain = rain.unwrap_or_else(|| Arc::new(RainField::new(device, scene)));
    let mut renderer = Renderer::of(&lighting, &rain, scene, &plan)?;
    *shown = Some((lighting, rain));
    let _long_job = device.long_job();
    let report = renderer.draw(scene)?;
    Ok(Pane { plan, report, renderer })
}
