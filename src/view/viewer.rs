//! The open window: what it shows, and what is asked of it from one frame to the next.

use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::{Duration, Instant};

use glam::DVec2;
use winit::window::{Fullscreen, Window};

use super::clock::Clock;
use super::flight::{Flight, look_past, visit};
use super::focus::focus_on;
use super::glass::{stop_at_glass, wipe};
use super::history::History;
use super::keep::Keep;
use super::keys::Action;
use super::panel::{Controls, Facts, TITLE, messages, panel, preset};
use super::reload::Reload;
use super::screen::{Screen, Shapes};
use super::stage::{Difference, Stage};
use super::{Options, environments};
use crate::Result;
use crate::gpu::{Device, Surface};
use crate::passes::present::SPLIT_PANES;
use crate::remark::Remark;
use crate::scene::model::Preset;
use crate::scene::{
    EnvironmentChoice, ImageSize, MAX_DROPS, ModelChoice, RainSettings, Scene, real_rain,
};
use crate::thousands::counted;

/// A window whose size has changed keeps its old picture, scaled, until it has been still this long:
/// whoever drags its edge does not wait for renderers.
const SETTLED: Duration = Duration::from_millis(120);

/// How often a window that waits for renderers shows that it does, and how often it looks whether the
/// queue is free for that.
const WAITING: Duration = Duration::from_millis(40);
const QUEUED: Duration = Duration::from_millis(5);

/// How often a window at rest looks whether something has changed, such as a shader's source.
const REST: Duration = Duration::from_millis(250);

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
    say: fn(&str),
    remark: fn(&Remark),
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
            say: options.say,
            remark: options.remark,
            reload: Reload::new(),
            screen,
            stage: Stage::new(device, scene.environment.clone()),
            scene,
            window,
            device: device.clone(),
        })
    }

    /// Goes on with another device in place of one that is lost.
    pub fn renew(&mut self, device: &Arc<Device>) -> Result<()> {
        // SAFETY: the same as on the device that they come from.
        unsafe { device.replace_shaders(self.device.replaced_shaders()) };
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
        (self.say)(&message);
        self.message = Some((message, Instant::now()));
    }

    /// Says for a while, in the window and on the terminal, that something did not go as it should.
    pub fn warn(&mut self, problem: String) {
        (self.remark)(&Remark::warning(problem.as_str()));
        self.message = Some((problem, Instant::now()));
    }

    /// Says where something was kept, or why it was not.
    fn say_kept(&mut self, kept: Result<PathBuf>) {
        let said = kept.map(|path| self.say(format!("kept as {}", path.display())));
        said.unwrap_or_else(|error| self.warn(error.to_string()));
    }

    /// What a key asks for is done with the next frame, but the window closes at once.
    pub fn ask(&mut self, action: Action) {
        self.is_done |= action == Action::Quit;
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
                if let Some(real) = &mut rain.real {
                    let rate = real.rate * if more { 2.0 } else { 0.5 };
                    real.rate = rate.clamp(*real_rain::RATES.start(), *real_rain::RATES.end());
                } else {
                    let count =
                        if more { rain.count.saturating_mul(2).max(1) } else { rain.count / 2 };
                    rain.count = count.min(MAX_DROPS);
                }
            }
            Action::Wipe => {
                if !wipe(&mut self.scene) {
                    self.say("there is no pane that rain falls on".into());
                }
            }
            Action::Exposure { brighter } => {
                let tone_map = &mut self.scene.tone_map;
                *tone_map.exposure.as_mut().unwrap_or(&mut tone_map.key) *=
                    if brighter { 1.25 } else { 0.8 };
            }
            Action::Visit => {
                if visit(&mut self.scene) {
                    self.look_past_panel();
                } else {
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
                        self.say_kept(kept);
                    }
                    None => self.say("there is no picture to keep yet".into()),
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

    /// A click at a place of the window, in its pixels: the lens is focused on the drop there.
    pub fn click(&mut self, (x, y): (f64, f64)) {
        if self.scene.camera.aperture == 0.0 {
            return;
        }
        let mut shown = self.shown();
        let place = DVec2::new(x % f64::from(shown.image.width), y);
        if focus_on(&mut shown, place) {
            self.scene.camera.focus = shown.camera.focus;
        } else {
            self.say("there is no drop to focus on".into());
        }
        self.window.request_redraw();
    }

    /// The scene as a picture of its size on the screen.
    fn shown(&self) -> Scene {
        let (width, height) = self.window_size();
        let panes = if self.second.is_some() { SPLIT_PANES } else { 1 };
        let image = ImageSize { width: width.div_ceil(panes).max(1), height: height.max(1) };
        Scene { image, ..self.scene.clone() }
    }

    /// Turns until the panel does not cover the drop that was flown to.
    fn look_past_panel(&mut self) {
        let ctx = self.input.egui_ctx();
        let area = ctx.memory(|memory| memory.area_rect(TITLE)).filter(|_| self.has_panel);
        if let Some(area) = area {
            let covered =
                [area.left(), area.right()].map(|x| f64::from(x * ctx.pixels_per_point()));
            let view = self.shown().view();
            look_past(&mut self.scene.camera, &view, covered);
        }
    }

    /// Keeps a scene file of what one sees.
    pub fn keep_scene(&mut self) {
        let kept = self.keep.scene(&self.scene);
        self.say_kept(kept);
    }

    fn reloaded(&mut self, outcome: std::result::Result<usize, String>) {
        match outcome {
            Ok(count) => {
                self.stage.invalidate();
                self.say(format!("{} reloaded", counted(count as u64, "shader")));
            }
            Err(problem) => self.warn(format!("the last good shaders stay: {problem}")),
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
                Err(error) => self.warn(error.to_string()),
            }
        } else {
            let choice =
                EnvironmentChoice { file: Some(path.into()), ..EnvironmentChoice::default() };
            self.scene.environment = choice;
        }
        self.environments = environments(&self.scene);
        self.window.request_redraw();
    }

    /// How long until the next frame, if nothing is heard before; none if it is to follow at once.
    pub fn rest(&self) -> Option<Duration> {
        let waits = self.stage.waits_for().is_some();
        if waits && self.device.has_long_job() {
            Some(QUEUED)
        } else if self.is_moving() {
            None
        } else {
            Some(if waits { WAITING } else { REST })
        }
    }

    /// Whether pictures change by themselves, so that frame is to follow frame.
    fn is_moving(&self) -> bool {
        let is_settling = self.drawn_size != self.window_size();
        // Actions that are left wait for renderers, and have nothing done for them until these stand.
        let is_asked = !self.actions.is_empty() && self.stage.waits_for().is_none();
        let is_timed = is_settling || is_asked || self.message.is_some();
        !self.clock.paused || self.flight.is_moving() || is_timed
    }

    fn window_size(&self) -> (u32, u32) {
        let size = self.window.inner_size();
        (size.width, size.height)
    }

    /// One frame: time goes by, the camera flies, the rain is drawn, and the panel over it.
    ///
    /// Keys are obeyed in their order. What a key asks of a picture waits until that picture is drawn,
    /// and so do the keys after it.
    pub fn frame(&mut self) -> Result<()> {
        if self.stage.waits_for().is_some() && self.device.has_long_job() {
            // Presenting would wait, and no event would be heard until it is over.
            return Ok(());
        }
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
        let before = self.scene.camera;
        self.act_while(|action| !action.is_of_picture())?;
        if let Some(outcome) = self.reload.poll(&self.device, now) {
            self.reloaded(outcome);
        }
        self.clock.advance(elapsed);
        self.flight.fly(&mut self.scene.camera, elapsed.min(LONGEST_STEP));
        stop_at_glass(&mut self.scene, &before);
        let goes_by = self.clock.seconds() - self.scene.time;
        self.scene.pane = self.scene.pane.take().map(|pane| pane.after(goes_by));
        self.scene.time = self.clock.seconds();
        // Where time is stopped the picture stays as it was.
        self.scene.pace = if self.clock.backwards { -self.clock.rate() } else { self.clock.rate() };

        if self.resized.1 != size {
            self.resized = (now, size);
        }
        let is_first = self.drawn_size == (0, 0);
        if is_first || !self.actions.is_empty() || now - self.resized.0 >= SETTLED {
            self.drawn_size = size;
        }
        let drawn = self.stage.draw(&self.scene, self.second, self.drawn_size)?;
        if drawn.is_new {
            self.screen.show(&self.stage.pictures())?;
            self.difference = None;
        }
        if self.clock.paused {
            self.stage.finish()?;
        }
        let mut is_asked_for = self.stage.waits_for().is_none();
        if let Some(problem) = drawn.refused {
            if let Some(environment) = self.stage.environment_instead() {
                self.scene.environment = environment.clone();
                self.environments = environments(&self.scene);
                is_asked_for = false;
            }
            self.warn(problem);
        }
        self.lay_out();
        // Minimised, or before the first frame, there is nothing to keep.
        if is_asked_for && self.screen.size() != (0, 0) {
            self.act_while(Action::is_of_picture)?;
        }
        let is_shown = self.screen.draw(size, &self.stage.pictures(), &self.shapes)?;
        if is_shown {
            self.name_window();
        }
        Ok(())
    }

    /// Does what is asked for as long as the next action is of a kind.
    fn act_while(&mut self, is_of_kind: impl Fn(Action) -> bool) -> Result<()> {
        while let Some(action) = self.actions.first().copied().filter(|action| is_of_kind(*action))
        {
            self.actions.remove(0);
            self.act(action)?;
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
        let problem = self.stage.problem();
        let facts = Facts {
            device: &self.device.report.summary(),
            size: self.screen.size(),
            history: &self.history,
            panes: self.stage.panes(),
            window_ms: &self.screen.passes_ms,
            environment: self.stage.environment_name(),
            environments: &self.environments,
            difference: self.difference,
            problem: problem.as_deref(),
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
        let waits_for = self.stage.waits_for();
        let output = ctx.run(raw, |ctx| {
            if self.has_panel {
                panel(ctx, &mut controls, &facts);
            }
            messages(ctx, message, waits_for.as_ref());
        });
        // It is zero while something fades in, for one.
        if output.viewport_output.values().any(|viewport| viewport.repaint_delay.is_zero()) {
            self.window.request_redraw();
        }
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
