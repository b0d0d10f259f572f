//! `raindrops tradeoff`: every model's time and error.

use std::path::PathBuf;

use clap::Args;
use serde_json::{Map, Value};

use super::device::{DeviceArgs, expected_costs};
use super::format::{Format, Sheet};
use super::interrupt::{Interrupted, heed_interrupts, is_interrupted};
use super::options::SceneArgs;
use super::tell::{about, note, warning};
use super::{Answer, parse_seconds, print_beside, progress, waiting, write_json};
use crate::Error;
use crate::files::write_whole;
use crate::measure::bench::{self, Build, DeviceHead};
use crate::measure::tradeoff::{
    BASES, Effort, Noise, Report, Row, SCHEMA, Study, StudyScene, expected_s, models, models_of,
    models_of_pane, models_of_rain, plot, standard_set, still, study, weather,
};
use crate::measure::{Host, Watch};
use crate::scene::model::{Lens, Motion, Preset, ShapeModel};
use crate::thousands::{counted, thousands_of};

/// Measure every model's time and error
#[derive(Args)]
#[command(
    mut_arg("scene", |arg| arg.help("Scene file (TOML) [default: eight scenes, see below]")),
    after_help = "The eight scenes: close-up (one drop), near (hundreds), far (a million), sun, low range, pan (flicker), weather (real rain),\n\
                  lens (the same, out of focus).\n\
                  They take a quarter of an hour on two CPU cores; --scenes and --models take less. A scene file, --drops, --size and the like\n\
                  measure one scene of your own instead."
)]
pub struct TradeoffArgs {
    /// Samples a pixel of the truth
    #[arg(long, value_name = "N", default_value_t = 128,
          value_parser = clap::value_parser!(u32).range(1..=1 << 20))]
    truth_samples: u32,
    /// Only these of the eight scenes, comma-separated: close-up, near, far, sun, low range, pan, weather, lens
    #[arg(long, value_name = "NAME,…", value_delimiter = ',')]
    scenes: Vec<String>,
    /// Only models of these names, comma-separated, and the two with which all are compared: paper and paper-compact, with
    /// real rain fast and exact; what is no model's name stands for all that contain it
    #[arg(long, value_name = "TEXT,…", value_delimiter = ',')]
    models: Vec<String>,
    /// Seconds to time a model, or longer for --min-frames
    #[arg(long, value_name = "S", default_value_t = 0.3, value_parser = parse_seconds)]
    seconds: f64,
    /// Time at least this many frames of a model, for at most ten times --seconds
    #[arg(long, alias = "frames", value_name = "N", default_value_t = 5)]
    min_frames: usize,
    /// Write the rows as JSON; `-` is stdout
    #[arg(long, value_name = "FILE")]
    json: Option<PathBuf>,
    /// Write the rows as comma-separated values
    #[arg(long, value_name = "FILE")]
    csv: Option<PathBuf>,
    /// Plot error over time as SVG, with the Pareto front
    #[arg(long, value_name = "FILE")]
    svg: Option<PathBuf>,
    /// Write the truth and every model's picture of each scene into this folder, as PNG
    #[arg(long, value_name = "DIR")]
    pictures: Option<PathBuf>,
    #[command(flatten)]
    scene: SceneArgs,
    #[command(flatten)]
    device: DeviceArgs,
}

/// Runs the command.
pub fn run(args: &TradeoffArgs) -> anyhow::Result<Answer> {
    super::check_folders([&args.json, &args.csv, &args.svg])?;
    let scenes = if args.scene.is_default() {
        let mut set = standard_set()?;
        set.extend(weather()?);
        if let Some(name) = args.scenes.iter().find(|name| !set.iter().any(|s| s.name == **name)) {
            let names: Vec<_> = set.iter().map(|scene| scene.name.as_str()).collect();
            anyhow::bail!("--scenes {name}: there are {}", names.join(", "));
        }
        set.retain(|scene| args.scenes.is_empty() || args.scenes.contains(&scene.name));
        set
    } else if !args.scenes.is_empty() {
        anyhow::bail!(
            "--scenes chooses among those of the study; a scene file, --drops, --size and the like make a scene of your own: leave out one or the other"
        );
    } else {
        let scene = args.scene.load()?;
        let environment = super::open_environment(&scene)?;
        vec![still(&args.scene.name(), "not of the study", scene, &environment)]
    };
    let all: Vec<_> = [models(), models_of_rain(), models_of_pane()].concat();
    // A name in full is that model alone.
    let is_name = |text: &str| all.iter().any(|model| model.name == text);
    let holds = |name: &str, text: &String| match is_name(text) {
        true => name == text,
        false => name.contains(text.as_str()),
    };
    if let Some(text) = args.models.iter().find(|text| !all.iter().any(|m| holds(&m.name, text))) {
        anyhow::bail!("--models {text}: no model's name contains that; docs/results lists them");
    }
    let wanted =
        |name: &str| args.models.is_empty() || args.models.iter().any(|text| holds(name, text));
    // The speed of every other model is relative to the first two.
    let of_scene = |scene: &StudyScene| -> Vec<_> {
        let all = models_of(&scene.frames[0]).into_iter().enumerate();
        all.filter(|(number, model)| *number < BASES || wanted(&model.name))
            .map(|(_, model)| model)
            .collect()
    };
    let device = args.device.open()?;
    let (mut host, watch) = (Host::now(), Watch::start());
    host.doubt().iter().for_each(|warning| warning!("{warning}"));
    let effort = Effort {
        time: bench::Effort {
            seconds: args.seconds,
            frames: args.min_frames,
            stop: is_interrupted,
        },
        truth_samples: args.truth_samples,
        pictures: args.pictures.as_deref(),
    };
    if let Some(folder) = &args.pictures {
        std::fs::create_dir_all(folder).map_err(|error| Error::write(folder, error))?;
    }
    let count: usize = scenes.iter().map(|scene| of_scene(scene).len()).sum();
    let work =
        format!("{} of {}", counted(count as u64, "model"), counted(scenes.len() as u64, "scene"));
    match expected_costs(&device.report) {
        Some(costs) => {
            let of_scene_s = |scene| expected_s(scene, &of_scene(scene), &effort, &costs);
            let all_s = || scenes.iter().map(of_scene_s).sum::<crate::Result<f64>>();
            let expected = waiting("estimating how long this takes", all_s)?;
            note!("{work}, about {} (by times of {})", about(expected), costs.of);
        }
        None => note!("{work}"),
    }
    heed_interrupts()?;
    let bar = progress(100 * scenes.len() as u64, "%");
    let (mut rows, mut noises) = (Vec::new(), Vec::new());
    for (number, scene) in scenes.iter().enumerate() {
        let say = |what: &str, share: f64| {
            bar.set_message(format!("{}: {what}", scene.name));
            bar.set_position(((number as f64 + share) * 100.0) as u64);
        };
        let Study { rows: found, noise } = study(&device, scene, &of_scene(scene), effort, &say)?;
        if let Some(Row { width, height, .. }) = found.first() {
            bar.suspend(|| {
                let (name, asks) = (&scene.name, scene.asks);
                let table = table(&found).text(Format::Table);
                let line = noise.as_ref().map_or(String::new(), noise_line);
                let text = format!("{name}: {asks}, {width} x {height}\n{table}\n{line}\n");
                print_beside(args.json.as_ref(), text)
            })?;
        }
        rows.extend(found);
        noises.extend(noise);
        if is_interrupted() {
            break;
        }
    }
    bar.finish_and_clear();
    print_beside(
        args.json.as_ref(),
        "* no other model is both quicker and truer (by rms); speed: as a multiple of paper's, and of paper-compact's; \
         with real rain of fast's, and of exact's",
    )?;
    let failed = (is_interrupted() && rows.len() < count).then(|| {
        let done = format!("{} of {} finished", rows.len(), counted(count as u64, "row"));
        anyhow::Error::from(Interrupted).context(done)
    });
    if rows.is_empty()
        && let Some(error) = failed
    {
        return Err(error);
    }
    host.others = watch.others();
    host.others_doubt().iter().for_each(|warning| warning!("{warning}"));
    let report = Report {
        schema: SCHEMA,
        command: Some(super::command_line()),
        device: DeviceHead::of(&device.report),
        build: Build::this(),
        host,
        truth_samples: args.truth_samples,
        stopped: failed.as_ref().map(|error| format!("{error:#}")),
        noise: noises,
        rows,
    };
    write_json(args.json.as_ref(), &report)?;
    if let Some(path) = &args.csv {
        let text = plain(&report.rows).text(Format::Csv) + "\n";
        write_whole(path, text.as_bytes())?;
    }
    if let Some(path) = &args.svg {
        write_whole(path, plot(&report)?.as_bytes())?;
    }
    if let Some(error) = failed {
        return Err(error);
    }
    device.instance().expect_silence()?;
    Ok(Answer::Yes)
}

fn told((word, is_told): (&'static str, bool)) -> Option<&'static str> {
    is_told.then_some(word)
}

/// The rows of a scene, quickest first; a star marks the front.
fn table(rows: &[Row]) -> Sheet {
    let mut sorted: Vec<&Row> = rows.iter().collect();
    sorted.sort_by(|a, b| b.speed.total_cmp(&a.speed));
    let moves = rows.iter().any(|row| row.errors.flicker.is_some());
    let has_compact = rows.iter().any(|row| row.model == Preset::PaperCompact.name());
    let of = if has_compact { "of compact" } else { "of exact" };
    let mut header = vec!["  model", "speed", of, "ms", "rms x255", "relMSE"];
    header.extend(["FLIP", "FLIP 99 %", "FLIP boxes"]);
    header.extend(moves.then_some("flicker x255"));
    // How drops are drawn that fall, are out of focus, or are no spheres; where the scene has none, all are drawn alike.
    let drawn = |row: &Row| {
        let axes = &row.axes;
        [axes.motion.name(), axes.lens.name(), axes.shape.name()]
    };
    let plain = [Motion::Instant.name(), Lens::Pinhole.name(), ShapeModel::Sphere.name()];
    let is_told = [0, 1, 2].map(|axis| rows.iter().any(|row| drawn(row)[axis] != plain[axis]));
    header.extend(["motion", "lens", "shape"].into_iter().zip(is_told).filter_map(told));
    let cells = |row: &Row| {
        let errors = &row.errors;
        let mut cells = vec![
            format!("{} {}", if row.pareto { "*" } else { " " }, row.model),
            format!("{:.2}", row.speed),
            format!("{:.2}", row.speed_over_compact),
            thousands_of(row.median_ms, 2),
            format!("{:.2}", 255.0 * errors.rms),
            format!("{:.2e}", errors.rel_mse),
            format!("{:.4}", errors.flip),
            format!("{:.4}", errors.flip_p99),
            format!("{:.4}", errors.box_flip),
        ];
        cells.extend(errors.flicker.map(|flicker| format!("{:.2}", 255.0 * flicker)));
        cells.extend(drawn(row).into_iter().zip(is_told).filter_map(told).map(String::from));
        cells
    };
    let header = header.into_iter().map(String::from).collect();
    Sheet { names: 1, header, rows: sorted.into_iter().map(cells).collect() }
}

/// What an error must be well above to say something about its model.
fn noise_line(noise: &Noise) -> String {
    format!(
        "A perfect picture would be off from this truth by rms x255 {:.2}, FLIP {:.4}, FLIP boxes {:.4}: the truth has noise. Where a \
         model's error is close to this, its own is smaller, and not known",
        255.0 * noise.rms,
        noise.flip,
        noise.box_flip
    )
}

/// All rows, with the keys of the JSON. Axes that a later version has added stand last.
fn plain(rows: &[Row]) -> Sheet {
    const FIRST: &str = "scene,model,preset,optics,primitive,order,simulation,samples,internal_reflections,weights,\
         fresnel,reflection,lookup,mask_size,drops,visible,width,height,median_ms,p10_ms,p90_ms,\
         speed,speed_over_compact,rms,rel_mse,psnr_db,flip,flip_p99,max_error,box_rel_mse,box_flip,flicker,pareto,rate_mm_h,\
         cutoff_px,far_rain";
    let of_row = |row: &Row| match serde_json::to_value(row) {
        Ok(Value::Object(values)) => values,
        // What a row consists of has a form in JSON.
        _ => Map::new(),
    };
    let rows: Vec<Map<String, Value>> = rows.iter().map(of_row).collect();
    let mut header: Vec<String> = FIRST.split(',').map(String::from).collect();
    let keys = rows.first().into_iter().flat_map(Map::keys);
    let more: Vec<String> = keys.filter(|key| !header.contains(key)).cloned().collect();
    header.extend(more);
    let cell = |value: Option<&Value>| match value {
        None | Some(Value::Null) => String::new(),
        Some(value) => super::plain(value),
    };
    let cells = |row: &Map<String, Value>| header.iter().map(|key| cell(row.get(key))).collect();
    let rows = rows.iter().map(cells).collect();
    Sheet { names: 2, header, rows }
}
