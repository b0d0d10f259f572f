//! What scenes may say of drops' shapes and motion, of water, exposure, lens and background: what is refused,
//! and what no preset draws.

use glam::Vec3;
use raindrops::environment::Environment;
use raindrops::plan::{Output, plan};
use raindrops::reference::{Tracer, Truth, Weights};
use raindrops::scene::model::{Lens, Motion, Preset};
use raindrops::scene::{PlacedDrop, Scene};

use crate::common::painted;

fn parse(text: &str) -> raindrops::Result<Scene> {
    Scene::parse(text, "test.toml")
}

#[test]
fn bad_values_are_refused_with_their_key() {
    for (text, told) in [
        ("metres = 0.0", "metres = 0"),
        ("[camera]\nshutter = -0.1", "shutter = -0.1"),
        ("[camera]\nshutter = nan", "shutter = NaN"),
        ("[camera]\nshutter = inf", "shutter = inf"),
        ("[camera]\nshutter_angle = 361.0", "shutter_angle = 361"),
        ("[camera]\nshutter_angle = -1.0", "shutter_angle = -1"),
        ("[camera]\nshutter_angle = 180.0\nshutter = 0.1", "not both"),
        ("[camera]\naperture = -1.0", "aperture = -1"),
        ("[camera]\naperture = inf", "aperture = inf"),
        (
            "[camera]\nfocus = 0.0",
            "focus = 0 is not over 0 scene units; it is a distance before the camera",
        ),
        ("[camera]\nfocus = -2.0", "focus = -2 is not over 0"),
        ("[camera]\nfocus = nan", "focus = NaN"),
        (
            "[camera]\nvelocity = [0.0, nan, 0.0]",
            "camera: the second of velocity = NaN is not finite",
        ),
        ("[camera]\nvelocity = [8e5, 8e5, 0.0]", "is not up to 1e6 scene units a second"),
        ("[camera]\nvelocity = [0.0, inf, 0.0]", "the second of velocity = inf"),
        (
            "[camera]\nshutter = 0.1\n[[film.camera]]\nat = 0.0\nposition = [0, 0, 0]\ntarget = [0, 0, -1]\n\
             [[film.camera]]\nat = 1e-6\nposition = [1, 0, 0]\ntarget = [0, 0, -1]",
            "the camera is faster than 1e6",
        ),
        ("[camera]\nshutter = 1.0\nvelocity = [-1e5, 0, 0]", "crosses its box 48.8 times"),
        // The default rain falls 9 units a second through 2050.
        ("[camera]\nshutter = 7200.0", "crosses its box 31.6 times"),
        ("[camera]\nshutter = 1.0\n[rain]\nvelocity = [1e6, 0, 0]", "crosses its box 487.8 times"),
        ("[camera]\nshutter = 4.0\n[[film.pace]]\nat = 0.0\nrate = -1e5", "crosses its box"),
        (
            "[camera]\nshutter = 1e200\n[[drop]]\ncenter = [0, 0, -5]\nvelocity = [1e200, 0, 0]",
            "beyond all numbers",
        ),
        ("[[drop]]\ncenter = [0, 0, -5]\naxis_ratio = 0.0", "drop 1: axis_ratio = 0"),
        ("[[drop]]\ncenter = [0, 0, -5]\naxis_ratio = nan", "drop 1: axis_ratio = NaN"),
        ("[[drop]]\ncenter = [0, 0, -5]\naxis_ratio = -0.5", "axis_ratio = -0.5"),
        ("[[drop]]\ncenter = [0, 0, -5]\naxis_ratio = 0.9\nshape = \"equilibrium\"", "not both"),
        ("[[drop]]\ncenter = [0, 0, -5]\nshape = \"egg\"", "equilibrium"),
        (
            "[[drop]]\ncenter = [0, 0, -5]\nvelocity = [0, inf, 0]",
            "drop 1: the second of velocity = inf is not finite",
        ),
        ("rain = []", "the list is empty"),
        ("[[rain]]\n[[rain]]\n[[rain]]\n[[rain]]\n[[rain]]", "5 populations are over 4"),
        ("[[rain]]\nrate = 5.0\n[[rain]]\ncount = 5", "real rain (rate) stands alone"),
        ("[[rain]]\n[[rain]]\nradius = 0.0", "rain 2: radius"),
        ("[[rain]]\n[[rain]]\nspeed = 0.0", "speed"),
        ("[[rain]]\ncount = 900000000\n[[rain]]\ncount = 900000000", "count = 1800000000"),
        ("[rain]\nrate = 5.0\nseed = 7", "rate and seed do not go together"),
        ("[model]\nsimulation = \"stored\"\n[[rain]]\n[[rain]]", "one population"),
        ("[camera]\nshutter = 1.0\n[[rain]]\n[[rain]]\nvelocity = [1e6, 0, 0]", "crosses its box"),
        ("[water]\nindex = 0.5", "index = 0.5"),
        ("[water]\nindex = nan", "index = NaN"),
        ("[water]\nindex = [1.33, 1.33, 9.0]", "index = 9"),
        ("[water]\nindex = [1.33, 1.33]", "a number, or three"),
        ("[water]\noutside = 0.0", "outside = 0"),
        ("[background]\ndepth = \"d.exr\"\ndepth_kind = \"round\"", "planar"),
        ("[background]\ndepth = \"d.exr\"\ndepth_scale = -1.0", "depth_scale = -1"),
        ("[background]\ndepth_scale = 1.0", "but no depth"),
        ("[pane]\nthickness = 0.0", "pane: it has no place"),
        ("[pane]\npoint = [0, 0, -1]", "pane: it has no place"),
        ("[pane]\ndistance = 1.0\npoint = [0, 0, -1]", "not both"),
        ("[pane]\ndistance = 0.0", "distance = 0"),
        ("[pane]\ndistance = 1.0\ntilt = 90.0", "tilt = 90"),
        ("[pane]\npoint = [0, 0, -1]\nnormal = [0, 0, -1]\ntilt = 3.0", "tilt goes with distance"),
        ("[pane]\npoint = [0, 0, -1]\nnormal = [0, 0, 0]", "normal"),
        ("[pane]\npoint = [0, 0, -1]\nnormal = [0, 0, 1]", "is on the wet side"),
        ("[pane]\npoint = [0, 0, -1]\nnormal = [0, 0, -1]\nthickness = 1.0", "is within the glass"),
        (
            "[camera]\naperture = 3.0\n[pane]\npoint = [0, 0, -1]\nnormal = [0, 1, -1]",
            "nearer to the dry face than its lens",
        ),
        (
            "[pane]\npoint = [0, 0, -1]\nnormal = [0, 0, -1]\n[[film.camera]]\nat = 0.0\nposition = [0, 0, -3]\n\
             target = [0, 0, -4]",
            "[0, 0, -3] is on the wet side",
        ),
        ("[pane]\ndistance = 1.0\nthickness = -0.1", "thickness = -0.1"),
        ("[pane]\ndistance = 1.0\nindex = 0.9", "index = 0.9"),
        ("[pane]\ndistance = 1.0\ncontact_angle = 180.0", "contact_angle = 180"),
        ("[pane]\ndistance = 1.0\ncontact_angle = 0.0", "contact_angle = 0"),
        ("[pane]\ndistance = 1.0\ninside = [0, 0, -1]", "inside"),
        ("[pane]\ndistance = 1.0\nframe = \"car\"", "world"),
        ("[pane]\ndistance = 1.0\n[water]\noutside = 1.33", "water.outside must be 1"),
        (
            "[pane]\ndistance = 1.0\n[[pane.drop]]\nat = [0, 0]\nradius = 0.0",
            "pane: drop 1: radius = 0",
        ),
        (
            "[pane]\ndistance = 1.0\n[[pane.drop]]\nat = [0, nan]\nradius = 0.1",
            "pane: drop 1: the second of at = NaN",
        ),
        (
            "[pane]\ndistance = 1.0\n[[pane.drop]]\nat = [0, 0]\nradius = 0.1\ncontact_angle = 171.0",
            "pane: drop 1: contact_angle = 171",
        ),
        (
            "[pane]\ndistance = 1.0\n[[pane.drop]]\nat = [0, 0]\nradius = 0.1\n[[pane.drop]]\nat = [9, 0]\nradius = 0.1\n\
             [[pane.drop]]\nat = [0.1, 0.1]\nradius = 0.1",
            "pane: drop 3: its disc overlaps that of drop 1",
        ),
        ("[pane]\ndistance = 1.0\nage = 5.0", "need a rate"),
        ("[pane]\ndistance = 1.0\nrate = 2001.0", "rate = 2001"),
        ("[pane]\ndistance = 1.0\nrate = -1.0", "rate = -1"),
        ("[pane]\ndistance = 1.0\nrate = 5.0\nage = -1.0", "age = -1"),
        (
            "[pane]\ndistance = 1.0\nrate = 5.0\nage = 31536000.0\nvelocity = [0, 0, -14]",
            "pane: age = 31536000 s: some",
        ),
        ("[pane]\ndistance = 1.0\nrate = 5.0\nvelocity = [0, 0, -400]", "velocity"),
        ("[pane]\ndistance = 1.0\nrate = 5.0\nangles = [20, 50]", "angles = [20, 50]"),
        ("[pane]\ndistance = 1.0\nrate = 5.0\nretained = 0.0", "retained = 0"),
        ("[pane]\ndistance = 1.0\nrate = 5.0\ntrail = -0.1", "trail = -0.1"),
        ("[pane]\ndistance = 1.0\nrate = 5.0\nextent = [0, 1]", "the first of extent = 0"),
        ("[pane]\ndistance = 1.0\ntilt = 60.0\nrate = 5.0", "sees it to the horizon"),
        (
            "[pane]\ndistance = 1.0\nrate = 5.0\nextent = [1, 1]\n[[pane.drop]]\nat = [0, 0]\nradius = 0.6",
            "pane: drop 1: radius = 0.6",
        ),
        ("[shelter]", "shelter: give a height map"),
        ("[shelter]\nheight = \"h.exr\"\nfrom = [20, -20]", "shelter: its x runs from 20 to 20"),
        ("[shelter]\nheight = \"h.exr\"\nto = [20, -21]", "its z runs from -20 to -21"),
        ("[shelter]\nheight = \"h.exr\"\nto = [20, inf]", "to = inf"),
        ("[shelter]\nheight = \"h.exr\"\nheight_scale = 0.0", "height_scale = 0"),
        ("[shelter]\nheight = \"h.exr\"\nheight_scale = nan", "height_scale = NaN"),
        ("[shelter]\nheights = \"h.exr\"", "did you mean `height`?"),
        (
            "[shelter]\nheight = \"h.exr\"\n[rain]\nvelocity = [0, 0, 0]",
            "rain: velocity = [0, 0, 0] does not fall",
        ),
        (
            "[shelter]\nheight = \"h.exr\"\n[rain]\nrate = 5.0\nwind = [0, 4, 0]",
            "rain: wind blows up with 4 m/s",
        ),
        ("[model]\nsplat_px = 0.39", "splat_px = 0.39 is not within 0.4 to 1.5 px"),
        ("[model]\nsplat_px = 1.51", "splat_px = 1.51 is not within"),
        ("[model]\nsplat_px = nan", "splat_px = NaN is not within"),
        ("[model]\nsamples = 257", "samples = 257 is not within 1 to 256"),
        ("[model]\ninternal_reflections = 9", "internal_reflections = 9 is not within 0 to 8"),
    ] {
        let problem = match parse(text) {
            Ok(_) => panic!("{text} is taken"),
            Err(error) => error.to_string(),
        };
        assert!(problem.contains(told), "{text}: {problem}");
        assert_eq!(problem.lines().count(), 1, "{problem}");
    }
    // Near the borders of what is refused.
    for text in [
        "[camera]\nshutter = 3600.0\nfocus = inf\naperture = 2.0",
        "[camera]\nshutter_angle = 360.0",
        "[pane]\ndistance = 1.0\nthickness = 0.0\nindex = 1.0\n[[pane.drop]]\nat = [0, 0]\nradius = 5.0",
        "[pane]\ndistance = 1.5\nthickness = 1.0\nindex = 1.2\n[camera]\naperture = 0.9",
        "[pane]\ndistance = 1.0\nrate = 0.0",
        "[pane]\ndistance = 1.0\nrate = 2000.0\nage = 1.0\nextent = [0.1, 0.1]\nsimulation = \"running\"",
        "[pane]\npoint = [0, 0, 9]\nnormal = [0, 0, 1]",
        "[shelter]\nheight = \"h.exr\"\nheight_scale = 1e-3\nfrom = [0, 0]\nto = [1, 1]",
        "[model]\nsplat_px = 0.4",
        "[model]\nsplat_px = 1.5",
        "[water]\nindex = 1\noutside = 1.33",
        "[water]\nindex = [1.33, 1.34, 1.35]",
        "[[drop]]\ncenter = [0, 0, -5]\naxis_ratio = 20\nvelocity = [1e6, 0, 0]",
    ] {
        let scene = parse(text).unwrap_or_else(|error| panic!("{text}: {error}"));
        // What is written is read again.
        let written = toml::to_string(&scene).expect("text");
        assert_eq!(parse(&written).expect("a scene"), scene);
    }
}

#[test]
fn the_shutter_follows_the_films_pace() {
    let scene = parse(
        "[camera]\nshutter_angle = 180.0\n[film]\nfps = 24.0\n\
         [[film.pace]]\nat = 0.0\nrate = 1.0\n[[film.pace]]\nat = 2.0\nrate = -1.0",
    )
    .expect("a scene");
    assert_eq!(scene.shutter(), 1.0 / 48.0);
    let exposed = |number| scene.film.frame(&scene, number).exposed();
    assert_eq!(exposed(0), 1.0 / 48.0);
    assert!((exposed(12) - 0.5 / 48.0).abs() < 1e-15);
    assert_eq!(exposed(24), 0.0);
    assert_eq!(exposed(48), -1.0 / 48.0);
    assert_eq!(exposed(100), -1.0 / 48.0);
}

#[test]
fn what_no_preset_draws_is_said_with_the_command_that_does() {
    let sky = Environment::constant(Vec3::ONE);
    let drop = "[[drop]]\ncenter = [0, 0, -5]\n";
    for (text, key) in [
        // Through more of its box than is drawn.
        ("[camera]\nshutter = 60.0", "camera: shutter"),
        ("[camera]\naperture = 1e7", "camera"),
        ("[camera]\naperture = 0.01\nfocus = 1e-7", "camera"),
    ] {
        let scene = parse(text).unwrap_or_else(|error| panic!("{text}: {error}"));
        let problem = match plan(&scene, &sky, Output::Display) {
            Ok(_) => panic!("{text} is drawn"),
            Err(error) => error.to_string(),
        };
        assert!(problem.starts_with(key) && problem.contains("raindrops reference"), "{problem}");
    }
    // The paper's mask is of water in air.
    for text in ["[water]\nindex = 1.34", "[water]\nindex = 1.0\noutside = 1.33"] {
        let mut scene = parse(text).expect("a scene");
        assert!(plan(&scene, &sky, Output::Display).is_ok(), "{text}");
        scene.model.take_preset(Preset::Paper);
        let problem = plan(&scene, &sky, Output::Display).expect_err(text).to_string();
        assert!(problem.contains("1.33 alone; take preset fast"), "{problem}");
    }
    // Points and quads know no exposure, and each model of motion goes with its optics.
    for (text, told) in [
        ("[model]\npreset = \"paper\"", "a point is drawn at an instant; take preset fast"),
        ("[model]\npreset = \"exact\"\nmotion = \"streak\"", "optics must be appearance"),
        ("[model]\npreset = \"fast\"\nmotion = \"sampled\"", "optics must be closed-form"),
    ] {
        let scene = parse(&format!("[camera]\nshutter_angle = 90.0\n{text}")).expect("a scene");
        let problem = plan(&scene, &sky, Output::Display).expect_err(text).to_string();
        assert!(problem.contains(told), "{problem}");
        let mut instant = scene.clone();
        instant.model.motion = Some(Motion::Instant);
        assert_eq!(plan(&instant, &sky, Output::Display).expect(text).motion, Motion::Instant);
    }
    // And no lens.
    for (text, told) in [
        ("preset = \"paper\"", "a point is drawn through a pinhole; take preset fast"),
        ("preset = \"exact\"\nlens = \"disc\"", "optics must be appearance"),
        ("preset = \"fast\"\nlens = \"sampled\"", "optics must be closed-form"),
    ] {
        let text = format!("[camera]\naperture = 0.01\n[model]\n{text}");
        let scene = parse(&text).expect("a scene");
        let problem = plan(&scene, &sky, Output::Display).expect_err(&text).to_string();
        assert!(problem.contains(told), "{problem}");
        let mut pinhole = scene.clone();
        pinhole.model.lens = Some(Lens::Pinhole);
        assert_eq!(plan(&pinhole, &sky, Output::Display).expect(&text).lens, Lens::Pinhole);
    }
    // Points and quads know no depth.
    let mut scene = parse("[background]\ncolor = \"plate.exr\"").expect("a scene");
    assert!(plan(&scene, &sky, Output::Display).is_ok());
    scene.model.take_preset(Preset::Paper);
    let problem = plan(&scene, &sky, Output::Display).expect_err("points").to_string();
    assert!(problem.contains("background") && problem.contains("take preset fast"), "{problem}");
    // And what comes to the usual is drawn.
    for text in [
        format!("{drop}axis_ratio = 1\nvelocity = [0, -9, 0]"),
        format!("{drop}shape = \"sphere\""),
        format!("{drop}axis_ratio = 0.9"),
        format!("{drop}shape = \"equilibrium\""),
        "[camera]\nshutter = 0.0\naperture = 0.0\nfocus = 2.0".into(),
        "[camera]\nshutter = 0.01".into(),
        "[camera]\naperture = 0.01\nfocus = inf".into(),
        "[camera]\nshutter = 0.01\naperture = 1e6\nfocus = 1e-6".into(),
        "[camera]\nshutter_angle = 90.0".into(),
        "[water]\nindex = [1.33, 1.33, 1.33]\noutside = 1".into(),
    ] {
        let scene = parse(&text).unwrap_or_else(|error| panic!("{text}: {error}"));
        plan(&scene, &sky, Output::Display).unwrap_or_else(|error| panic!("{text}: {error}"));
    }
}

fn picture(scene: &Scene, environment: &Environment, truth: Truth) -> Vec<Vec3> {
    Tracer::new(scene, environment, truth).picture().pixels
}

fn one_drop(axis_ratio: f64) -> Scene {
    let mut scene = Scene { rain: None, ..Scene::default() };
    (scene.image.width, scene.image.height) = (24, 24);
    let sphere = PlacedDrop::sphere(glam::DVec3::new(0.3, -0.8, -2.2), 1.0);
    scene.drops = vec![PlacedDrop { axis_ratio: Some(axis_ratio), ..sphere }];
    scene
}

#[test]
fn a_furnace_of_any_shape_stays_white() {
    let white = Environment::constant(Vec3::ONE);
    let truth = |internal_reflections, weights| Truth {
        samples: 16,
        internal_reflections,
        weights,
        ..Truth::default()
    };
    for ratio in [0.3, 0.7, 0.9, 1.0, 1.4] {
        let mut scene = one_drop(ratio);
        for index in [1.33, 1.0] {
            scene.water.index = Some(raindrops::scene::water::Index::One(index));
            scene.water.outside = if index == 1.0 { 1.33 } else { 1.0 };
            for truth in [
                truth(8, Weights::Conserving),
                truth(2, Weights::Conserving),
                truth(8, Weights::Paper),
            ] {
                for pixel in picture(&scene, &white, truth) {
                    assert!((pixel - Vec3::ONE).abs().max_element() < 1e-6, "{ratio}: {pixel}");
                }
            }
        }
        // The control: what is left out of eight orders is missing, and no more than that. Along the
        // surface of a flat drop light stays longer.
        scene.water = Default::default();
        let least = picture(&scene, &white, truth(8, Weights::Physical))
            .into_iter()
            .map(|pixel| pixel.x)
            .fold(1.0, f32::min);
        assert!(least < 1.0 - 1e-6 && least > 0.4, "{ratio}: {least}");
    }
}

#[test]
fn each_colour_has_the_light_of_its_own_index() {
    let texels = (0..128 * 64).map(|i| Vec3::new((i % 7) as f32, (i % 5) as f32, (i % 11) as f32));
    let noise = Environment::from_texels("noise", 128, 64, texels.collect()).expect("valid");
    let truth = Truth { samples: 2, ..Truth::default() };
    for ratio in [1.0, 0.8] {
        let scene = |index: &str| Scene {
            drops: one_drop(ratio).drops,
            rain: None,
            ..parse(&format!("[image]\nwidth = 24\nheight = 24\n[water]\nindex = {index}"))
                .expect("a scene")
        };
        let all = picture(&scene("[1.3, 1.34, 1.4]"), &noise, truth);
        let single = ["1.3", "1.34", "1.4"].map(|index| picture(&scene(index), &noise, truth));
        assert_ne!(single[0], single[1]);
        for (pixel, color) in all.iter().enumerate() {
            for axis in 0..3 {
                assert_eq!(color[axis], single[axis][pixel][axis]);
            }
        }
    }
}

/// A drop of 3 mm in the equilibrium shape, in metres and in millimetres, against a ray that was followed
/// elsewhere.
#[test]
fn the_equilibrium_shape_is_that_of_the_diameter() {
    let direction = glam::DVec3::new(0.465625, 0.806021, 0.365408);
    // White in a cap around where the outside reflects this ray to, else black.
    let cap = painted(512, |toward| {
        Vec3::splat(f32::from(u8::from(toward.angle_between(direction) < 0.02)))
    });
    let seen = |shape: &str, metres: f64| {
        let scene = parse(&format!(
            "metres = {metres}\n[camera]\nposition = [0.3, 0.4, 10]\ntarget = [0.3, 0.4, 0]\n\
             [[drop]]\ncenter = [0, 0, 0]\n{shape}"
        ))
        .expect("a scene");
        let truth = Truth { internal_reflections: 0, glints: false, ..Truth::default() };
        Tracer::new(&scene, &cap, truth).radiance_along(glam::DVec3::NEG_Z).x
    };
    let equilibrium = "shape = \"equilibrium\"";
    assert!((seen(equilibrium, 0.0015) - 0.022006).abs() < 1e-5);
    // The controls: another diameter is another shape; a sphere is none.
    assert_eq!(seen(equilibrium, 0.0025), 0.0);
    assert_eq!(seen("shape = \"sphere\"", 0.0015), 0.0);
    assert_eq!(seen(equilibrium, 0.0004), seen("shape = \"sphere\"", 1.0));
}

#[test]
fn populations_are_read_and_written() {
    let text = "seed = 5\n[[rain]]\ncount = 3\n[[rain]]\nseed = 9\ncount = 4\nradius = 0.5\n[[rain]]\nvelocity = [1, 2, 3]";
    let scene = parse(text).expect("a scene");
    let all = scene.populations();
    let figures: Vec<_> = all.iter().map(|rain| (rain.seed, rain.count, rain.radius)).collect();
    assert_eq!(figures, [(5, 3, 1.0), (9, 4, 0.5), (7, 1_000_000, 1.0)]);
    assert_eq!(all[2].velocity.to_array(), [1.0, 2.0, 3.0]);
    assert_eq!(scene.drop_count(), 1_000_007);
    let written = toml::to_string(&scene).expect("text");
    assert_eq!(parse(&written).expect("a scene"), scene, "{written}");
    // One is a table.
    let one = parse("[[rain]]\ncount = 3").expect("a scene");
    assert_eq!(one, parse("[rain]\ncount = 3").expect("a scene"));
    assert!(toml::to_string(&one).expect("text").contains("[rain]"));
}

#[test]
fn what_is_out_of_range_has_its_line() {
    for (line, text) in [
        (2, "seed = 1\ntime = inf"),
        (3, "[camera]\nnear = 1.0\nvertical_fov = 0.0"),
        (3, "\n[image]\nwidth = 100000"),
        (1, "image = { width = 0 }"),
        (1, "tone_map.key = 0.0"),
        (5, "[[rain]]\nradius = 0.1\n[[rain]]\nseed = 2\nradius = -1.0"),
        (
            6,
            "[[drop]]\ncenter = [0.0, 0.0, 0.0]\nradius = 0.1\n[[drop]]\ncenter = [0.0, 0.0, 0.0]\nradius = 0.0",
        ),
        (3, "[rain]\nrate = 25.0\ndiameters = [2.0, 1.0]"),
        (3, "[pane]\ndistance = 1.0\nindex = 0.5"),
        (
            8,
            "[pane]\ndistance = 1.0\n[[pane.drop]]\nat = [0.0, 0.0]\nradius = 0.1\n[[pane.drop]]\nat = [5.0, 0.0]\nradius = 0.0",
        ),
        (2, "[model]\nerror = 0.1\npreset = \"paper\""),
        (2, "[film]\npace = [{ at = 1.0, rate = 1.0 }, { at = 0.0, rate = 1.0 }]"),
    ] {
        let message = Scene::parse(text, "s.toml").expect_err(text).to_string();
        assert!(message.starts_with(&format!("s.toml:{line}: ")), "{text}: {message}");
    }
}
