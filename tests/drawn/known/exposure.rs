//! The photographic operator's exposure: of the pixels in the image alone, whatever its shape.

use raindrops::environment::Environment;
use raindrops::plan::Output;
use raindrops::scene::ImageSize;
use raindrops::scene::model::Preset;

use super::placed;
use crate::common::picture::renderer_of;
use crate::common::{on_device, painted};

/// sRGB's transfer function, 0 to 1.
fn encoded(linear: f64) -> f64 {
    if linear <= 0.003_130_8 { 12.92 * linear } else { 1.055 * linear.powf(1.0 / 2.4) - 0.055 }
}

/// Images that end within a tile of 4 x 2 pixels, and one that does not: grey, so that a colour is its luminance.
#[test]
fn it_is_that_of_the_pixels_in_the_image() {
    on_device(|device| {
        let sky: Environment = painted(64, |d| glam::Vec3::splat((3.0 * d.y) as f32).exp());
        let sizes = [(1, 1), (2, 1), (5, 3), (6, 1), (1, 3), (33, 17), (64, 32), (131, 7)];
        for (preset, (width, height)) in
            [Preset::Fast, Preset::Paper].into_iter().flat_map(|p| sizes.map(|size| (p, size)))
        {
            let mut scene = placed([(glam::DVec3::new(0.3, 0.2, -6.0), 1.0)], 1);
            scene.image = ImageSize { width, height };
            scene.model.preset = preset;
            scene.tone_map.key = 0.3;
            let mut renderer = renderer_of(device, &scene, &sky, Output::Display);
            renderer.submit(&scene).expect("a frame");
            let radiance: Vec<f64> = {
                let picture = renderer.read_radiance().expect("radiance");
                picture.pixels.iter().map(|pixel| f64::from(pixel.y)).collect()
            };
            let logs = radiance.iter().map(|light| light.ln()).sum::<f64>();
            let scale = 0.3 / (logs / radiance.len() as f64).exp();
            let shown = renderer.read_display().expect("display");
            for (light, bytes) in radiance.iter().zip(shown.chunks_exact(3)) {
                let expected = 255.0 * encoded(light * scale / (1.0 + light * scale));
                // Half a step of 8 bits, as much again for float16 and the logarithms.
                let off = (f64::from(bytes[1]) - expected).abs();
                assert!(off < 1.0, "{preset}, {width} x {height}: {} for {expected}", bytes[1]);
            }
        }
    });
}
