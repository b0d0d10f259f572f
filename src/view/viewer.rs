//! The open window: what it shows, and what is asked of it from one frame to the next.

use std::path::Path;
use std::sync::Arc;
use std::time::{Duration, Instant};

use winit::window::{Fullscreen, Window};

use super::clock::Clock;
use super::flight::{Flight, visit};
use super::history::History;
use super::keep::Keep;
use super::keys::Action;
use super::panel::{Controls, Facts, panel, preset};
use super::reload::Reload;
use super::screen::{Screen, Shapes};
use super::stage::{Difference, Stage};
use super::{Options, environments};
use crate::Result;
use crate::gpu::{Device, Surface};
use crate::scene::model::Preset;
use crate::scene::{EnvironmentChoice, MAX_DROPS, ModelChoice, RainSettings, Scene};

/// A window whose size has changed keeps its old picture, scaled, until it has been still this long:
/// whoever drags its edge does not wait for renderers.
const SETTLED: Duration = Duration::from_millis(120);

/// How long a message stays.
const MESSAGE: Duration = Duration::from_secs(6);

/// Longest step of flight from frame to frame, so that a long frame does not throw the camera far.
const LONGEST_STEP: Duration = Duration::from_millis(100);

/// The open window.
pub struct Viewer {
    /// What winit and egui agree on.
    pub input: egui_winit::State,
    /// What moves the camera.
    pub flight: Flight,
    /// What is shown; its time is the clock's.
    pub scene: Scene,
    /// Whether the window is to be closed.
    pub is_done: bool,
    second: Option<ModelChoice>,
    clock: Clock,
    wanted_drops: Option<u32>,
    actions: Vec<Action>,
    has_panel: bool,
    shapes: Shapes,
    message: Option<(String, Instant)>,
    difference: Option<Difference>,
    environments: Vec<(String, EnvironmentChoice)>,
    history: History,
    last_frame: Instant,
    /// When the window last changed its size, and to what.
    resized: (Instant, (u32, u32)),
    drawn_size: (u32, u32),
    name: String,
    keep: Keep,
    reload: Reload,
    // Freed in this order, before the device.
    screen: Screen,
    stage: Stage,
    /// The window itself.
    pub window: Arc<Window>,
    device: Arc<Device>,
}

impl Viewer {
    /// Shows `options.scene` in `window`.
    pub fn new(device: &Arc<Device>, window: Arc<Window>, options: Options) -> Result<Self> {
        let surface = Surface::new(device.instance(), window.clone())?;
        let screen = Screen::new(device, surface, options.vsync)?;
        let scene = options.scene;
        let now = Instant::now();
        Ok(Self {
            input: input(device, &window),
            flight: Flight::new(&scene),
            is_done: false,
            second: None,
            clock: Clock::new(scene.time, options.paused),
            wanted_drops: None,
            actions: Vec::new(),
            has_panel: options.panel,
            shapes: Shapes::default(),
            message: None,
            difference: None,
            environments: environments(&scene),
            history: History::default(),
            last_frame: now,
            resized: (now, (0, 0)),
            drawn_size: (0, 0),
            name: options.name,
            keep: Keep::new(options.keep_in),
            reload: Reload::new(),
            screen,
            stage: Stage::new(device, &scene)?,
            scene,
            window,
            device: device.clone(),
        })
    }

    /// Goes on with another device in place of one that is lost.
    pub fn renew(&mut self, device: &Arc<Device>) -> Result<()> {
        device.replace_shaders(self.device.replaced_shaders());
        self.stage.renew(device)?;
        let surface = Surface::new(device.instance(), self.window.clone())?;
        self.screen = Screen::new(device, surface, self.screen.vsync())?;
        // egui tells its font atlas only once, and it was on the device.
        self.input = input(device, &self.window);
        self.device = device.clone();
        // What this took is not time that the scene has lived through.
        self.last_frame = Instant::now();
        self.window.request_redraw();
        Ok(())
    }

    /// Says something for a while, in the window and on the terminal.
    pub fn say(&mut self, message: String) {
        eprintln!("{message}");
        self.message = Some((message, Instant::now()));
    }

    /// What a key asks for is done with the next frame.
    pub fn ask(&mut self, action: Action) {
        self.actions.push(action);
        self.window.request_redraw();
    }

    fn act(&mut self, action: Action) -> Result<()> {
        match action {
            Action::Pause => self.clock.paused = !self.clock.paused,
            Action::Reverse => {
                self.clock.backwards = !self.clock.backwards;
                self.clock.paused = false;
            }
            Action::Rewind => self.clock.rewound(),
            Action::Step { forward } => self.clock.step(forward),
            Action::Rate { faster } => self.clock.change_rate(faster),
            Action::Preset(number) => {
                if let Some(preset) = preset(number) {
                    self.scene.model = ModelChoice { preset, ..ModelChoice::default() };
                }
            }
            Action::Drops { more } => {
                let rain =
                    self.scene.rain.get_or_insert(RainSettings { count: 0, ..Default::default() });
                let count = if more { rain.count.saturating_mul(2).max(1) } else { rain.count / 2 };
                rain.count = count.min(MAX_DROPS);
            }
            Action::Exposure { brighter } => {
                let tone_map = &mut self.scene.tone_map;
                *tone_map.exposure.as_mut().unwrap_or(&mut tone_map.key) *=
                    if brighter { 1.25 } else { 0.8 };
            }
            Action::Visit => {
                if !visit(&mut self.scene) {
                    self.say("there is no drop in front to fly to".into());
                }
            }
            Action::Split => {
                let model = |preset| ModelChoice { preset, ..ModelChoice::default() };
                self.second = self.second.is_none().then(|| model(Preset::Exact));
                self.difference = None;
            }
            Action::Measure => {
                self.difference = self.stage.difference()?;
                if self.difference.is_none() {
                    self.say("nothing to measure: B puts a second model beside the first".into());
                }
            }
            Action::Panel => self.has_panel = !self.has_panel,
            Action::Screenshot { panel } => {
                let shapes = panel.then_some(&self.shapes);
                match self.screen.read(&self.stage.pictures(), shapes)? {
                    Some(srgb) => {
                        let kept = self.keep.picture(&srgb, self.screen.size());
                        self.say(kept.map_or_else(|error| error.to_string(), |path| said(&path)));
                    }
                    // Nothing has been shown yet: of the next frame, then.
                    None => self.actions.push(action),
                }
            }
            Action::SaveScene => self.keep_scene(),
            Action::Vsync => {
                self.screen.set_vsync(!self.screen.vsync())?;
                let waits = if self.screen.vsync() { "wait" } else { "do not wait" };
                self.say(format!("frames {waits} for the screen"));
            }
            Action::Fullscreen => {
                let full = self.window.fullscreen().is_none();
                self.window.set_fullscreen(full.then_some(Fullscreen::Borderless(None)));
            }
            Action::Reload => {
                let outcome = self.reload.now(&self.device);
                self.reloaded(outcome);
            }
            Action::Quit => self.is_done = true,
        }
        Ok(())
    }

    /// Keeps a scene file of what one sees.
    pub fn keep_scene(&mut self) {
        let kept = self.keep.scene(&self.scene);
        self.say(kept.map_or_else(|error| error.to_string(), |path| said(&path)));
    }

    fn reloaded(&mut self, outcome: std::result::Result<usize, String>) {
        match outcome {
            Ok(count) => {
                self.stage.invalidate();
                self.say(format!("{count} shaders reloaded"));
            }
            Err(problem) => self.say(format!("the last good shaders stay: {problem}")),
        }
    }

    /// Takes a file that was dropped on the window: a scene, or an environment.
    pub fn take_file(&mut self, path: &Path) {
        if path.extension().is_some_and(|extension| extension == "toml") {
            match Scene::load(path) {
                Ok(scene) => {
                    self.clock = Clock::new(scene.time, self.clock.paused);
                    self.flight = Flight::new(&scene);
                    self.name = path.display().to_string();
                    self.scene = scene;
                }
                Err(error) => self.say(error.to_string()),
            }
        } else {
            let choice = EnvironmentChoice { file: Some(path.into()), radiance: None };
            self.scene.environment = choice;
        }
        self.open_environment();
        self.environments = environments(&self.scene);
        self.window.request_redraw();
    }

    /// Opens the scene's environment if it is another; the last good one stays where that cannot be.
    fn open_environment(&mut self) {
        if let Err(error) = self.stage.open_environment(&self.scene.environment) {
            self.scene.environment = self.stage.environment_choice().clone();
            self.say(error.to_string());
        }
    }

    /// Whether pictures change by themselves, so that frame is to follow frame.
    pub fn is_moving(&self) -> bool {
        let is_settling = self.drawn_size != self.window_size();
        let is_asked = !self.actions.is_empty() || self.message.is_some();
        !self.clock.paused || self.flight.is_moving() || is_settling || is_asked
    }

    fn window_size(&self) -> (u32, u32) {
        let size = self.window.inner_size();
        (size.width, size.height)
    }

    /// One frame: time goes by, the camera flies, the rain is drawn, and the panel over it.
    pub fn frame(&mut self) -> Result<()> {
        let now = Instant::now();
        let elapsed = now - self.last_frame;
        self.last_frame = now;
        let size = self.window_size();
        if size.0 == 0 || size.1 == 0 {
            // Minimised. Time stands still for whoever cannot see it.
            return Ok(());
        }
        if self.is_moving() {
            self.history.push(elapsed);
        }
        let (of_picture, others): (Vec<_>, Vec<_>) =
            std::mem::take(&mut self.actions).into_iter().partition(|a| a.is_of_picture());
        for action in others {
            self.act(action)?;
        }
        if let Some(outcome) = self.reload.poll(&self.device, now) {
            self.reloaded(outcome);
        }
        self.clock.advance(elapsed);
        self.flight.fly(&mut self.scene.camera, elapsed.min(LONGEST_STEP));
        self.scene.time = self.clock.seconds();

        if self.resized.1 != size {
            self.resized = (now, size);
        }
        let is_first = self.drawn_size == (0, 0);
        if is_first || !of_picture.is_empty() || now - self.resized.0 >= SETTLED {
            self.drawn_size = size;
        }
        self.open_environment();
        let known = self.stage.problem.clone();
        if self.stage.draw(&self.scene, self.second, self.drawn_size)? {
            self.screen.show(&self.stage.pictures())?;
            self.difference = None;
        }
        if self.clock.paused {
            self.stage.finish()?;
        }
        if let Some(problem) = self.stage.problem.clone().filter(|p| known.as_ref() != Some(p)) {
            self.say(problem);
        }
        self.lay_out();
        for action in of_picture {
            self.act(action)?;
        }
        let is_shown = self.screen.draw(size, &self.stage.pictures(), &self.shapes)?;
        if is_shown {
            self.name_window();
        }
        Ok(())
    }

    /// Runs egui and keeps its triangles.
    fn lay_out(&mut self) {
        let now = Instant::now();
        if self.message.as_ref().is_some_and(|(_, since)| now - *since > MESSAGE) {
            self.message = None;
        }
        let raw = self.input.take_egui_input(&self.window);
        let ctx = self.input.egui_ctx().clone();
        let facts = Facts {
            device: &self.device.report.summary(),
            size: self.screen.size(),
            history: &self.history,
            panes: self.stage.panes(),
            window_ms: &self.screen.passes_ms,
            environment: self.stage.environment_name(),
            environments: &self.environments,
            difference: self.difference,
            problem: self.stage.problem.as_deref(),
        };
        let mut controls = Controls {
            scene: &mut self.scene,
            second: &mut self.second,
            clock: &mut self.clock,
            speed: &mut self.flight.speed,
            drops: &mut self.wanted_drops,
            actions: &mut self.actions,
        };
        let message = self.message.as_ref().map(|(text, _)| text.as_str());
        let output = ctx.run(raw, |ctx| {
            if self.has_panel {
                panel(ctx, &mut controls, &facts);
            }
            if let Some(message) = message {
                egui::Area::new("message".into())
                    .anchor(egui::Align2::CENTER_BOTTOM, [0.0, -16.0])
                    .show(ctx, |ui| {
                        egui::Frame::popup(ui.style()).show(ui, |ui| ui.label(message));
                    });
            }
        });
        self.input.handle_platform_output(&self.window, output.platform_output);
        self.screen.take_textures(output.textures_delta);
        self.shapes = Shapes {
            primitives: ctx.tessellate(output.shapes, output.pixels_per_point),
            points_px: output.pixels_per_point,
        };
    }

    /// The title tells what a window list should: the scene, its size on the screen, its time.
    fn name_window(&mut self) {
        let (width, height) = self.screen.size();
        let state = if self.clock.paused { ", stopped" } else { "" };
        let title = format!("raindrops: {}, {width} x {height}{state}", self.name);
        if self.window.title() != title {
            self.window.set_title(&title);
        }
    }
}

/// egui for a window whose overlay the device draws.
fn input(device: &Device, window: &Window) -> egui_winit::State {
    let ctx = egui::Context::default();
    ctx.set_visuals(egui::Visuals::dark());
    let viewport = ctx.viewport_id();
    let most = device.report.limits.max_image_dimension2_d as usize;
    egui_winit::State::new(ctx, viewport, window, None, None, Some(most))
}

fn said(path: &Path) -> String {
    format!("kept as {}", path.display())
}
