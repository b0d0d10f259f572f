//! Values of the environment, many layers, and the tone map at its ends.

use glam::{DVec3, Vec3};
use raindrops::environment::Environment;
use raindrops::environment::guess::Guess;
use raindrops::picture::Picture;
use raindrops::picture::metrics::rel_mse;
use raindrops::plan::Output;
use raindrops::scene::model::Preset;
use raindrops::scene::{RainSettings, Scene};

use super::{PRESETS, draw, placed, smooth, sum, truth};
use crate::common::picture::renderer_of;
use crate::common::{hole, on_device, painted};

/// A few drops of all sizes.
fn scene() -> Scene {
    let mut scene = placed(&[(DVec3::new(0.4, 0.2, -3.0), 1.0)], (48, 32));
    let half_extent = DVec3::splat(30.0);
    scene.rain = Some(RainSettings { count: 500, half_extent, ..Default::default() });
    scene
}

fn display(
    device: &std::sync::Arc<raindrops::gpu::Device>,
    scene: &Scene,
    environment: &Environment,
    preset: Preset,
) -> Vec<u8> {
    let mut scene = scene.clone();
    scene.model.preset = preset;
    let mut renderer = renderer_of(device, &scene, environment, Output::Display);
    renderer.submit(&scene).expect("a frame");
    renderer.read_display().expect("display")
}

/// A white furnace at any radiance that float32 holds: the same picture, scaled.
#[test]
fn a_furnace_of_any_radiance() {
    on_device(|device| {
        let scene = scene();
        for preset in PRESETS {
            let reference = display(device, &scene, &Environment::constant(Vec3::ONE), preset);
            for radiance in [1e-38f32, 1e30] {
                let furnace = Environment::constant(Vec3::splat(radiance));
                let (picture, _) = draw(device, &scene, &furnace, preset);
                let off = picture
                    .pixels
                    .iter()
                    .map(|pixel| (*pixel / radiance - 1.0).abs().max_element())
                    .fold(0.0, f32::max);
                println!("{preset}, radiance {radiance:e}: off by {off:.1e}");
                assert!(off < 4e-3, "{preset}, radiance {radiance:e}: off by {off}");
                let shown = display(device, &scene, &furnace, preset);
                let step = |(a, b): (&u8, &u8)| a.abs_diff(*b);
                let most = shown.iter().zip(&reference).map(step).max();
                assert!(most <= Some(1), "{preset}, radiance {radiance:e}: {most:?} of 255");
            }
            // Denormals of float32: whatever a driver makes of them, no more than a little light.
            let furnace = Environment::constant(Vec3::splat(1e-40));
            let (picture, _) = draw(device, &scene, &furnace, preset);
            assert!(picture.pixels.iter().all(|pixel| pixel.max_element() < 2e-40), "{preset}");
        }
    });
}

#[test]
fn all_black_stays_black() {
    on_device(|device| {
        let black = Environment::constant(Vec3::ZERO);
        for preset in PRESETS {
            let (picture, _) = draw(device, &scene(), &black, preset);
            assert!(picture.pixels.iter().all(|pixel| *pixel == Vec3::ZERO), "{preset}");
            let shown = display(device, &scene(), &black, preset);
            assert!(shown.iter().all(|byte| *byte == 0), "{preset}: black is shown as black");
        }
    });
}

/// The light of a lamp alone, whose surroundings are 0: the average of their logarithms is no reason to show nothing.
#[test]
fn a_lamp_in_the_dark_is_shown() {
    on_device(|device| {
        let mut texels = vec![Vec3::ZERO; 128 * 64];
        texels[128 * 30 + 64] = Vec3::splat(1e5);
        let lamp = Environment::from_texels("lamp", 128, 64, texels).expect("an environment");
        for preset in PRESETS {
            let shown = display(device, &scene(), &lamp, preset);
            let lit = shown.iter().filter(|byte| **byte > 200).count();
            println!("{preset}: {lit} bytes are bright");
            assert!(lit > 10 && lit < shown.len() / 2, "{preset}: {lit} bytes are bright");
        }
    });
}

/// What a file may hold that is no radiance: mended, counted, and drawn without a trace of it.
#[test]
fn broken_texels_leave_no_trace() {
    on_device(|device| {
        let clean = smooth();
        let mut texels = clean.texels().to_vec();
        texels[128 * 31 + 64] = Vec3::NAN;
        texels[128 * 40 + 10] = Vec3::new(f32::INFINITY, f32::NAN, 1.0);
        texels[128 * 20 + 90] = Vec3::splat(f32::NEG_INFINITY);
        let mended = Environment::from_texels("broken", 128, 64, texels.clone()).expect("mended");
        assert_eq!((mended.mended().non_finite, mended.mended().negative), (3, 0));
        texels[5] = Vec3::new(-3.0, 1.0, 1.0);
        let negative = Environment::from_texels("broken", 128, 64, texels).expect("mended");
        assert_eq!(negative.mended().negative, 1);
        for preset in PRESETS {
            let clean = draw(device, &scene(), &clean, preset).0;
            let off = rel_mse(&clean, &draw(device, &scene(), &mended, preset).0, None);
            assert!(off < 1e-5, "{preset}: {off}");
            draw(device, &scene(), &negative, preset);
        }
    });
}

/// One texel of 10⁹ in a dim environment: all finite, its light not lost, the rest not crushed.
#[test]
fn one_bright_texel() {
    on_device(|device| {
        let mut texels = vec![Vec3::ONE; 128 * 64];
        texels[128 * 28 + 66] = Vec3::splat(1e9);
        let sun = Environment::from_texels("sun", 128, 64, texels).expect("an image");
        let mut scene = placed(&[], (64, 64));
        scene.camera.vertical_fov = 60.0;
        for preset in PRESETS {
            let (picture, _) = draw(device, &scene, &sun, preset);
            let most = picture.pixels.iter().map(|pixel| pixel.x).fold(0.0, f32::max);
            let least = picture.pixels.iter().map(|pixel| pixel.x).fold(f32::INFINITY, f32::min);
            println!("{preset}: {least} to {most:e}");
            assert!(most > 1e7, "{preset}: the sun is lost");
            // Stored over 2^15 the rest is a float16 denormal: a step is 2^-24 of 32,768.
            assert!((least - 1.0).abs() < 2e-3, "{preset}: the rest is {least}");
            let shown = display(device, &scene, &sun, preset);
            assert!(shown.contains(&255), "{preset}: the sun is not shown");
        }
    });
}

/// A sky of 0.2 to 1 times `unit`, and single texels of `radiance` in it: in view, and where drops show them.
fn sky_with_suns(width: u32, unit: f32, suns: usize, radiance: f32) -> Environment {
    let height = width / 2;
    let texels = (0..width * height).map(|index| {
        let height = (index / width) as f32 / height as f32;
        Vec3::new(0.2, 0.6 - 0.4 * height, 1.0 - 0.8 * height) * unit
    });
    let mut texels: Vec<Vec3> = texels.collect();
    // In parts of the image from its left and upper edge.
    for (x, y) in [(0.52, 0.44), (0.9, 0.3), (0.2, 0.6), (0.05, 0.5), (0.7, 0.8)].iter().take(suns)
    {
        let (column, row) = ((x * f64::from(width)) as u32, (y * f64::from(height)) as u32);
        texels[(row * width + column) as usize] = Vec3::splat(radiance);
    }
    Environment::from_texels("suns", width, height, texels).expect("an environment")
}

/// However bright single texels are, what is beside them keeps its light: one that is too wide a source to be taken out
/// of the texture, and one more than are taken out.
#[test]
fn no_texel_changes_the_sky_beside_it() {
    const PRESETS: [Preset; 4] = [Preset::Paper, Preset::Fast, Preset::Exact, Preset::Auto];
    on_device(|device| {
        let mut scene = placed(&[(DVec3::new(-1.2, -1.0, -4.0), 0.5)], (64, 64));
        scene.camera.vertical_fov = 60.0;
        let view = scene.view();
        // The first sun's direction is within some texels, or the drop is.
        let is_beside = |pixel: usize| {
            let (x, y) = ((pixel % 64) as f64 + 0.5, (pixel / 64) as f64 + 0.5);
            let ray = view.ray(x, y).normalize();
            let sun = DVec3::new(0.13, 0.19, -1.0).normalize();
            let drop = DVec3::new(-1.2, -1.0, -4.0).normalize();
            ray.angle_between(sun) > 0.2 && ray.angle_between(drop) > 0.2
        };
        let beside: Vec<usize> = (0..64 * 64).filter(|pixel| is_beside(*pixel)).collect();
        assert!(beside.len() > 3000);
        for (width, suns) in [(128, 1), (256, 5)] {
            for unit in [1.0, 1e-6, 0.0] {
                let clean = truth(&scene, &sky_with_suns(width, unit, 0, 0.0), 4);
                for radiance in [1e10, 1e12, 3e38] {
                    let sky = sky_with_suns(width, unit, suns, radiance);
                    let reference = truth(&scene, &sky, 4);
                    for preset in PRESETS {
                        let (picture, _) = draw(device, &scene, &sky, preset);
                        let off = |other: &Picture| {
                            let off = |pixel: &usize| {
                                let [a, b] = [&picture, other].map(|of| of.pixels[*pixel]);
                                (a - b).abs().max_element()
                            };
                            beside.iter().map(off).fold(0.0, f32::max)
                        };
                        let (off, off_truth) = (off(&clean), off(&reference));
                        let of = format!("{preset}, {suns} of {radiance:e} on {unit:e}");
                        println!("{of}: {off:e}, {off_truth:e} beside the reference");
                        // Half a step of float16, 2^-25, of a mean of 2^-15, and what interpolation adds.
                        assert!(
                            off <= 3e-3 * unit && off_truth <= 4e-3 * unit,
                            "{of}: {off}, {off_truth}"
                        );
                        let most = picture.pixels.iter().map(|pixel| pixel.x).fold(0.0, f32::max);
                        assert!(most > 1e7 * unit && most > 0.0, "{of}: the sun is lost: {most}");
                    }
                    let shown = display(device, &scene, &sky, Preset::Fast);
                    let darkest = beside.iter().map(|pixel| shown[3 * pixel + 2]).min();
                    assert_eq!(
                        darkest > Some(40),
                        unit > 0.0,
                        "{radiance:e} on {unit:e}: {darkest:?}"
                    );
                }
            }
        }
    });
}

/// Many small drops, each with images of suns: splats of over a pixel, and larger drops. All finite, and shown.
#[test]
fn images_of_any_sun_are_finite() {
    on_device(|device| {
        let mut random = crate::common::Random(11);
        let mut at = || 2.0 * random.unit() - 1.0;
        let drops: Vec<(DVec3, f64)> = (0..300)
            .map(|number| {
                let (x, y, radius) = (at(), at(), if number % 10 == 0 { 0.1 } else { 0.024 });
                (DVec3::new(0.5 * x, 0.5 * y, -1.0), radius)
            })
            .collect();
        let mut scene = placed(&drops, (64, 64));
        scene.camera.vertical_fov = 60.0;
        for radiance in [1e8, 1e12, 1e25, 3e38] {
            let sky = sky_with_suns(256, 1.0, 5, radiance);
            for preset in PRESETS {
                let mut scene = scene.clone();
                scene.model.take_preset(preset);
                if preset == Preset::Fast {
                    scene.model.splat_px = Some(1.5);
                }
                let picture = crate::common::picture::picture_of(device, &scene, &sky);
                let is_finite = picture.pixels.iter().all(|pixel| pixel.is_finite());
                assert!(is_finite, "{preset}, {radiance:e}");
            }
            let shown = display(device, &scene, &sky, Preset::Fast);
            let dark = shown.chunks_exact(3).filter(|pixel| **pixel == [0; 3]).count();
            println!("{radiance:e}: {dark} pixels are black");
            assert!(dark < 100, "{radiance:e}: {dark} pixels are black");
        }
    });
}

/// The environment that is guessed from a plate as bright as float32 holds is as bright.
#[test]
fn a_guess_holds_the_brightest_plate() {
    let plate = Picture { width: 64, height: 48, pixels: vec![Vec3::splat(3e38); 64 * 48] };
    let view = Scene::default().camera.view(64, 48);
    let guess = Guess::new(&view, 512).around(&plate).expect("an environment");
    assert!(guess.mended().is_nothing());
    assert!(guess.texels().iter().all(|texel| (*texel / 3e38 - 1.0).abs().max_element() < 1e-6));
}

/// What a sun in a picture does to the exposure of the picture: it is one pixel of many.
#[test]
fn a_sun_in_a_picture_leaves_its_exposure() {
    let exposure = |sun: f32| {
        let mut pixels: Vec<Vec3> =
            (0..4096).map(|at| Vec3::splat(0.2 + 0.8 * at as f32 / 4096.0)).collect();
        pixels[77] = Vec3::splat(sun);
        raindrops::picture::tone_map::log_average(&Picture { width: 64, height: 64, pixels })
    };
    // One of 4096 logarithms is larger by ln 10³⁸.
    let (without, with) = (exposure(0.5), exposure(3e38));
    assert!((with / without - 1.0219).abs() < 1e-3, "{without}, {with}");
    // Nothing but a lamp: its own mean decides.
    let mut pixels = vec![Vec3::ZERO; 4096];
    pixels[77] = Vec3::splat(1e5);
    let lamp = Picture { width: 64, height: 64, pixels };
    assert!(raindrops::picture::tone_map::log_average(&lamp) > 0.0);
}

#[test]
fn the_ordinary_mean_is_that_without_suns() {
    let of = |width, unit, suns, radiance| {
        sky_with_suns(width, unit, suns, radiance).ordinary_luminance()
    };
    for (width, suns) in [(16, 1), (128, 1), (128, 5), (256, 5)] {
        let clean = of(width, 1.0, 0, 0.0);
        assert_eq!(clean, sky_with_suns(width, 1.0, 0, 0.0).mean_luminance(), "nothing is bright");
        let found = [1e3, 1e8, 1e12, 3e38].map(|radiance| of(width, 1.0, suns, radiance));
        // Each of them counts as 30 means, whatever it is.
        assert!(found.iter().all(|mean| (mean / found[1] - 1.0).abs() < 1e-6), "{found:?}");
        let most = if width == 16 { 2.0 } else { 1.06 };
        assert!(found[1] / clean > 1.0 && found[1] / clean < most, "{clean}, {found:?}");
        assert_eq!(of(width, 0.0, suns, 1e12), 0.0);
    }
    // Half of the sphere is no small part.
    let texels = (0..32 * 16).map(|at| Vec3::splat(if at < 16 * 16 { 1e12 } else { 1.0 }));
    let half = Environment::from_texels("half", 32, 16, texels.collect()).expect("an environment");
    assert!((half.ordinary_luminance() / 5e11 - 1.0).abs() < 1e-6);
}

/// Drops of 0.04 px, all behind the same 4 x 4 pixels of a picture of one degree.
fn thin_layers(count: usize) -> Scene {
    let mut random = crate::common::Random(3);
    let mut scene = placed(&[], (16, 16));
    scene.camera.vertical_fov = 1.0;
    let focal = scene.view().focal_px;
    let drops: Vec<(DVec3, f64)> = (0..count)
        .map(|_| {
            let at = DVec3::new(random.unit() - 0.5, random.unit() - 0.5, 0.0);
            let distance = focal / 0.02 * (1.0 + 0.1 * random.unit());
            (4.0 / focal * distance * at - DVec3::Z * distance, 1.0)
        })
        .collect();
    Scene { camera: scene.camera, ..placed(&drops, (16, 16)) }
}

/// Whether a driver leaves loops after some 65,000 passes: lavapipe of Debian 12 does, that of 2025 does not.
fn cuts_lists(device: &raindrops::gpu::Device) -> bool {
    device.report.summary().contains("llvmpipe Mesa 22")
}

/// A list so long that a driver that bounds loops leaves it early: its light is there all the same, and
/// where the driver is known to do so it is reported.
#[test]
fn a_list_that_is_cut_is_told() {
    on_device(|device| {
        let (scene, hole) = (thin_layers(80_000), hole(1.5, Vec3::ONE));
        let (picture, counts) = draw(device, &scene, &hole, Preset::Fast);
        let share = sum(&picture) / sum(&truth(&scene, &hole, 64));
        println!("{share:.4} of the light of 80,000 thin layers, {} told", counts.overflow);
        assert!((share - 1.0).abs() < 0.03, "{share} of the light");
        let is_cut = cuts_lists(device);
        assert_eq!(counts.overflow > 0, is_cut, "{} told", counts.overflow);
    });
}

/// A list so long that it takes several dispatches: all of its drops are drawn, and that they are not in order is told. What passes
/// through all of them is the product of what passes through each third, whose lists one dispatch goes through.
#[test]
fn a_list_of_several_dispatches_loses_no_light() {
    on_device(|device| {
        let (mut scene, hole) = (thin_layers(300_000), hole(1.5, Vec3::ONE));
        scene.drops.iter_mut().for_each(|drop| drop.radius = 0.25);
        let passed = |range: std::ops::Range<usize>| {
            let part = Scene { drops: scene.drops[range].to_vec(), ..scene.clone() };
            let (picture, counts) = draw(device, &part, &hole, Preset::Fast);
            let through = |pixel: &Vec3| 1.0 - f64::from(pixel.y);
            (picture.pixels.iter().map(through).collect::<Vec<_>>(), counts.overflow)
        };
        let (all, told) = passed(0..300_000);
        let thirds = [0, 1, 2].map(|third| passed(third * 100_000..(third + 1) * 100_000).0);
        // A pixel in the middle is asked.
        let middle = 8 * 16 + 8;
        let (all, thirds) = (all[middle], thirds.map(|third| third[middle]));
        let product: f64 = thirds.iter().product();
        println!("{all:.4} passes, {product:.4} by thirds {thirds:.4?}; {told} told");
        assert!((all / product - 1.0).abs() < 0.02, "{all} passes, by thirds {product}");
        assert!(told > 280_000, "{told} told");
    });
}

/// No streak is lost where streaks have one colour and their lists no order: a workgroup goes through what is too long for one invocation.
/// Light of several lists is known from that of each, as what passes through all is the product of what passes through each.
#[test]
fn a_long_list_of_streaks_loses_nothing() {
    on_device(|device| {
        let (mut scene, hole) = (thin_layers(100_000), hole(1.5, Vec3::ONE));
        scene.camera.shutter = 1.0;
        let focal = scene.view().focal_px;
        for drop in &mut scene.drops {
            let distance = drop.center.z.abs();
            // All within one column of pixels, for one list.
            drop.center.x = 0.2 * drop.center.x - distance / focal;
            drop.velocity = DVec3::new(0.0, 0.1 * distance, 0.0);
        }
        let light = |range: std::ops::Range<usize>| {
            let part = Scene { drops: scene.drops[range].to_vec(), ..scene.clone() };
            let (picture, counts) = draw(device, &part, &hole, Preset::Fast);
            assert_eq!(counts.overflow, 0, "streaks are lost");
            // The column's brightest pixel.
            let brightest = picture.pixels.iter().map(|pixel| f64::from(pixel.y));
            brightest.fold(0.0, f64::max)
        };
        let (first, second, both) = (light(0..25_000), light(25_000..50_000), light(0..50_000));
        let rest = light(50_000..100_000);
        // What streaks without end show, of which each list shows a part.
        let most = first * second / (first + second - both);
        let (found, expected) = (light(0..100_000), both + rest - both * rest / most);
        println!("{found:.4} of 100,000 streaks, {expected:.4} expected, of {most:.4} at most");
        assert!((found / expected - 1.0).abs() < 0.02, "{found} is not {expected}");
        assert!(found > 1.2 * both, "the control: the second half adds little");
    });
}

/// Nor where larger drops lie among them, before each of which a tile goes through its streaks once more. Light is ahead alone, so that a
/// pixel has what passes through all: the product of what passes through the streaks and through the larger drops.
#[test]
fn a_long_list_of_streaks_among_larger_drops_loses_nothing() {
    on_device(|device| {
        let mut scene = thin_layers(20_000);
        scene.camera.shutter = 1.0;
        let focal = scene.view().focal_px;
        for (number, drop) in (0..).zip(&mut scene.drops) {
            let distance = drop.center.z.abs();
            drop.center.x = 0.2 * drop.center.x - distance / focal;
            match number % 500 {
                // Forty of two pixels' radius stand still.
                0 => {
                    drop.center.x -= 2.3 * distance / focal;
                    drop.radius = 2.0 * distance / focal;
                }
                _ => drop.velocity = DVec3::new(0.0, 0.1 * distance, 0.0),
            }
        }
        let ahead = painted(1024, |d| Vec3::splat(if -d.z > 0.9999 { 1.0 } else { 0.0 }));
        let passed = |is_taken: &dyn Fn(f64) -> bool| {
            let taken = scene.drops.iter().filter(|drop| is_taken(drop.radius)).cloned();
            let part = Scene { drops: taken.collect(), ..scene.clone() };
            let (picture, counts) = draw(device, &part, &ahead, Preset::Fast);
            assert_eq!(counts.overflow, 0, "streaks are lost");
            picture.pixels.into_iter().map(|pixel| f64::from(pixel.y)).collect::<Vec<_>>()
        };
        let (all, streaks) = (passed(&|_| true), passed(&|radius| radius == 1.0));
        let larger = passed(&|radius| radius != 1.0);
        let products = streaks.iter().zip(&larger).map(|(one, other)| one * other);
        let off = products.zip(&all).map(|(product, all)| (product - all).abs());
        // Usually 0.08, at rims: the larger ones alone are so few that they are drawn by rays.
        let off = off.fold(0.0, f64::max);
        println!("{off:.4} off at most");
        assert!(off < 0.1, "{off} off");
        let covered = streaks.iter().zip(&larger).filter(|(a, b)| **a < 0.95 && **b < 0.95);
        assert!(covered.count() > 2, "the control: few pixels have both");
    });
}

/// Thousands of sub-pixel layers, each of an alpha that float16 blending would lose.
#[test]
fn many_thin_layers() {
    on_device(|device| {
        let hole = hole(1.5, Vec3::ONE);
        const COUNT: usize = 6000;
        let scene = thin_layers(COUNT);
        let expected = sum(&truth(&scene, &hole, 1024));
        for preset in [Preset::Fast, Preset::Exact] {
            let found = sum(&draw(device, &scene, &hole, preset).0) / expected;
            println!("{preset}: {found:.4} of the light of {COUNT} thin layers");
            assert!((found - 1.0).abs() < 0.025, "{preset}: {found}");
        }
        // The depth test lets a layer through if no nearer one was drawn before: of the n of a pixel, in no
        // order, 1 + 1/2 + … + 1/n. Of a drop that small a look-up shows six tenths (`small_drops_keep_their_light`).
        let n = COUNT / 16;
        let through = (1..=n).map(|layer| 1.0 / layer as f64).sum::<f64>() / n as f64;
        let found = sum(&draw(device, &scene, &hole, Preset::Paper).0) / expected;
        println!(
            "paper: {found:.4} of the light of {COUNT} thin layers, {through:.4} pass the test"
        );
        let share = found / through;
        assert!((0.35..0.9).contains(&share), "paper: {share} of what passes the depth test");
    });
}
