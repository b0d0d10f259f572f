//! Where rain is in a picture: what masks are made of.

use std::path::Path;

use exr::prelude::{AnyChannel, FlatSamples};
use half::f16;

use super::Picture;
use super::layers::{Layers, write_channels};
use crate::Result;

/// Share of red, green and blue in the brightness of linear sRGB.
const BRIGHTNESS: glam::Vec3 = glam::Vec3::new(0.2126, 0.7152, 0.0722);
/// Below this share of the picture's mean brightness a difference counts less.
const DARK: f32 = 0.02;

/// Two measures of single drops, row by row from the top. Both are of a picture against the same picture with all rain as a
/// medium: single drops before haze are told apart from the haze, which the picture without rain lacks, too.
#[derive(Clone, Debug, PartialEq)]
pub struct Masks {
    /// Pixels across.
    pub width: u32,
    /// Pixels down.
    pub height: u32,
    /// Share of the light behind them that single drops take, over what the medium takes: a soft mask, whatever is behind.
    /// Slightly below 0 between drops, as the medium stands for those as well.
    pub opacity: Vec<f32>,
    /// How far the picture's brightness is from the medium's, over the sum of the medium's there and 2 % of the medium's mean:
    /// what an eye, or a network, can see.
    pub contrast: Vec<f32>,
    /// Share of the pixel that drops on a pane cover; empty without a pane. Rain behind them is hidden, and in neither of the others.
    pub glass: Vec<f32>,
}

impl Masks {
    /// The masks of rain, from its layers, those of the same rain as a medium, and what is behind both.
    pub fn of(rain: &Layers, medium: &Layers, behind: &Picture) -> Self {
        let passes = |layers: &Layers| -> Vec<f32> {
            layers.color.iter().map(|[.., opacity]| 1.0 - opacity.to_f32()).collect()
        };
        let light = |layers: &Layers| -> Vec<f32> {
            layers.over(behind).pixels.iter().map(|pixel| pixel.dot(BRIGHTNESS)).collect()
        };
        // Behind a wall of haze there is nothing that drops could take.
        let share =
            |(rain, medium): (f32, f32)| if medium > 0.0 { 1.0 - rain / medium } else { 0.0 };
        let mut opacity: Vec<f32> =
            passes(rain).into_iter().zip(passes(medium)).map(share).collect();
        let glass: Vec<f32> = rain.glass.iter().map(|share| share.to_f32()).collect();
        for (opacity, glass) in opacity.iter_mut().zip(&glass) {
            *opacity *= 1.0 - glass;
        }
        let (rainy, misty) = (light(rain), light(medium));
        let sum: f64 = misty.iter().copied().map(f64::from).sum();
        let floor = DARK * (sum / misty.len().max(1) as f64) as f32;
        let contrast = |(rainy, misty): (&f32, &f32)| match misty + floor {
            0.0 => 0.0,
            over => (rainy - misty).abs() / over,
        };
        let contrast = rainy.iter().zip(&misty).map(contrast).collect();
        Self { width: rain.width, height: rain.height, opacity, contrast, glass }
    }

    /// Writes one EXR with the channels `opacity` and `contrast`, with a pane `pane` too, float16.
    ///
    /// # Errors
    /// [`crate::Error::File`] if it cannot be encoded or written.
    pub fn write_exr(&self, path: &Path) -> Result<()> {
        let half = |value: &f32| f16::from_f32(value.min(f16::MAX.to_f32()));
        let channel = |name: &str, of: &[f32]| {
            AnyChannel::new(name, FlatSamples::F16(of.iter().map(half).collect()))
        };
        let mut channels =
            vec![channel("opacity", &self.opacity), channel("contrast", &self.contrast)];
        if !self.glass.is_empty() {
            channels.push(channel("pane", &self.glass));
        }
        write_channels(path, (self.width, self.height), channels)
    }
}

#[cfg(test)]
mod tests {
    use glam::Vec3;

    use super::*;

    #[test]
    fn drops_are_told_from_the_haze_before_which_they_are() {
        let layers = |colors: [[f32; 4]; 3]| {
            let mut layers = Layers::empty(3, 1);
            layers.color = colors.map(|color| color.map(f16::from_f32)).to_vec();
            layers
        };
        let haze = [0.25, 0.25, 0.25, 0.5];
        // A black drop that takes a quarter of the light, haze alone, a drop that is as bright as the haze.
        let rain = layers([[0.1875, 0.1875, 0.1875, 0.625], haze, [0.375, 0.375, 0.375, 0.75]]);
        let behind = Picture { width: 3, height: 1, pixels: vec![Vec3::splat(0.5); 3] };
        let masks = Masks::of(&rain, &layers([haze; 3]), &behind);
        assert_eq!(masks.opacity, [0.25, 0.0, 0.5]);
        assert!((masks.contrast[0] - 0.125 / (0.5 * 1.02)).abs() < 1e-6, "{masks:?}");
        assert_eq!(masks.contrast[1..], [0.0, 0.0]);
        // A drop on the glass hides half of a drop that covers a quarter.
        let half = Layers { glass: vec![f16::from_f32(0.5); 3], ..rain };
        let masks = Masks::of(&half, &layers([haze; 3]), &behind);
        assert_eq!((masks.opacity, masks.glass), (vec![0.125, 0.0, 0.25], vec![0.5; 3]));
        // In the dark, and where haze takes all.
        let wall = layers([[0.0, 0.0, 0.0, 1.0]; 3]);
        let masks = Masks::of(&wall, &wall, &behind);
        assert_eq!((masks.opacity, masks.contrast), (vec![0.0; 3], vec![0.0; 3]));
    }
}
