//! A short run on a device: the models' pictures of a scene are within the bounds, and a picture of another scene is not.

use std::fmt::Write as _;
use std::path::Path;

use raindrops::picture::tone_map::exposure_of;
use raindrops::plan::Costs;
use raindrops::scene::Scene;
use raindrops::scene::model::Preset;

use crate::bounds::Miss;
use crate::bytes::Child;
use crate::common::{folder, on_device};
use crate::folder::{read, write};
use crate::keep::keep;
use crate::measure::{Asked, Hunt};
use crate::models::{Model, Place, differing};
use crate::report::page;
use crate::row::{Bytes, Row};
use crate::scene::{Made, make};
use crate::sweep::Swept;
use crate::trace::Tracing;

/// Three drops of some pixels before a sky without a sun.
const CLEAR: &str = "[camera]\nvertical_fov = 40.0\n[image]\nwidth = 64\nheight = 64\n\
    [environment]\nfile = \"sky.exr\"\n\
    [[drop]]\ncenter = [-0.4, 0.1, -4.0]\nradius = 0.1\n\
    [[drop]]\ncenter = [0.3, 0.3, -4.0]\nradius = 0.15\n\
    [[drop]]\ncenter = [0.2, -0.5, -4.0]\nradius = 0.06\n";

pub fn hunt(device: &std::sync::Arc<raindrops::gpu::Device>, kept: Option<&Path>) -> Hunt {
    let place = Place { device: device.clone(), costs: Costs::default() };
    let kept = kept.map(|folder| (folder.to_path_buf(), 7));
    let tracing = Tracing { most_samples: 128, most_seconds: 60.0, kept };
    let child = Child { program: "none".into(), options: Vec::new() };
    Hunt { place, tracing, photographs: "assets/environments".into(), child }
}

/// A sky of waves, which no drop makes a glint of.
fn sky() -> (String, crate::scene::Beside) {
    let waves = crate::common::waves();
    let (width, height) = (waves.width(), waves.height());
    let pixels = waves.texels().to_vec();
    let picture = raindrops::picture::Picture { width, height, pixels };
    ("sky.exr".into(), crate::scene::Beside::Radiance(picture))
}

#[test]
fn right_pictures_are_within_the_bounds_and_wrong_ones_are_not() {
    let [place, references] = [folder(), folder()];
    let made = Made { text: CLEAR.into(), files: vec![sky()] };
    write(&made, place.path()).expect("a scene");
    let loaded = read(&place.path().join("scene.toml"), Path::new("none")).expect("a scene");
    on_device(|device| {
        let hunt = hunt(device, Some(references.path()));
        let measured = hunt.measure("clear", &loaded, &Asked::default()).expect("figures");
        assert_eq!(measured.row.models.len(), 3);
        assert!(measured.row.of_drops > 0.005 && measured.row.of_drops < 0.2, "{:?}", measured.row);
        let counting =
            |row: &Row| row.misses().into_iter().filter(Miss::counts).collect::<Vec<_>>();
        assert!(counting(&measured.row).is_empty(), "{:?}", measured.row);

        // The control: drops of glass before a reference of water.
        let glass = format!("{CLEAR}[water]\nindex = 1.9\n");
        let wrong = loaded.with_text(&glass, Path::new("none")).expect("a scene");
        let model = Model::new(&hunt.place, &wrong.scene, &wrong.environment, Preset::Exact);
        let picture = model.and_then(|model| model.draw(1)).expect("a picture").picture;
        let found = measured.halves.figures(&picture, measured.exposure, &measured.row.noise);
        assert!(found.boxes > 8.0 && found.dots > 5.0 && found.flip > 0.15, "{found:?}");

        // What is kept is taken up again, whatever the folder of the files is called, and only for this scene.
        let count = || std::fs::read_dir(references.path()).expect("a folder").count();
        assert_eq!(count(), 1);
        let again = hunt.measure("clear", &loaded, &Asked::default()).expect("figures");
        assert!(again.halves == measured.halves && count() == 1);
        hunt.measure("clear", &wrong, &Asked::default()).expect("figures");
        assert_eq!(count(), 2);

        // Its folder, and the page of a run of it.
        let kept = crate::keep::folder(place.path(), 0);
        keep(&measured, &kept).expect("a folder");
        let mut bad = measured.row.clone();
        if let Some(exact) = bad.models.get_mut("exact") {
            exact.figures = found;
        }
        let page = page(&[bad, Row { number: 1, ..measured.row.clone() }], "A run.", place.path());
        for part in ["2 scenes", "1 (50.0 %) miss", "| `exact` | 1 of 2 |", "scenes/00000/side.png"]
        {
            assert!(page.contains(part), "no {part} in\n{page}");
        }
    });
}

/// Bytes of other runs and of parts; a changed pixel is one that differs. Threads have processes, which a test does not start.
#[test]
fn a_pixel_that_differs_is_found() {
    let place = folder();
    write(&Made { text: CLEAR.into(), files: vec![sky()] }, place.path()).expect("a scene");
    let loaded = read(&place.path().join("scene.toml"), Path::new("none")).expect("a scene");
    on_device(|device| {
        let hunt = hunt(device, None);
        let model = Model::new(&hunt.place, &loaded.scene, &loaded.environment, Preset::Fast);
        let model = model.expect("a plan");
        let first = model.draw(1).expect("a picture").picture;
        assert_eq!(differing(&first, &model.draw(1).expect("a picture").picture), 0);
        let parts = model.draw_by_parts().expect("parts").expect("a whole picture");
        assert_eq!(differing(&first, &parts), 0);
        let mut other = first.clone();
        other.pixels[77].y = f32::from_bits(other.pixels[77].y.to_bits() + 1);
        assert_eq!(differing(&first, &other), 1);
        let bytes = Bytes { by_parts: Some(1), ..Bytes::default() };
        assert_eq!(bytes.most(), 1);
    });
}

/// The radius is swept from 0.3 to 40 pixels, and the step is that of a picture that changes as the reference does.
#[test]
fn a_sweep_is_of_what_the_scene_has() {
    let scene = Scene::parse(CLEAR, "a scene").expect("a scene");
    let all: Vec<Swept> = (0..5).filter_map(|number| Swept::of(&scene, number)).collect();
    assert!(all.iter().all(|swept| matches!(swept, Swept::Radius | Swept::Distance)), "{all:?}");
    assert!(all.contains(&Swept::Radius) && all.contains(&Swept::Distance));
    let mut rain = String::from("[camera]\nshutter = 0.01\naperture = 0.1\n[rain]\nrate = 10.0\n");
    let _ = write!(rain, "extent = 20.0\n[image]\nwidth = 32\nheight = 32\n");
    let scene = Scene::parse(&rain, "a scene").expect("a scene");
    let all: Vec<Swept> = (0..3).filter_map(|number| Swept::of(&scene, number)).collect();
    assert_eq!(all, [Swept::Shutter, Swept::Aperture, Swept::Rate]);
}

/// Three scenes of a run, none chosen: each has figures or says why not.
#[test]
fn a_short_run() {
    let skies = std::env::var_os("RAINDROPS_TEST_WITHOUT_PHOTOGRAPHS").is_some();
    on_device(|device| {
        let hunt = Hunt {
            tracing: Tracing { most_samples: 32, most_seconds: 0.0, kept: None },
            ..hunt(device, None)
        };
        let mut measured = 0;
        for number in 0..5 {
            let made = make(1, number);
            if skies && made.text.contains(crate::scene::PHOTOGRAPHS) {
                continue;
            }
            let place = folder();
            write(&made, place.path()).expect("a scene");
            let loaded =
                read(&place.path().join("scene.toml"), &hunt.photographs).expect("a scene");
            if loaded.scene.real_rain().is_some() {
                continue;
            }
            let found = hunt.measure("", &loaded, &Asked::default());
            let found = found.unwrap_or_else(|problem| panic!("scene {number}: {problem}"));
            let exposure = exposure_of(&loaded.scene.tone_map, &found.halves.mean());
            assert_eq!(found.exposure, exposure);
            for (name, model) in &found.row.models {
                let figures = model.figures;
                let all = [figures.boxes, figures.dots, figures.flip, figures.rms, model.ms];
                assert!(
                    all.iter().all(|figure| figure.is_finite() && *figure >= 0.0),
                    "{name}: {all:?}"
                );
            }
            measured += 1;
        }
        assert!(measured >= 3, "{measured} scenes");
    });
}
