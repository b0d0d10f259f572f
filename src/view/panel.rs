//! The panel over the picture: what is drawn and what it costs, and the controls for it.

use std::time::Duration;

use clap::ValueEnum;
use egui::{Align2, Area, Color32, Context, Frame, RichText, Ui};
use indexmap::IndexSet;

use super::clock::Clock;
use super::focus::lens;
use super::glass::glass;
use super::history::History;
use super::keys::{Action, HELP};
use super::prepare::Pane;
use super::stage::Difference;
use super::weather::{shutter, weather};
use crate::plan::FramePlan;
use crate::scene::model::Preset;
use crate::scene::{EnvironmentChoice, MAX_DROPS, ModelChoice, Scene};
use crate::thousands::thousands;

/// The panel's title, and its area's name.
pub const TITLE: &str = "raindrops";
/// Width of the panel in points.
const WIDTH: f32 = 316.0;

/// Height of the history graph in points.
const GRAPH_HEIGHT: f32 = 44.0;

/// Colours of a warning and of the frame times.
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
    // Below the title, above the window's edge.
    let height = (ctx.content_rect().height() - 76.0).max(64.0);
    egui::Window::new(TITLE).frame(frame).default_pos([12.0, 12.0]).resizable(false).show(
        ctx,
        |ui| {
            ui.set_width(WIDTH);
            ui.style_mut().spacing.slider_width = 140.0;
            ui.style_mut().spacing.item_spacing.y = 2.0;
            egui::ScrollArea::vertical().max_height(height).min_scrolled_height(height).show(
                ui,
                |ui| {
                    speed(ui, facts);
                    section(ui, "Time", true, |ui| time(ui, controls));
                    section(ui, "Rain and light", true, |ui| scene(ui, controls, facts));
                    section(ui, "Models", true, |ui| models(ui, controls, facts));
                    section(ui, "What each pass is for", false, |ui| reasons(ui, facts));
                    section(ui, "Keys", false, keys);
                },
            );
        },
    );
}

fn section(ui: &mut Ui, title: &str, open: bool, content: impl FnOnce(&mut Ui)) {
    egui::CollapsingHeader::new(title).default_open(open).show(ui, content);
}

/// Frame rate, history, passes.
fn speed(ui: &mut Ui, facts: &Facts<'_>) {
    let Facts { history, size, .. } = facts;
    ui.label(RichText::new(facts.device).small());
    ui.horizontal(|ui| {
        if let Some(ms) = history.median_ms() {
            ui.heading(format!("{:.0} FPS", 1e3 / ms));
            ui.label(format!("{ms:.1} ms a frame, {} x {}", size.0, size.1));
        }
    });
    graph(ui, history);
    let panes = facts.panes;
    egui::Grid::new("passes").striped(true).num_columns(1 + panes.len()).show(ui, |ui| {
        ui.label("drops in view");
        for pane in panes {
            right(ui, thousands(pane.report.counts.visible));
        }
        ui.end_row();
        // The second model may have passes that the first has not.
        let passes = panes.iter().flat_map(|pane| &pane.report.passes_ms);
        let names: IndexSet<&str> = passes.map(|(name, _)| *name).collect();
        for name in names {
            ui.label(name);
            for pane in panes {
                let ms = pane.report.passes_ms.iter().find(|(pass, _)| *pass == name);
                right(ui, ms.map_or("-".into(), |(_, ms)| format!("{ms:.2} ms")));
            }
            ui.end_row();
        }
        for (name, ms) in facts.window_ms {
            ui.label(format!("window: {name}"));
            right(ui, format!("{ms:.2} ms"));
            ui.end_row();
        }
    });
}

/// A figure in a column of figures.
fn right(ui: &mut Ui, text: String) {
    ui.with_layout(egui::Layout::right_to_left(egui::Align::Center), |ui| ui.monospace(text));
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
        let line = egui::Stroke::new(1.0_f32, Color32::from_white_alpha(70));
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
    weather(ui, scene);
    shutter(ui, scene);
    lens(ui, scene);
    glass(ui, scene);
    if let Some(rain) = scene.rain.as_mut().filter(|rain| rain.real.is_none()) {
        ui.horizontal(|ui| {
            let is_one = rain.others.iter().all(Option::is_none);
            ui.label(if is_one { "drops" } else { "drops of the first [[rain]]" });
            let mut count = controls.drops.unwrap_or(rain.count);
            let slider = egui::Slider::new(&mut count, 0..=MAX_DROPS.min(8_000_000));
            let slider = slider
                .custom_formatter(|number, _| thousands(number as u64))
                .custom_parser(|text| text.replace(',', "").parse().ok());
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
        let tone_map = &mut scene.tone_map;
        let (name, value, range) = match &mut tone_map.exposure {
            Some(fixed) => ("exposure (fixed)", fixed, 1e-6..=1e6),
            None => ("exposure (key)", &mut tone_map.key, 0.01..=4.0),
        };
        ui.label(name);
        ui.add(egui::Slider::new(value, range).logarithmic(true));
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
    let mut chosen: Vec<&mut ModelChoice> = vec![&mut controls.scene.model];
    chosen.extend(controls.second.as_mut());
    let mut columns: Vec<Column<'_>> = chosen
        .into_iter()
        .enumerate()
        .map(|(number, model)| (model, facts.panes.get(number).map(|pane| &pane.plan)))
        .collect();
    egui::Grid::new("models").num_columns(1 + columns.len()).show(ui, |ui| {
        ui.label("preset");
        for (number, (model, _)) in columns.iter_mut().enumerate() {
            let before = model.preset;
            combo(ui, number, before.name(), |ui| {
                for preset in Preset::value_variants() {
                    ui.selectable_value(&mut model.preset, *preset, preset.name());
                }
            });
            if model.preset != before {
                // What was chosen for one preset rarely goes with another.
                **model = ModelChoice { preset: model.preset, ..ModelChoice::default() };
            }
        }
        ui.end_row();
        let all = &mut columns;
        axis(ui, "optics", all, |model| &mut model.optics, |plan| plan.optics);
        axis(ui, "primitive", all, |model| &mut model.primitive, |plan| plan.primitive);
        axis(ui, "order", all, |model| &mut model.order, |plan| plan.order);
        axis(ui, "simulation", all, |model| &mut model.simulation, |plan| plan.simulation);
        axis(ui, "weights", all, |model| &mut model.weights, |plan| plan.light.weights);
        axis(ui, "Fresnel", all, |model| &mut model.fresnel, |plan| plan.light.fresnel);
        axis(ui, "reflection", all, |model| &mut model.reflection, |plan| plan.light.reflection);
        axis(ui, "lookup", all, |model| &mut model.lookup, |plan| plan.light.lookup);
        number(ui, "samples", all, 1..=64, |model| &mut model.samples, |plan| plan.samples);
        let orders = |plan: &FramePlan| plan.light.internal_reflections;
        number(
            ui,
            "reflections inside",
            all,
            0..=8,
            |model| &mut model.internal_reflections,
            orders,
        );
    });
    let mut is_split = columns.len() > 1;
    if ui.checkbox(&mut is_split, "a second model, and the difference x 8").changed() {
        controls.actions.push(Action::Split);
    }
    if is_split {
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

/// A model that is chosen, and the plan that was made of it.
type Column<'a> = (&'a mut ModelChoice, Option<&'a FramePlan>);

/// A box that opens onto choices; `id` tells those of a row apart.
fn combo(
    ui: &mut Ui,
    id: impl std::hash::Hash,
    text: impl Into<egui::WidgetText>,
    choices: impl FnOnce(&mut Ui),
) {
    egui::ComboBox::from_id_salt(id).width(96.0).selected_text(text).show_ui(ui, choices);
}

/// A row with one axis of every model. What is left to the preset is shown in grey, as planned.
fn axis<T: ValueEnum + Copy + PartialEq + std::fmt::Display>(
    ui: &mut Ui,
    name: &str,
    columns: &mut [Column<'_>],
    value: impl Fn(&mut ModelChoice) -> &mut Option<T>,
    planned: impl Fn(&FramePlan) -> T,
) {
    ui.label(name);
    for (number, (model, plan)) in columns.iter_mut().enumerate() {
        let value = value(model);
        let text = match (*value, plan) {
            (Some(value), _) => RichText::new(value.to_string()),
            (None, Some(plan)) => RichText::new(planned(plan).to_string()).color(Color32::GRAY),
            (None, None) => RichText::new("by preset").color(Color32::GRAY),
        };
        combo(ui, (name, number), text, |ui| {
            ui.selectable_value(value, None, "by preset");
            for variant in T::value_variants() {
                ui.selectable_value(value, Some(*variant), variant.to_string());
            }
        });
    }
    ui.end_row();
}

/// A row of the panel for an axis that is a number.
fn number(
    ui: &mut Ui,
    name: &str,
    columns: &mut [Column<'_>],
    range: std::ops::RangeInclusive<u32>,
    value: impl Fn(&mut ModelChoice) -> &mut Option<u32>,
    planned: impl Fn(&FramePlan) -> u32,
) {
    ui.label(name);
    for (model, plan) in columns {
        let value = value(model);
        ui.horizontal(|ui| {
            let mut shown = value.or(plan.map(&planned)).unwrap_or(*range.start());
            if ui.add(egui::DragValue::new(&mut shown).range(range.clone()).speed(0.1)).changed() {
                *value = Some(shown);
            }
            if value.is_some() && ui.small_button("by preset").clicked() {
                *value = None;
            }
        });
    }
    ui.end_row();
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

/// Draws the lines at the window's lower edge, if there are any: what is waited for, with its time so far, and a message.
pub fn messages(ctx: &Context, message: Option<&str>, waits_for: Option<&(String, Duration)>) {
    if message.is_none() && waits_for.is_none() {
        return;
    }
    let lines = |ui: &mut Ui| {
        if let Some((step, since)) = waits_for {
            ui.horizontal(|ui| {
                ui.spinner();
                ui.label(format!("{step}, {:.0} s", since.as_secs_f32().floor()));
            });
        }
        if let Some(message) = message {
            ui.label(message);
        }
    };
    let area = Area::new("message".into()).anchor(Align2::CENTER_BOTTOM, [0.0, -16.0]);
    area.show(ctx, |ui| Frame::popup(ui.style()).show(ui, lines));
}
