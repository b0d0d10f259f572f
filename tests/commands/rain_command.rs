//! `raindrops rain`, and what a scene file may say of real rain.

use std::fs;
use std::process::Output;

use raindrops::measure::rain_plot::distribution;
use raindrops::scene::Scene;
use raindrops::scene::model::{DropShape, FarRain, Sizes};
use serde_json::Value;

fn raindrops(arguments: &[&str]) -> Output {
    crate::common::raindrops().args(arguments).output().expect("the command starts")
}

fn rain(arguments: &[&str]) -> Value {
    let output = raindrops(&[&["rain"], arguments, &["--json", "-"]].concat());
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    serde_json::from_slice(&output.stdout).expect("JSON and nothing else")
}

#[track_caller]
fn close(value: &Value, expected: f64, tolerance: f64) {
    let value = value.as_f64().expect("a number");
    assert!((value / expected - 1.0).abs() <= tolerance, "{value}, expected {expected}");
}

/// The scene's problem, in one line.
#[track_caller]
fn problem(text: &str) -> String {
    let error = Scene::parse(text, "a.toml").expect_err(text).to_string();
    assert!(error.starts_with("a.toml") && !error.contains('\n'), "{error}");
    error
}

#[test]
fn the_figures_of_a_rate_are_those_of_the_normalised_law() {
    let report = rain(&["--rate", "10"]);
    assert_eq!(report["schema"], "raindrops-rain/1");
    // Marshall and Palmer's figures times the rate over what their law rains, 11.6343 mm/h.
    let factor = 0.859525;
    close(&report["rate_mm_h"], 10.0, 0.0);
    close(&report["rate_that_falls_mm_h"], 10.0, 1e-9);
    close(&report["drops_per_m3"], 1682.006 * factor, 2e-6);
    close(&report["mean_diameter_mm"], 0.645561, 1e-6);
    close(&report["median_volume_diameter_mm"], 1.45616, 1e-5);
    close(&report["water_g_m3"], 0.612731 * factor, 2e-6);
    close(&report["extinction_per_m"], 7.572264e-4 * factor, 2e-6);
    close(&report["visibility_5_percent_m"], 3956.2 / factor, 2e-5);
    let classes = report["classes"].as_array().expect("classes");
    assert_eq!(classes.len(), 32);
    close(&classes[0]["diameter_from_mm"], 0.25, 0.0);
    close(&classes[31]["diameter_to_mm"], 6.0, 0.0);
    let sum: f64 = classes.iter().map(|c| c["drops_per_m3"].as_f64().expect("number")).sum();
    close(&report["drops_per_m3"], sum, 1e-9);
    assert!(classes.iter().all(|class| class["axis_ratio"].as_f64() <= Some(1.0)));
    let speed = classes[31]["speed_m_s"].as_f64().expect("speed");
    assert!((8.9..9.17).contains(&speed), "{speed}");
}

/// RAIN's table of gamma laws, of which `tests/physics/rain_law.rs` has more, by the command.
#[test]
fn a_gamma_law_is_ulbrichs_by_the_command() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("gamma.toml");
    let write = |more: &str| {
        let text = format!("[rain]\nrate = 25.0\nsizes = \"gamma\"\n{more}");
        fs::write(&path, text).expect("written");
        path.to_str().expect("UTF-8")
    };
    let report = rain(&[write("mu = 3.0\n")]);
    close(&report["slope_per_mm"], 4.2857, 2e-5);
    close(&report["median_volume_diameter_mm"], 1.556, 3e-4);
    close(&report["drops_per_m3"], 1538.0, 3e-4);
    close(&report["visibility_5_percent_m"], 2225.0, 3e-4);
    close(&report["rate_that_falls_mm_h"], 25.0, 1e-9);
    // Willis 1984.
    let report = rain(&[write("mu = 2.5\nmedian_diameter = 1.6243\n")]);
    close(&report["median_volume_diameter_mm"], 1.624, 3e-4);
    close(&report["drops_per_m3"], 1428.0, 4e-4);
    close(&report["visibility_5_percent_m"], 2364.0, 4e-4);
    close(&rain(&["--rate", "25"])["slope_per_mm"], 2.0855, 3e-5);
    // Cut-offs change the median, which is said.
    let notes = |more: &str| {
        let output = raindrops(&["rain", write(more)]);
        assert!(output.status.success());
        String::from_utf8_lossy(&output.stderr).into_owned()
    };
    let said = notes("median_diameter = 5.0\n");
    assert!(said.contains("note: without cut-offs the median-volume diameter is 5 mm"), "{said}");
    assert!(!notes("median_diameter = 1.6\n").contains("without cut-offs"));
    // Keys of real rain beside an option that makes it.
    let set = rain(&["--rate", "25", "--set", "rain.air_density=0.9"]);
    assert_eq!(set["water_g_m3"], rain(&["--rate", "25", "--air-density", "0.9"])["water_g_m3"]);
    // A law of sizes that does not have the key is refused.
    let output = raindrops(&["rain", write("median_diameter = 1.5\n"), "--sizes", "uniform"]);
    let said = String::from_utf8_lossy(&output.stderr).into_owned();
    assert!(said.contains("--sizes uniform: rain: mu is for sizes = \"gamma\""), "{said}");
    assert_eq!(output.status.code(), Some(2));
}

#[test]
fn the_cut_off_says_what_is_drawn_and_where_the_medium_begins() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("rain.toml");
    fs::write(&path, "[camera]\nvertical_fov = 60.0\n[rain]\nrate = 25.0\n").expect("written");
    let path = path.to_str().expect("UTF-8");
    let report = rain(&[path, "--cutoff-px", "0.05"]);
    close(&report["cutoff_px"], 0.05, 0.0);
    // 784 thousand by Marshall and Palmer's own N0, times the factor on it.
    close(&report["drops_in_view"], 7.837e5 * 0.8863, 3e-4);
    close(&report["medium_from_m"], 53.21, 1e-3);
    close(&rain(&[path, "--cutoff-px", "0.1"])["drops_in_view"], 9.796e4 * 0.8863, 3e-4);
    // From 1 km to a million, and without end, nothing that is counted changes.
    let far = |extent| rain(&[path, "--extent", extent])["drops_in_view"].clone();
    assert!(far("1e3").as_f64() > Some(1e5));
    assert_eq!(far("1e3"), far("1e6"));
    assert_eq!(far("1e3"), far("inf"));
    // What does not fit moves into the medium, and that is said.
    let dense = rain(&[path, "--rate", "2000", "--size", "4096x4096"]);
    close(&dense["drops_in_view"], 4e6, 1e-9);
    assert!(dense["cutoff_reason"].as_str().expect("a reason").contains("4 million"));
    // Every drop is drawn, to the end of the rain.
    let all = rain(&[path, "--far-rain", "drops", "--extent", "3"]);
    let ball = 0.336_9 * 27.0 * all["drops_per_m3"].as_f64().expect("number");
    close(&all["drops_in_view"], ball, 1e-3);
    assert!(all["medium_from_m"].is_null());
}

/// The cut-off of a scene that names none is one number for all commands.
#[test]
fn all_commands_have_the_same_cut_off() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("rain.toml");
    fs::write(&path, "[rain]\nrate = 5.0\nextent = 9.0\n[model]\npreset = \"fast\"\n")
        .expect("written");
    let path = path.to_str().expect("UTF-8");
    let cutoff = rain(&[path, "--size", "64x64"])["cutoff_px"].clone();
    let said = |arguments: &[&str]| {
        let output =
            crate::common::raindrops().args(arguments).output().expect("the command starts");
        assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
        String::from_utf8(output.stdout).expect("UTF-8")
    };
    let plan = said(&["plan", path, "--size", "64x64"]);
    assert!(
        plan.contains(&format!("cutoff_px             {cutoff}: no smaller drop shows")),
        "{plan}"
    );
    // Before a background of its own it follows from that.
    let pixels = vec![glam::Vec3::splat(0.5); 64 * 64];
    let even = raindrops::picture::Picture { width: 64, height: 64, pixels };
    let plate = folder.path().join("even.exr");
    even.write_exr(&plate).expect("a plate");
    let plate = plate.to_str().expect("UTF-8");
    let before = said(&["plan", path, "--size", "64x64", "--background", plate]);
    let line =
        |plan: &str| plan.lines().find(|line| line.starts_with("cutoff_px")).map(String::from);
    assert!(line(&before).is_some() && line(&before) != line(&plan), "{before}");
    // Bench counts its drops again on the CPU, over this cut-off.
    let quick = ["--size", "64x64", "--seconds", "0.02", "--frames", "1", "--json", "-"];
    let bench = said(&[&["bench", path], &quick[..]].concat());
    let bench: serde_json::Value = serde_json::from_str(&bench).expect("JSON");
    assert_eq!(bench["rows"][0]["cutoff_px"], cutoff);
}

#[test]
fn all_keys_of_real_rain_are_read_and_written() {
    let text = "metres = 0.5\n[rain]\nrate = 5\nsizes = \"gamma\"\nmu = 2.0\nmedian_diameter = 1.25\ndiameters = [0.5, 5.0]\n\
                air_density = 1.0\nwind = [2.0, 0.0, -1.0]\nshape = \"sphere\"\nextent = inf\n\
                [model]\nfar_rain = \"medium\"\ncutoff_px = 0.1\n";
    let scene = Scene::parse(text, "a.toml").expect("a scene");
    let rain = scene.real_rain().expect("rain");
    assert_eq!((rain.rate, rain.sizes, rain.mu), (5.0, Sizes::Gamma, 2.0));
    assert_eq!(rain.median_diameter, Some(1.25));
    assert_eq!((rain.diameters, rain.air_density), ([0.5, 5.0], 1.0));
    assert_eq!((rain.wind.to_array(), rain.shape), ([2.0, 0.0, -1.0], DropShape::Sphere));
    assert!(rain.extent.is_infinite() && scene.metres == 0.5);
    assert_eq!((scene.model.far_rain, scene.model.cutoff_px), (Some(FarRain::Medium), Some(0.1)));
    assert!(scene.rain().is_none() && scene.drop_count() == 0);
    let written = toml::to_string(&scene).expect("TOML");
    assert_eq!(Scene::parse(&written, "b.toml").expect("a scene"), scene);
    // A file keeps it, and one without it has none.
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("kept.toml");
    scene.save(&path).expect("saved");
    assert_eq!(Scene::load(&path).expect("a scene"), scene);
    let default = Scene::parse("[rain]\nrate = 25", "a.toml").expect("a scene");
    let default = default.real_rain().expect("rain");
    assert_eq!(default.median_diameter, None);
    assert_eq!((default.diameters, default.air_density), ([0.25, 6.0], 1.2));
    assert_eq!(default.sizes, Sizes::MarshallPalmer);
}

#[test]
fn bad_values_get_one_line_that_names_key_and_mend() {
    let with = |line: &str| format!("[rain]\nrate = 25.0\n{line}\n");
    let cases = [
        (
            "[rain]\nrate = 0.0".into(),
            "rate = 0 is not within 0.001 to 2000 mm/h; for no rain leave the rate out",
        ),
        ("[rain]\nrate = -5.0".into(), "rate = -5 is not within"),
        ("[rain]\nrate = nan".into(), "rate = NaN is not within"),
        ("[rain]\nrate = 1e6".into(), "rate = 1000000 is not within"),
        (with("count = 100"), "rate and count do not go together"),
        (with("radius = 1.0"), "rate and radius do not go together"),
        (with("diameters = [6.0, 0.25]"), "diameters = [6, 0.25] must ascend"),
        (with("diameters = [1.0, 1.0]"), "diameters = [1, 1] must ascend"),
        (with("diameters = [0.0, 6.0]"), "first of diameters = 0 is not within 0.01 to 10 mm"),
        (with("diameters = [0.25, 12.0]"), "second of diameters = 12 is not within"),
        (with("diameters = [0.25]"), "expected an array of length 2"),
        (with("sizes = \"gamma\"\nmu = -1.0"), "mu = -1 is not over -1"),
        (with("sizes = \"gamma\"\nmu = nan"), "mu = NaN is not over -1"),
        (with("sizes = \"gamma\"\nmu = 1e3"), "up to 50"),
        (with("mu = 3.0"), "mu is for sizes = \"gamma\""),
        (with("median_diameter = 1.5"), "median_diameter is for sizes = \"gamma\""),
        (with("sizes = \"uniform\"\nmedian_diameter = 1.5"), "not for \"uniform\""),
        (
            with("sizes = \"gamma\"\nmedian_diameter = 0.2"),
            "not within the diameters, 0.25 to 6 mm",
        ),
        (with("sizes = \"gamma\"\nmedian_diameter = 6.1"), "median_diameter = 6.1 is not within"),
        (with("sizes = \"gamma\"\nmedian_diameter = nan"), "median_diameter = NaN is not finite"),
        (
            with("sizes = \"gamma\"\nmu = 0.0\ndiameters = [2.0, 2.01]"),
            "a.toml:4: rain: a gamma law with mu = 0 and drops of 2 to 2.01 mm rains",
        ),
        (
            with("sizes = \"gamma\"\nmu = 50.0\ndiameters = [0.01, 0.02]"),
            "mm/h at most, not 25: give median_diameter in mm, another mu, or wider diameters",
        ),
        (
            "[rain]\nmedian_diameter = 1.5".into(),
            "median_diameter is for rain by its rate; add rate",
        ),
        (with("sizes = \"gama\""), "did you mean `gamma`?"),
        (with("wind = [1e6, 0.0, 0.0]"), "wind = [1000000, 0, 0] is over 150 m/s"),
        (with("wind = [nan, 0.0, 0.0]"), "the first of wind = NaN is not finite"),
        (with("air_density = 0.0"), "air_density = 0 is not within"),
        (with("extent = 0.0"), "extent = 0 is not over 0 m"),
        (with("extent = -inf"), "extent = -inf is not over 0 m"),
        (with("shape = \"egg\""), "unknown variant `egg`"),
        (with("rates = 3"), "did you mean `rate`?"),
        ("[rain]\nwind = [1.0, 0.0, 0.0]".into(), "wind is for rain by its rate; add rate"),
        ("metres = 0.0".into(), "metres = 0 is not finite and over 0 m"),
        ("metres = -inf".into(), "metres = -inf is not"),
        ("[model]\ncutoff_px = 0.1".into(), "cutoff_px is for real rain; give rain.rate"),
        (with("[model]\ncutoff_px = 0.0"), "cutoff_px = 0 is not within 0.001 to 1 px"),
        (with("[model]\ncutoff_px = nan"), "cutoff_px = NaN is not within"),
        (with("extent = inf\n[model]\nfar_rain = \"drops\""), "needs an end of the rain"),
        (with("[model]\nfar_rain = \"drops\"\ncutoff_px = 0.1"), "leave out cutoff_px"),
        (with("[camera]\nposition = [1e13, 0.0, 0.0]"), "over 1e12 m from the origin"),
    ];
    for (text, expected) in cases {
        let problem = problem(&text);
        assert!(problem.contains(expected), "{problem}; expected: {expected}");
    }
}

/// The options are checked like the keys; what cannot be drawn is refused, and nothing else is drawn.
#[test]
fn the_command_line_refuses_in_one_line() {
    let folder = tempfile::tempdir().expect("a folder");
    let picture = folder.path().join("a.png");
    let picture = picture.to_str().expect("UTF-8");
    let cases: [(&[&str], &str); 8] = [
        (&["rain"], "the paper's scene has no rain by its rate"),
        (&["rain", "--wind", "1,0,0"], "give --rate 25"),
        (&["rain", "--rate", "-1"], "rate = -1 is not within"),
        (&["rain", "--rate", "5", "--mu", "1"], "--mu 1: rain: mu is for sizes"),
        (&["rain", "--rate", "5", "--diameters", "3"], "an array of length 2"),
        (&["rain", "--rate", "5", "--drops", "7"], "7 drops in a box already"),
        (&["rain", "--rate", "5", "--cutoff-px", "9"], "not within 0.001 to 1 px"),
        (&["render", "--rate", "5", "--preset", "paper", "-o", picture], "take preset fast"),
    ];
    for (arguments, expected) in cases {
        let output = raindrops(arguments);
        let error = crate::common::said::failure(&output, 2);
        assert!(error.contains(expected), "{arguments:?}: {error}");
        assert!(output.stdout.is_empty());
    }
    assert!(fs::metadata(picture).is_err());
}

#[test]
fn an_updraught_holds_up_rain_and_the_report_says_so() {
    let still = rain(&["--rate", "25"]);
    let output = raindrops(&["rain", "--rate", "25", "--wind", "0,1,0", "--json", "-"]);
    let lifted: Value = serde_json::from_slice(&output.stdout).expect("JSON");
    // A metre a second under 1.17 g/m³ is 4.22 mm/h.
    let water = still["water_g_m3"].as_f64().expect("water");
    close(&lifted["rate_that_falls_mm_h"], 25.0 - 3.6 * water, 1e-9);
    assert_eq!(lifted["drops_per_m3"], still["drops_per_m3"]);
    let notes = String::from_utf8_lossy(&output.stderr).into_owned();
    assert!(notes.contains("wind up or down") && notes.contains("5.8 mm"), "{notes}");
}

#[test]
fn the_plot_shows_what_was_asked_and_what_is_there() {
    let folder = tempfile::tempdir().expect("a folder");
    let plot = folder.path().join("sizes.svg");
    let plot = plot.to_str().expect("UTF-8");
    let output = raindrops(&["rain", "--rate", "25", "--svg", plot]);
    assert!(output.status.success());
    let text = fs::read_to_string(plot).expect("a plot");
    assert!(text.contains("asked") && text.contains("found among 1,000,000 drops"));
    let scene = Scene::parse("[rain]\nrate = 25", "a.toml").expect("a scene");
    let rain = scene.real_rain().expect("rain");
    let plotted = distribution(&rain, 1, 1e6);
    let volume = 1e6 / rain.law().number();
    let mut populated = 0;
    for ((asked, found), edges) in
        plotted.asked.iter().zip(&plotted.found).zip(plotted.edges.windows(2))
    {
        let expected = asked * volume * (edges[1] - edges[0]);
        // Classes are counted in whole cells, of the volume at least.
        if expected > 50.0 {
            assert!((found / asked - 1.0).abs() < 5.0 / expected.sqrt(), "{edges:?} {expected}");
            populated += 1;
        }
    }
    assert!(populated > 30, "{populated}");
}
