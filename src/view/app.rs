//! The window system's events, and the loop that hears them.

use std::sync::Arc;
use std::time::{Duration, Instant};

use winit::application::ApplicationHandler;
use winit::dpi::PhysicalSize;
use winit::event::{ElementState, MouseButton, MouseScrollDelta, WindowEvent};
use winit::event_loop::{ActiveEventLoop, ControlFlow, EventLoop};
use winit::keyboard::{ModifiersState, PhysicalKey};
use winit::window::{Window, WindowId};

use super::Options;
use super::flight::drag;
use super::keys::action;
use super::viewer::Viewer;
use crate::gpu::disk_cache::{KeptDevice, user_folder};
use crate::gpu::{DeviceReport, Instance, choose_among};
use crate::measure::costs::ranked;
use crate::remark::Remark;
use crate::{Error, Result};

/// A device that is lost so soon after another is not replaced: the scene itself may be what it fails on.
const AGAIN: Duration = Duration::from_secs(60);

/// A pointer that went less far while its button was down has clicked, in pixels.
const CLICK_PX: f64 = 3.0;

/// Opens a window and returns when it is closed.
///
/// # Errors
/// [`Error::Window`] without a display; those of the device and of the scene; a device that is lost twice;
/// [`Error::Validation`] if the layer was asked for and said anything.
pub fn run(options: Options) -> Result<()> {
    let problem = |error: winit::error::EventLoopError| {
        let is_named = |name: &&str| std::env::var_os(name).is_some();
        let has_display =
            cfg!(target_os = "macos") || ["WAYLAND_DISPLAY", "DISPLAY"].iter().any(is_named);
        // What winit says of it has a line of its sources.
        Error::Window(match has_display {
            true => error.to_string(),
            false => "neither WAYLAND_DISPLAY nor DISPLAY is set; `raindrops render` draws without a screen".into(),
        })
    };
    let events = EventLoop::new().map_err(problem)?;
    let instance = Instance::for_windows(options.validation, &events.owned_display_handle())?;
    let ranked = ranked(&instance, user_folder().as_deref(), options.remark)?;
    let reports: Vec<DeviceReport> = ranked.into_iter().map(|device| device.report).collect();
    let mut report = choose_among(&reports, options.device.as_deref())?;
    report.machine = options.machine.unwrap_or(report.machine);
    let remark = options.remark;
    (options.say)(&format!("device: {}", report.summary()));
    let device = open(&instance, report, remark)?;
    let mut app = App {
        device,
        remark,
        options: Some(options),
        viewer: None,
        modifiers: ModifiersState::empty(),
        pointer: (0.0, 0.0),
        is_dragging: false,
        dragged: 0.0,
        renewed: None,
        outcome: Ok(()),
    };
    events.run_app(&mut app).map_err(problem)?;
    let App { viewer, outcome, device, .. } = app;
    drop(viewer);
    drop(device);
    outcome?;
    instance.expect_silence()
}

fn open(instance: &Arc<Instance>, report: DeviceReport, remark: fn(&Remark)) -> Result<KeptDevice> {
    KeptDevice::open(instance, report, user_folder(), remark)
}

/// What the event loop calls.
struct App {
    remark: fn(&Remark),
    viewer: Option<Viewer>,
    /// Until the window is open.
    options: Option<Options>,
    modifiers: ModifiersState,
    pointer: (f64, f64),
    is_dragging: bool,
    /// How far the pointer went since its button went down, in pixels.
    dragged: f64,
    /// When a lost device was last replaced.
    renewed: Option<Instant>,
    outcome: Result<()>,
    device: KeptDevice,
}

impl App {
    fn open(&mut self, events: &ActiveEventLoop) -> Result<()> {
        let Some(options) = self.options.take() else { return Ok(()) };
        let size = options.scene.image;
        let attributes = Window::default_attributes()
            .with_title("raindrops")
            .with_inner_size(PhysicalSize::new(size.width, size.height));
        let window =
            events.create_window(attributes).map_err(|error| Error::Window(error.to_string()))?;
        self.viewer = Some(Viewer::new(&self.device, Arc::new(window), options)?);
        Ok(())
    }

    /// Ends the loop on an error, which [`run`] returns, unless it can go on after it.
    fn expect(&mut self, events: &ActiveEventLoop, outcome: Result<()>) {
        let is_lost = outcome.as_ref().is_err_and(Error::is_lost);
        if let Err(error) = outcome.or_else(|error| self.renew(error)) {
            // Not the user's doing; what is seen is not to be lost with it.
            if let (true, Some(viewer)) = (is_lost, &mut self.viewer) {
                viewer.keep_scene();
            }
            self.outcome = Err(error);
            events.exit();
        }
    }

    /// Opens the device again if it, or the window's surface, is lost; else the error stays.
    fn renew(&mut self, error: Error) -> Result<()> {
        let is_again = self.renewed.is_some_and(|before| before.elapsed() < AGAIN);
        let Some(viewer) = self.viewer.as_mut().filter(|_| error.is_lost() && !is_again) else {
            return Err(error);
        };
        let device = open(self.device.instance(), self.device.report.clone(), self.remark)?;
        viewer.renew(&device)?;
        self.device = device;
        self.renewed = Some(Instant::now());
        viewer.warn(format!("{error}; the device was opened again"));
        Ok(())
    }

    fn hear(&mut self, event: WindowEvent) -> Result<()> {
        // The loop may have more events for a window that is given up.
        let (Some(viewer), Ok(())) = (&mut self.viewer, &self.outcome) else { return Ok(()) };
        let response = viewer.input.on_window_event(&viewer.window, &event);
        // After a frame, too, egui asks for one: that would never end.
        if response.repaint && event != WindowEvent::RedrawRequested {
            viewer.window.request_redraw();
        }
        let ctx = viewer.input.egui_ctx();
        let (takes_keys, takes_pointer) = (ctx.wants_keyboard_input(), ctx.wants_pointer_input());
        match event {
            WindowEvent::CloseRequested => viewer.is_done = true,
            WindowEvent::RedrawRequested => viewer.frame()?,
            WindowEvent::Resized(_) | WindowEvent::ScaleFactorChanged { .. } => {
                viewer.window.request_redraw();
            }
            WindowEvent::DroppedFile(path) => viewer.take_file(&path),
            WindowEvent::ModifiersChanged(modifiers) => self.modifiers = modifiers.state(),
            WindowEvent::Focused(false) => {
                viewer.flight.release();
                self.is_dragging = false;
            }
            WindowEvent::KeyboardInput { event, is_synthetic, .. } => {
                let PhysicalKey::Code(code) = event.physical_key else { return Ok(()) };
                let is_down = event.state == ElementState::Pressed;
                let (shift, control) = (self.modifiers.shift_key(), self.modifiers.control_key());
                if !is_down {
                    viewer.flight.key(code, false);
                } else if !takes_keys {
                    // A key that is held, or was when the window got the keyboard, asks for nothing anew.
                    let is_pressed = !event.repeat && !is_synthetic;
                    match action(code, shift, control) {
                        Some(action) if is_pressed || action.goes_on() => viewer.ask(action),
                        Some(_) => {}
                        None if !control => viewer.flight.key(code, true),
                        None => {}
                    }
                }
                viewer.window.request_redraw();
            }
            WindowEvent::MouseInput {
                state,
                button: MouseButton::Left | MouseButton::Right,
                ..
            } => {
                let is_click = self.is_dragging && self.dragged < CLICK_PX;
                self.is_dragging = state == ElementState::Pressed && !takes_pointer;
                if self.is_dragging {
                    self.dragged = 0.0;
                } else if is_click && state == ElementState::Released {
                    viewer.click(self.pointer);
                }
            }
            WindowEvent::CursorMoved { position, .. } => {
                let (x, y) = (position.x, position.y);
                if self.is_dragging {
                    let moved = (x - self.pointer.0, y - self.pointer.1);
                    self.dragged += moved.0.hypot(moved.1);
                    drag(&mut viewer.scene.camera, moved);
                    viewer.window.request_redraw();
                }
                self.pointer = (x, y);
            }
            WindowEvent::MouseWheel { delta, .. } if !takes_pointer => {
                let notches = match delta {
                    MouseScrollDelta::LineDelta(_, lines) => f64::from(lines),
                    MouseScrollDelta::PixelDelta(px) => px.y / 50.0,
                };
                viewer.flight.speed *= 1.25f64.powf(notches);
            }
            _ => {}
        }
        Ok(())
    }
}

impl ApplicationHandler for App {
    fn resumed(&mut self, events: &ActiveEventLoop) {
        let outcome = self.open(events);
        self.expect(events, outcome);
    }

    fn window_event(&mut self, events: &ActiveEventLoop, _: WindowId, event: WindowEvent) {
        let outcome = self.hear(event);
        self.expect(events, outcome);
        if let Some(viewer) = self.viewer.as_ref().filter(|viewer| viewer.is_done) {
            // What is being prepared ends with its step: nobody should see the window wait for that.
            viewer.window.set_visible(false);
            events.exit();
        }
    }

    fn about_to_wait(&mut self, events: &ActiveEventLoop) {
        let Some(viewer) = &self.viewer else { return };
        match viewer.rest() {
            Some(duration) => events.set_control_flow(ControlFlow::wait_duration(duration)),
            None => {
                events.set_control_flow(ControlFlow::Poll);
                viewer.window.request_redraw();
            }
        }
    }

    fn new_events(&mut self, _: &ActiveEventLoop, cause: winit::event::StartCause) {
        if let (winit::event::StartCause::ResumeTimeReached { .. }, Some(viewer)) =
            (cause, &self.viewer)
        {
            viewer.window.request_redraw();
        }
    }
}
