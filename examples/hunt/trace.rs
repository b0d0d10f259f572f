//! The reference of a scene, as two halves whose noise is independent: with more samples as long as the noise is over a share
//! of the bounds, up to a limit; kept in a folder, so that another commit's pictures meet the same reference, and so that
//! one that is not fine enough goes on where it was left.

use std::path::{Path, PathBuf};
use std::sync::LazyLock;
use std::time::Instant;

use anyhow::{Context as _, ensure};
use glam::{DVec3, Vec3};
use raindrops::environment::Environment;
use raindrops::files::write_whole;
use raindrops::picture::Picture;
use raindrops::picture::plate::Plate;
use raindrops::picture::tone_map::exposure_of;
use raindrops::reference::{Traced, Tracer, Truth, usual_bound};
use raindrops::scene::model::ModelChoice;
use raindrops::scene::real_rain::RealRain;
use raindrops::scene::{PlacedDrop, RainSettings, Scene};

use super::bounds::{bound, noise_of_dots};
use super::figures::Halves;

/// Samples a pixel of each half at first.
const FIRST: u32 = 16;

/// The noise of a figure may be this share of the bound of `exact`, else there are more samples.
const SHARE: f64 = 0.25;

/// Drops of real rain that are traced one by one, at most, in the whole picture. Beyond them is a medium.
const MOST_TRACED: f64 = 1e5;

/// Drops of it that a ray is tried against, at most.
const MOST_TRIED: f64 = 150.0;

/// Radius in pixels of the largest drop where the medium may begin: one that small changes its pixel by 2 % of its contrast.
const MEDIUM_PX: f64 = 0.07;

/// How fast large drops fall, m/s, and about how far away those are that one sees, m.
const FALL: f64 = 8.0;
const SEEN: f64 = 10.0;

/// First bytes of a kept reference, with the version of its form.
const MAGIC: &[u8; 8] = b"halves 1";

/// How finely references are traced, and where they are kept.
#[derive(Clone, Debug)]
pub struct Tracing {
    /// Samples a pixel of each half, at most.
    pub most_samples: u32,
    /// No more are begun after half of so many seconds of the process' time on its processors.
    pub most_seconds: f64,
    /// The folder of those that are kept, and what tells the program that traced them.
    pub kept: Option<(PathBuf, u32)>,
}

impl Tracing {
    /// Traces a scene, or goes on with what is kept of it by this name.
    pub fn halves(
        &self,
        name: &str,
        scene: &Scene,
        environment: &Environment,
    ) -> anyhow::Result<Halves> {
        let before = busy_seconds();
        let plate = Plate::of(scene)?;
        let path = self.kept.as_ref().map(|(folder, program)| {
            folder.join(format!("{name}-{:08x}.halves", key(scene, environment, &plate, *program)))
        });
        let kept = path.as_deref().filter(|path| path.exists()).map(read).transpose()?;
        let is_new = kept.is_none();
        let mut halves = match kept {
            Some(halves) => halves,
            None => traced(scene, environment, &plate, FIRST.min(self.most_samples), 0)?,
        };
        let mut has_more = is_new;
        while halves.samples < self.most_samples && is_noisy(scene, &halves) {
            // The next takes as long as all before it.
            if busy_seconds() - before > 0.5 * self.most_seconds {
                break;
            }
            let more = halves.samples.min(self.most_samples - halves.samples);
            let next = traced(scene, environment, &plate, more, u64::from(halves.samples))?;
            halves = joined(&halves, &next);
            has_more = true;
        }
        if let (Some(path), true) = (&path, has_more) {
            write_whole(path, &bytes(&halves))?;
        }
        Ok(halves)
    }
}

/// Seconds that the process' threads have run, which other work on the machine does not change; where the system does not
/// say so, seconds.
fn busy_seconds() -> f64 {
    static START: LazyLock<Instant> = LazyLock::new(Instant::now);
    let of_linux = || -> Option<f64> {
        let text = std::fs::read_to_string("/proc/self/stat").ok()?;
        // After the name in parentheses; ticks are hundredths.
        let (_, rest) = text.rsplit_once(')')?;
        let ticks = rest.split_whitespace().skip(11).take(2);
        Some(ticks.filter_map(|word| word.parse::<f64>().ok()).sum::<f64>() / 100.0)
    };
    of_linux().unwrap_or_else(|| START.elapsed().as_secs_f64())
}

/// Whether the noise of the mean of both hides what the bounds of `exact` ask about.
fn is_noisy(scene: &Scene, halves: &Halves) -> bool {
    let noise = halves.noise(exposure_of(&scene.tone_map, &halves.mean()));
    let over = |figure, noise: f64| noise > SHARE * bound("exact", figure);
    over("box", noise.boxes) || over("dots", noise_of_dots(&noise)) || over("flip", noise.flip)
}

/// Two halves of so many samples; `after`: samples that others of this scene have, so that the seeds are others.
fn traced(
    scene: &Scene,
    environment: &Environment,
    plate: &Plate,
    samples: u32,
    after: u64,
) -> anyhow::Result<Halves> {
    let rain_to = rain_to(scene);
    let halves: [Traced; 2] = [0, 1].map(|half| {
        let truth = Truth { samples, seed: 2 * after + half, rain_to, ..Truth::default() };
        Tracer::new(scene, environment, truth).before(plate.clone()).trace(&|_| ())
    });
    let [a, b] = halves;
    let opacity = a.opacity.iter().zip(&b.opacity).map(|(a, b)| 0.5 * (a + b)).collect();
    let halves = [a.picture, b.picture];
    let is_whole = |picture: &Picture| picture.pixels.iter().all(|pixel| pixel.is_finite());
    ensure!(halves.iter().all(is_whole), "the reference is not finite");
    Ok(Halves { halves, opacity, samples })
}

/// Distance to which real rain is traced drop by drop, in metres. A ray is tried against every drop whose blur or streak covers
/// its pixel: where these are large, fewer drops are traced, and show by themselves.
fn rain_to(scene: &Scene) -> Option<f64> {
    let rain = scene.real_rain()?;
    let view = scene.whole().view();
    let focal = view.focal_px;
    let blur_px = 1.0 + 2.0 * scene.drawn_lens() / scene.camera.focus * focal;
    let streak_px = FALL * scene.exposed().abs() * focal / SEEN;
    let share = blur_px * (blur_px + streak_px) / (f64::from(view.width) * f64::from(view.height));
    let most = MOST_TRACED.min(MOST_TRIED / share);
    let bound = usual_bound(scene)? * (most / raindrops::reference::MOST_TRACED).cbrt();
    let small = 0.5e-3 * rain.diameters[1] * focal / MEDIUM_PX;
    Some(bound.min(small).min(rain.extent))
}

/// Means of both, each by its samples.
fn joined(first: &Halves, next: &Halves) -> Halves {
    let samples = first.samples + next.samples;
    let share = next.samples as f32 / samples as f32;
    let of = |half: usize| {
        let (a, b) = (&first.halves[half], &next.halves[half]);
        let pixels = a.pixels.iter().zip(&b.pixels).map(|(a, b)| a.lerp(*b, share)).collect();
        Picture { pixels, ..*a }
    };
    let pairs = first.opacity.iter().zip(&next.opacity);
    let opacity = pairs.map(|(a, b)| a + share * (b - a)).collect();
    Halves { halves: [of(0), of(1)], opacity, samples }
}

/// By which a scene's reference is told from others: all that it depends on.
fn key(scene: &Scene, environment: &Environment, plate: &Plate, program: u32) -> u32 {
    let mut scene = Scene { model: ModelChoice::default(), ..scene.clone() };
    // What stands in the files counts, not where they are.
    scene.environment.file = None;
    (scene.background.color, scene.background.depth) = (None, None);
    let mut sum = crc32fast::Hasher::new_with_initial(program);
    sum.update(super::text::of(&scene).as_bytes());
    sum.update(&scene.pace.to_le_bytes());
    sum.update(&environment.hash().to_le_bytes());
    sum.update(&plate.hash().unwrap_or(0).to_le_bytes());
    sum.finalize()
}

/// What the reference makes of three small scenes: another program's references are told from its own by it.
pub fn fingerprint() -> anyhow::Result<u32> {
    let environment = Environment::bundled()?;
    let mut scene = Scene { rain: None, ..Scene::default() };
    (scene.image.width, scene.image.height) = (16, 16);
    scene.camera.shutter = 0.01;
    let drop = PlacedDrop {
        velocity: DVec3::new(0.0, -9.0, 0.0),
        ..PlacedDrop::sphere(DVec3::new(0.0, 0.0, -4.0), 1.0)
    };
    let flat = Scene { drops: vec![PlacedDrop { axis_ratio: Some(0.7), ..drop }], ..scene.clone() };
    let rain = RealRain { extent: 20.0, ..RealRain::default() };
    let rain = Scene { rain: Some(RainSettings::of(rain)), ..scene.clone() };
    let sphere = Scene { drops: vec![drop], ..scene };
    let mut sum = crc32fast::Hasher::new();
    for scene in [sphere, flat, rain] {
        let truth = Truth { samples: 4, rain_to: Some(2.0), ..Truth::default() };
        let picture = Tracer::new(&scene, &environment, truth).picture();
        sum.update(bytemuck::cast_slice(&picture.pixels));
    }
    Ok(sum.finalize())
}

fn bytes(halves: &Halves) -> Vec<u8> {
    let [a, b] = &halves.halves;
    let mut bytes = MAGIC.to_vec();
    [a.width, a.height, halves.samples].iter().for_each(|word| bytes.extend(word.to_le_bytes()));
    bytes.extend(bytemuck::cast_slice::<Vec3, u8>(&a.pixels));
    bytes.extend(bytemuck::cast_slice::<Vec3, u8>(&b.pixels));
    bytes.extend(bytemuck::cast_slice::<f32, u8>(&halves.opacity));
    bytes
}

fn read(path: &Path) -> anyhow::Result<Halves> {
    let bytes = std::fs::read(path).with_context(|| path.display().to_string())?;
    let broken = || format!("{}: it is no reference of this program; delete it", path.display());
    let body = bytes.strip_prefix(MAGIC).with_context(broken)?;
    let word = |at: usize| -> Option<u32> {
        Some(u32::from_le_bytes(body.get(4 * at..4 * at + 4)?.try_into().ok()?))
    };
    let words = [word(0), word(1), word(2)];
    let [Some(width), Some(height), Some(samples)] = words else { anyhow::bail!(broken()) };
    let values: Vec<f32> = body[12..]
        .chunks_exact(4)
        .map(|word| f32::from_le_bytes([word[0], word[1], word[2], word[3]]))
        .collect();
    let count = width as usize * height as usize;
    ensure!(values.len() == 7 * count && count > 0, broken());
    let half = |from: usize| {
        let pixels = values[from..from + 3 * count].chunks_exact(3).map(Vec3::from_slice);
        Picture { width, height, pixels: pixels.collect() }
    };
    Ok(Halves {
        halves: [half(0), half(3 * count)],
        opacity: values[6 * count..].to_vec(),
        samples,
    })
}
