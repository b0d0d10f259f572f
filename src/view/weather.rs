//! The panel's controls of real rain: how much falls, drops of which sizes, the wind, and what is left to the medium;
//! and of the shutter.

use egui::Ui;

use crate::scene::model::Preset;
use crate::scene::real_rain::RealRain;
use crate::scene::{RainSettings, Scene};

/// Rate in mm/h of the rain that the button makes: heavy rain, not a cloudburst.
const RATE: f64 = 25.0;

/// Sliders for the real rain of `scene`, or a button that makes some. Each new value is another rain, for which much is
/// made anew: so it is taken when its slider is let go.
pub(super) fn weather(ui: &mut Ui, scene: &mut Scene) {
    let Some(mut rain) = scene.real_rain() else {
        if ui.button("real rain").on_hover_text("drops of all sizes, by mm/h").clicked() {
            scene.rain = Some(RainSettings::of(RealRain { rate: RATE, ..RealRain::default() }));
            if matches!(scene.model.preset, Preset::Paper | Preset::PaperCompact) {
                scene.model.take_preset(Preset::Fast);
            }
        }
        return;
    };
    let before = rain;
    held(ui, "rate", &mut rain.rate, 0.1..=300.0, " mm/h");
    let [least, largest] = &mut rain.diameters;
    held(ui, "least drops", least, 0.05..=0.9 * *largest, " mm");
    held(ui, "largest drops", largest, 1.1 * *least..=8.0, " mm");
    held(ui, "wind to the right", &mut rain.wind.x, -30.0..=30.0, " m/s");
    held(ui, "wind to the back", &mut rain.wind.z, -30.0..=30.0, " m/s");
    if rain != before {
        scene.rain = Some(RainSettings::of(rain));
    }
    let mut cutoff = scene.model.cutoff_px.unwrap_or(0.05);
    let was = cutoff;
    held(ui, "single drops from", &mut cutoff, 0.02..=1.0, " px");
    if cutoff != was {
        scene.model.cutoff_px = Some(cutoff);
    }
}

/// For how long the shutter is open. Slow motion shortens what it shows.
pub(super) fn shutter(ui: &mut Ui, scene: &mut Scene) {
    ui.horizontal(|ui| {
        ui.label("shutter");
        let mut seconds = scene.shutter();
        let slider = egui::Slider::new(&mut seconds, 0.0..=0.1).logarithmic(true);
        let slider = slider.smallest_positive(1e-5).suffix(" s");
        if ui.add(slider).on_hover_text("0: an instant").changed() {
            (scene.camera.shutter, scene.camera.shutter_angle) = (seconds, None);
        }
    });
}

/// A slider whose value is taken when it is let go.
pub(super) fn held(
    ui: &mut Ui,
    name: &str,
    value: &mut f64,
    range: std::ops::RangeInclusive<f64>,
    unit: &str,
) {
    ui.horizontal(|ui| {
        ui.label(name);
        let id = ui.id().with(name);
        let mut shown = ui.data(|data| data.get_temp::<f64>(id)).unwrap_or(*value);
        let is_logarithmic = *range.start() > 0.0;
        let slider = egui::Slider::new(&mut shown, range).logarithmic(is_logarithmic).suffix(unit);
        let response = ui.add(slider);
        if response.changed() {
            ui.data_mut(|data| data.insert_temp(id, shown));
        }
        if !response.dragged() && !response.has_focus() {
            *value = ui.data_mut(|data| data.remove_temp::<f64>(id)).unwrap_or(*value);
        }
    });
}
