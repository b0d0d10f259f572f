//! The presets' colours, the same in every plot.

use plotters::style::RGBColor;

/// Colours of presets (Okabe and Ito 2008: told apart by everyone), in the order in which a report's page numbers them.
pub(crate) const PRESETS: [(&str, RGBColor); 5] = [
    ("paper", RGBColor(0, 114, 178)),
    ("fast", RGBColor(213, 94, 0)),
    ("exact", RGBColor(0, 158, 115)),
    ("paper-compact", RGBColor(204, 121, 167)),
    ("auto", RGBColor(0, 0, 0)),
];

/// The colour of a preset.
pub(crate) fn of_preset(name: &str) -> RGBColor {
    let found = PRESETS.iter().find(|(preset, _)| *preset == name);
    found.map_or(RGBColor(110, 110, 110), |(_, color)| *color)
}

#[cfg(test)]
mod tests {
    use clap::ValueEnum;

    use super::*;
    use crate::scene::model::Preset;

    #[test]
    fn every_preset_has_a_colour_of_its_own() {
        let mut seen = Vec::new();
        for preset in Preset::value_variants() {
            let color = of_preset(&preset.to_string());
            assert!(PRESETS.iter().any(|(name, _)| *name == preset.to_string()), "{preset}");
            assert!(!seen.contains(&color), "{preset} has another's colour");
            seen.push(color);
        }
    }
}
