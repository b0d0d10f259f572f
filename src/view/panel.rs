//! The panel over the picture: what is drawn and what it costs, and the controls for it.

use clap::ValueEnum;
use egui::{Color32, RichText, Ui};

use super::clock::Clock;
use super::history::History;
use super::keys::{Action, HELP};
use super::stage::{Difference, Pane};
use crate::bench::thousands;
use crate::model::Preset;
use crate::plan::FramePlan;
use crate::scene::{EnvironmentChoice, MAX_DROPS, ModelChoice, Scene};

/// Width of the panel in points.
const WIDTH: f32 = 286.0;

/// Height of the history graph in points.
const GRAPH_HEIGHT: f32 = 44.0;

/// Colours of what is told: a warning, and the first and the second model.
const WARNING: Color32 = Color32::from_rgb(255, 190, 90);
const BARS: Color32 = Color32::from_rgb(110, 180, 255);

/// What the panel can change.
pub struct Controls<'a> {
    /// What is shown; its time is the clock's.
    pub scene: &'a mut Scene,
    /// The model beside it.
    pub second: &'a mut Option<ModelChoice>,
    /// Scene time.
    pub clock: &'a mut Clock,
    /// Scene units a second.
    pub speed: &'a mut f64,
    /// The number of drops while its slider is moved: a renderer is made only when it is let go.
    pub drops: &'a mut Option<u32>,
    /// What buttons ask for.
    pub actions: &'a mut Vec<Action>,
}

/// What the panel tells.
pub struct Facts<'a> {
    /// Device and driver.
    pub device: &'a str,
    /// Size of the window in pixels.
    pub size: (u32, u32),
    /// Frame times.
    pub history: &'a History,
    /// What is drawn: one, or two side by side.
    pub panes: &'a [Pane],
    /// The window's own passes.
    pub window_ms: &'a [(&'static str, f64)],
    /// The environment's name.
    pub environment: &'a str,
    /// Environments that can be chosen.
    pub environments: &'a [(String, EnvironmentChoice)],
    /// How the two models differ, once measured.
    pub difference: Option<Difference>,
    /// Why the models asked for are not drawn.
    pub problem: Option<&'a str>,
}

/// Lays out the panel.
pub fn panel(ctx: &egui::Context, controls: &mut Controls<'_>, facts: &Facts<'_>) {
    let frame = egui::Frame::window(&ctx.style()).fill(Color32::from_black_alpha(215));
    egui::Window::new("raindrops")
        .frame(frame)
        .default_pos([12.0, 12.0])
        .default_size([WIDTH, 2000.0])
        .resizable(false)
        .vscroll(true)
        .max_height(ctx.content_rect().height() - 24.0)
        .show(ctx, |ui| {
            ui.set_width(WIDTH);
            ui.style_mut().spacing.slider_width = 140.0;
            speed(ui, facts);
            section(ui, "Time", true, |ui| time(ui, controls));
            section(ui, "Rain and light", true, |ui| scene(ui, controls, facts));
            section(ui, "Models", true, |ui| models(ui, controls, facts));
            section(ui, "What each pass is for", false, |ui| reasons(ui, facts));
            section(ui, "Keys", false, keys);
        });
}

fn section(ui: &mut Ui, title: &str, open: bool, content: impl FnOnce(&mut Ui)) {
    egui::CollapsingHeader::new(title).default_open(open).show(ui, content);
}

/// Frame rate, history, passes.
fn speed(ui: &mut Ui, facts: &Facts<'_>) {
    let Facts { history, size, .. } = facts;
    ui.label(RichText::new(facts.device).small().weak());
    ui.horizontal(|ui| {
        if let Some(ms) = history.median_ms() {
            ui.heading(format!("{:.0} FPS", 1e3 / ms));
            ui.label(format!("{ms:.1} ms a frame, {} x {}", size.0, size.1));
        }
    });
    graph(ui, history);
    for pane in facts.panes {
        let counts = &pane.report.counts;
        ui.label(format!("{}: {} drops in view", pane.plan.preset, thousands(counts.visible)));
    }
    egui::Grid::new("passes").striped(true).show(ui, |ui| {
        let window = facts.window_ms.iter();
        for (name, ms) in facts.panes.iter().flat_map(|p| &p.report.passes_ms).chain(window) {
            ui.label(*name);
            ui.with_layout(egui::Layout::right_to_left(egui::Align::Center), |ui| {
                ui.monospace(format!("{ms:7.2} ms"));
            });
            ui.end_row();
        }
    });
}

/// Frame times as bars, the newest to the right, with lines at 60 and 30 frames a second.
fn graph(ui: &mut Ui, history: &History) {
    let (area, _) = ui.allocate_exact_size(egui::vec2(WIDTH, GRAPH_HEIGHT), egui::Sense::hover());
    let painter = ui.painter_at(area);
    painter.rect_filled(area, 2.0, Color32::from_white_alpha(10));
    // A frame for which renderers were made would flatten all others.
    let most_ms = (2.5 * history.median_ms().unwrap_or(0.0)).max(1e3 / 30.0);
    let height = |ms: f32| area.bottom() - area.height() * ms / most_ms;
    let width = area.width() / history.frames_ms().len().max(160) as f32;
    for (age, ms) in history.frames_ms().rev().enumerate() {
        let right = area.right() - age as f32 * width;
        let bar = egui::Rect::from_x_y_ranges(
            right - width..=right,
            height(ms).max(area.top())..=area.bottom(),
        );
        painter.rect_filled(bar, 0.0, BARS);
    }
    for fps in [60.0, 30.0] {
        let line = egui::Stroke::new(1.0, Color32::from_white_alpha(70));
        painter.hline(area.x_range(), height(1e3 / fps), line);
    }
    let most = format!("{most_ms:.0} ms");
    let font = egui::FontId::proportional(9.0);
    painter.text(area.left_top(), egui::Align2::LEFT_TOP, most, font, Color32::GRAY);
}

fn time(ui: &mut Ui, controls: &mut Controls<'_>) {
    let clock = &mut *controls.clock;
    ui.horizontal(|ui| {
        let mut button = |text: &str, hint: &str, action| {
            if ui.button(text).on_hover_text(hint).clicked() {
                controls.actions.push(action);
            }
        };
        button("⏮", "to where time began", Action::Rewind);
        button("⏪", "backwards", Action::Reverse);
        button("-1", "one step back", Action::Step { forward: false });
        button(if clock.paused { "▶" } else { "⏸" }, "stop or go on", Action::Pause);
        button("+1", "one step on", Action::Step { forward: true });
        button("slower", "down to 1/1000", Action::Rate { faster: false });
        button("faster", "", Action::Rate { faster: true });
    });
    let state = match (clock.paused, clock.backwards) {
        (true, _) => "stopped",
        (false, true) => "backwards",
        (false, false) => "running",
    };
    let rate = clock.rate();
    let rate = if rate < 1.0 { format!("1/{:.0}", 1.0 / rate) } else { format!("{rate:.0}") };
    ui.label(format!("{:.6} s, {state}, speed {rate}", clock.seconds()));
}

fn scene(ui: &mut Ui, controls: &mut Controls<'_>, facts: &Facts<'_>) {
    let scene = &mut *controls.scene;
    if let Some(rain) = &mut scene.rain {
        ui.horizontal(|ui| {
            ui.label("drops");
            let mut count = controls.drops.unwrap_or(rain.count);
            let slider = egui::Slider::new(&mut count, 0..=MAX_DROPS.min(8_000_000));
            let response = ui.add(slider.logarithmic(true));
            if response.changed() {
                *controls.drops = Some(count);
            }
            if !response.dragged() && !response.has_focus() {
                rain.count = controls.drops.take().unwrap_or(rain.count);
            }
        });
    }
    ui.horizontal(|ui| {
        ui.label("exposure (key)");
        let key = &mut scene.tone_map.key;
        ui.add(egui::Slider::new(key, 0.01..=4.0).logarithmic(true));
    });
    choice(ui, "operator", &mut scene.tone_map.operator);
    ui.horizontal(|ui| {
        ui.label("environment");
        egui::ComboBox::from_id_salt("environment").selected_text(facts.environment).show_ui(
            ui,
            |ui| {
                for (name, environment) in facts.environments {
                    if ui.selectable_label(scene.environment == *environment, name).clicked() {
                        scene.environment = environment.clone();
                    }
                }
            },
        );
    })
    .response
    .on_hover_text("or drop an EXR, HDR, PNG or JPEG file on the window");
    ui.horizontal(|ui| {
        ui.label("field of view");
        ui.add(egui::Slider::new(&mut scene.camera.vertical_fov, 2.0..=120.0).suffix("°"));
    });
    ui.horizontal(|ui| {
        ui.label("flight");
        let slider = egui::Slider::new(controls.speed, 1e-3..=1e4).logarithmic(true);
        ui.add(slider.suffix(" units/s"));
    });
}

fn models(ui: &mut Ui, controls: &mut Controls<'_>, facts: &Facts<'_>) {
    if let Some(problem) = facts.problem {
        ui.colored_label(WARNING, problem);
    }
    let plan = |number: usize| facts.panes.get(number).map(|pane| &pane.plan);
    model(ui, "first", &mut controls.scene.model, plan(0));
    let mut is_split = controls.second.is_some();
    if ui.checkbox(&mut is_split, "beside it a second model, and the difference x 8").changed() {
        controls.actions.push(Action::Split);
    }
    if let Some(second) = controls.second {
        model(ui, "second", second, plan(1));
        ui.horizontal(|ui| {
            if ui.button("measure").clicked() {
                controls.actions.push(Action::Measure);
            }
            if let Some(Difference { flip, largest }) = facts.difference {
                ui.label(format!("FLIP {flip:.4}, largest {largest}/255"));
            }
        });
    }
}

/// Every axis of the models. Left to the preset, an axis shows what the plan made of it.
fn model(ui: &mut Ui, id: &str, model: &mut ModelChoice, plan: Option<&FramePlan>) {
    ui.push_id(id, |ui| {
        let before = model.preset;
        choice(ui, "preset", &mut model.preset);
        if model.preset != before {
            // What was chosen for one preset rarely goes with another.
            *model = ModelChoice { preset: model.preset, ..ModelChoice::default() };
        }
        axis(ui, "optics", &mut model.optics, plan.map(|plan| plan.optics));
        axis(ui, "primitive", &mut model.primitive, plan.map(|plan| plan.primitive));
        axis(ui, "order", &mut model.order, plan.map(|plan| plan.order));
        axis(ui, "simulation", &mut model.simulation, plan.map(|plan| plan.simulation));
        number(ui, "samples", &mut model.samples, plan.map(|plan| plan.samples), 1..=64);
        let light = plan.map(|plan| plan.light);
        let orders = light.map(|light| light.internal_reflections);
        number(ui, "internal reflections", &mut model.internal_reflections, orders, 0..=8);
        axis(ui, "weights", &mut model.weights, light.map(|light| light.weights));
        axis(ui, "fresnel", &mut model.fresnel, light.map(|light| light.fresnel));
        axis(ui, "reflection", &mut model.reflection, light.map(|light| light.reflection));
        axis(ui, "lookup", &mut model.lookup, light.map(|light| light.lookup));
    });
}

/// A choice of one of all models of an axis.
fn choice<T: ValueEnum + Copy + PartialEq + std::fmt::Display>(
    ui: &mut Ui,
    name: &str,
    value: &mut T,
) {
    ui.horizontal(|ui| {
        ui.label(name);
        for variant in T::value_variants() {
            ui.selectable_value(value, *variant, variant.to_string());
        }
    });
}

/// The same, with the preset's own among them.
fn axis<T: ValueEnum + Copy + PartialEq + std::fmt::Display>(
    ui: &mut Ui,
    name: &str,
    value: &mut Option<T>,
    planned: Option<T>,
) {
    let by_preset = planned.map_or("by preset".into(), |planned| format!("{planned} (by preset)"));
    ui.horizontal(|ui| {
        ui.label(name);
        let text = value.map_or(by_preset.clone(), |value| value.to_string());
        egui::ComboBox::from_id_salt(name).selected_text(text).show_ui(ui, |ui| {
            ui.selectable_value(value, None, "by preset");
            for variant in T::value_variants() {
                ui.selectable_value(value, Some(*variant), variant.to_string());
            }
        });
    });
}

/// A number that the preset chooses unless it is moved.
fn number(
    ui: &mut Ui,
    name: &str,
    value: &mut Option<u32>,
    planned: Option<u32>,
    range: std::ops::RangeInclusive<u32>,
) {
    ui.horizontal(|ui| {
        ui.label(name);
        let mut shown = value.or(planned).unwrap_or(*range.start());
        if ui.add(egui::DragValue::new(&mut shown).range(range).speed(0.1)).changed() {
            *value = Some(shown);
        }
        if value.is_some() && ui.small_button("by preset").clicked() {
            *value = None;
        }
    });
}

fn reasons(ui: &mut Ui, facts: &Facts<'_>) {
    for pane in facts.panes {
        ui.strong(pane.plan.preset.to_string());
        for (name, reason) in &pane.plan.passes {
            ui.label(RichText::new(format!("{name}: {reason}")).small());
        }
    }
}

fn keys(ui: &mut Ui) {
    egui::Grid::new("keys").show(ui, |ui| {
        for (key, what) in HELP {
            ui.monospace(key);
            ui.label(RichText::new(what).small());
            ui.end_row();
        }
    });
}

/// The preset of a number, as the keys 1, 2, 3 … choose it.
pub fn preset(number: usize) -> Option<Preset> {
    Preset::value_variants().get(number).copied()
}
