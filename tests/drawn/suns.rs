//! Rain before, beside and behind a bare sun: `fast` against `paper` and rays, all against the reference. The example `suns` has five
//! more scenes, and takes minutes.

#[path = "../../examples/suns/scenes.rs"]
mod scenes;

use raindrops::environment::Environment;
use raindrops::picture::metrics::rel_mse;
use raindrops::scene::model::Preset;
use scenes::{References, SUNS, shown};

use crate::common::picture::picture_of;
use crate::common::{on_device, photograph};

const SAMPLES: u32 = 16;

#[test]
fn under_a_bare_sun_fast_is_truer_than_paper_and_more_rays_are_not_worse() {
    on_device(|device| {
        for sun in [&SUNS[0], &SUNS[2], &SUNS[6]] {
            let environment = match sun.photograph.map(photograph) {
                Some(None) => continue,
                Some(Some(path)) => Environment::load(&path).expect("a photograph"),
                None => Environment::bundled().expect("the sky"),
            };
            let mut scene = sun.scene(&environment).expect("a bare sun");
            let references = References::new(&scene, &environment, SAMPLES);
            let mut errors = |preset, samples| {
                (scene.model.preset, scene.model.samples) = (preset, samples);
                let picture = picture_of(device, &scene, &environment);
                let rms = references.rms(&shown(references.exposure, &picture));
                (rms, rel_mse(&references.mean, &picture, None))
            };
            let [(paper, _), (fast, fast_mse)] =
                [Preset::Paper, Preset::Fast].map(|preset| errors(preset, None));
            let by_rays = [1, 4, 16].map(|samples| errors(Preset::Exact, Some(samples)));
            let (rays, mse) = (by_rays.map(|(rms, _)| rms), by_rays[2].1);
            let place = format!("{}, sun {}", sun.photograph.unwrap_or("sky"), sun.name);
            println!("{place}: RMS paper {paper:.4}, fast {fast:.4}, by rays {rays:.4?}");
            println!("    relMSE fast {fast_mse:.1e}, 16 rays {mse:.1e}");
            assert!(fast <= 0.6 * paper, "{place}: {fast:.4} against the paper's {paper:.4}");
            assert!(fast < rays[0], "{place}: {fast:.4}, one ray {:.4}", rays[0]);
            assert!(fast_mse < 3.0 * mse, "{place}: relMSE {fast_mse:.1e} and {mse:.1e}");
            for pair in rays.windows(2) {
                assert!(pair[1] < 1.03 * pair[0], "{place}: more rays are worse: {rays:.4?}");
            }
        }
    });
}
