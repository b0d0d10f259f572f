//! From which radius on drops are drawn by rays, and by how many.

use super::{Models, demand};
use crate::scene::Scene;
use crate::scene::model::{Optics, Primitive};

/// Radii in pixels from which on a drop is drawn by rays rather than by its prefiltered picture: the first over which rays are
/// affordable, else the last. The finest picture has 32 texels an edge, and above the last one sees them.
const RAYS_PX: [f32; 4] = [1.5, 3.0, 6.0, MOST_RAYS_PX];
pub(super) const MOST_RAYS_PX: f32 = 12.0;
/// Rays are affordable over a radius if the rain's drops over it, times the squared radius in pixels, are at most so many. The number of drops
/// over a radius falls as its inverse cube, so these cover some 9 times as many pixels. Of Table II's scene that is 8,000
/// drops from 6 pixels on, and rays are a millisecond of a frame's 14 on two CPU cores. (From 1.5 pixels on they are 7.)
const AFFORDABLE: f64 = 30.0;
/// What is affordable of bubbles, in whose pictures light changes fast everywhere, not towards the rim alone. (918 bubbles of up to 12 pixels
/// under a sky of lamps: RMS error 0.067 to 0.034, largest mean of 8 x 8 pixels 41 to 15 levels.)
const AFFORDABLE_BUBBLES: f64 = 1_000.0;
/// Up to so many drops with a place of their own rays are affordable, whatever the drops' size: of `fast`, and of bubbles or by `exact`.
const AFFORDABLE_PLACED: [u32; 2] = [44, 444];
/// Most rays by `fast` of a pixel in which a drop's light varies strongly, as it does towards the rim; where rays are not affordable, all
/// pixels have the samples of the model.
const MOST_FAST_RAYS: u32 = 32;
/// Most rays of such a pixel where all drops are drawn by rays, as by `exact`.
const MOST_EXACT_RAYS: u32 = 64;
/// Most rays by `exact` of a pixel whose light those do not tell, where few drops are over 1.5 pixels. (51 flattened drops under six suns: dots of
/// 1.75 levels to 1.24, rays take twice as long. In real rain under a sun they would take minutes.)
const MOST_UNSURE_RAYS: u32 = 512;

/// Radius in pixels over which a texel of a picture of 16 an edge is larger than `picture_edge` of `glsl/include/picture_light.glsl` asks.
/// (96 placed drops of up to 11 pixels in a room: RMS error 13.6 to 11.3 levels, largest mean of 8 x 8 pixels 25 to 12.)
const FINER_PX: f32 = 6.54;

/// How drops are drawn by rays.
pub(super) struct DrawnRays {
    /// Radius in pixels from which on they are, where smaller ones have pictures; without pictures all are.
    pub from_px: f32,
    /// Most rays of a pixel of a drop at rest, where its light changes fast.
    pub most: u32,
    /// Most rays of such a pixel, where those do not tell its light.
    pub unsure: u32,
    /// Level of the finest picture: 2 to that many texels an edge.
    pub picture_level: u32,
}

/// The rays of a scene by these models; `is_chosen`: by `auto`.
pub(super) fn rays_of(scene: &Scene, models: Models, is_chosen: bool) -> DrawnRays {
    let by_pictures = models.optics == Optics::Appearance;
    // Samples that the scene states, or that `auto` has weighed, hold for every pixel, and rays then begin at MOST_RAYS_PX. Where `auto` has
    // chosen pictures, what follows is as in `fast`.
    let is_weighed = scene.model.samples.is_some() || is_chosen && !by_pictures;
    let affordable_px = affordable_px(scene, by_pictures).filter(|_| !is_weighed);
    let most = match (by_pictures, affordable_px) {
        (true, Some(_)) => MOST_FAST_RAYS,
        (false, _) if !is_weighed => MOST_EXACT_RAYS,
        _ => models.samples,
    };
    let are_few = !by_pictures && affordable_px == Some(RAYS_PX[0]);
    let unsure = if are_few { MOST_UNSURE_RAYS } else { most };
    let from_px = affordable_px.unwrap_or(MOST_RAYS_PX);
    let shows_larger = || from_px > FINER_PX && shows_over(scene, FINER_PX);
    let picture_level = match (models.optics, models.primitive) {
        (Optics::Far, _) => 0,
        (Optics::Appearance, Primitive::Tile) if shows_larger() => 5,
        _ => 4,
    };
    DrawnRays { from_px, most, unsure, picture_level }
}

/// Whether a drop of a larger radius is to be expected.
fn shows_over(scene: &Scene, radius_px: f32) -> bool {
    demand::drops_above(scene, radius_px.into()) >= 1.0
}

/// The least radius in pixels over which rays are affordable, if there is one. None in real rain: its drops are no spheres, and
/// for each of their pixels rays are traced as at the rim. (44 drops of over 1.5 pixels of 25 mm/h took 28 ms of 96.)
fn affordable_px(scene: &Scene, by_pictures: bool) -> Option<f32> {
    if scene.real_rain().is_some() {
        return None;
    }
    let is_bubble = scene.indices().iter().all(|index| *index < 1.0);
    let most = if is_bubble { AFFORDABLE_BUBBLES } else { AFFORDABLE };
    let placed = scene.placed_count();
    let is_affordable = |px: &f32| {
        let px = f64::from(*px);
        px * px * (demand::drops_above(scene, px) - f64::from(placed)) <= most
    };
    let are_few = placed <= AFFORDABLE_PLACED[usize::from(is_bubble || !by_pictures)];
    RAYS_PX.into_iter().filter(|_| are_few).find(is_affordable)
}

#[cfg(test)]
mod tests {
    use crate::environment::Environment;
    use crate::plan::{Output, plan};
    use crate::scene::Scene;

    /// From which radius on, and how many, in `fast`'s plan of a scene.
    fn rays(text: &str) -> (f32, u32) {
        let white = Environment::constant(glam::Vec3::ONE);
        let scene = format!("{text}\n[model]\npreset = \"fast\"\n");
        let scene = Scene::parse(&scene, "a.toml").expect("a scene");
        let plan = plan(&scene, &white, Output::Display).expect("a plan");
        (plan.rays_px, plan.most_rays)
    }

    /// Table II's least has some 165 drops of over 3 pixels, whose many rays would take longer than all else.
    #[test]
    fn a_crowd_pays_for_no_rays_of_small_drops() {
        for count in [125_000, 250_000, 1_000_000, 4_000_000] {
            assert_eq!(rays(&format!("[rain]\ncount = {count}")), (12.0, 1), "{count} drops");
        }
        assert_eq!(rays("[rain]\nrate = 25.0"), (12.0, 1));
    }

    /// From 1.5 pixels on rays would take as long as all else.
    #[test]
    fn fewer_drops_pay_for_rays_of_smaller_ones() {
        for (count, from_px) in [(2_000, 1.5), (3_000, 3.0), (8_000, 6.0), (16_000, 12.0)] {
            assert_eq!(rays(&format!("[rain]\ncount = {count}")), (from_px, 32), "{count} drops");
        }
    }

    #[test]
    fn more_bubbles_than_drops_are_drawn_by_rays() {
        let scene = "[rain]\ncount = 60000";
        assert_eq!(rays(scene), (12.0, 1));
        assert_eq!(rays(&format!("{scene}\n[water]\nindex = 1.0\noutside = 1.33")), (1.5, 32));
    }

    #[test]
    fn a_few_drops_are_drawn_by_many_rays() {
        let drop = "[[drop]]\ncenter = [0.0, 0.0, -9.0]\nradius = 1.0\n";
        for (count, drawn) in [(1, (1.5, 32)), (44, (1.5, 32)), (45, (12.0, 1))] {
            assert_eq!(rays(&drop.repeat(count)), drawn, "{count} drops");
        }
        assert_eq!(rays(&format!("{drop}[rain]\ncount = 8000")), (6.0, 32));
    }

    /// A crowd has some drops that are large enough, if it is not far away.
    #[test]
    fn pictures_are_as_fine_as_drops_ask_for() {
        let white = Environment::constant(glam::Vec3::ONE);
        let level = |text: &str| {
            let scene = Scene::parse(text, "a.toml").expect("a scene");
            plan(&scene, &white, Output::Display).expect("a plan").light.picture_level
        };
        for (text, expected) in [
            ("[rain]\ncount = 16000\n[model]\npreset = \"fast\"", 5),
            ("[rain]\ncount = 16000\nradius = 0.01\n[model]\npreset = \"fast\"", 4),
            ("[rain]\ncount = 2000\n[model]\npreset = \"fast\"", 4),
            ("[rain]\ncount = 16000\n[model]\npreset = \"paper\"\noptics = \"appearance\"", 4),
            ("[rain]\ncount = 16000\n[model]\npreset = \"paper\"\noptics = \"far\"", 0),
        ] {
            assert_eq!(level(text), expected, "{text}");
        }
    }

    /// What is asked for is what is done, and in a crowd a sun in every drop would take minutes.
    #[test]
    fn exact_is_surer_of_a_few_drops() {
        let white = Environment::constant(glam::Vec3::ONE);
        let most = |text: &str| {
            let scene =
                Scene::parse(&format!("{text}\npreset = \"exact\""), "a.toml").expect("a scene");
            let plan = plan(&scene, &white, Output::Display).expect("a plan");
            [plan.samples, plan.most_rays, plan.unsure_rays]
        };
        assert_eq!(most("[rain]\ncount = 2000\n[model]"), [16, 64, 512]);
        assert_eq!(most("[rain]\ncount = 3000\n[model]"), [16, 64, 64]);
        assert_eq!(most("[rain]\nrate = 25.0\n[model]"), [16, 64, 64]);
        assert_eq!(most("[rain]\ncount = 2000\n[model]\nsamples = 16"), [16, 16, 16]);
        let drop = "[[drop]]\ncenter = [0.0, 0.0, -9.0]\n";
        assert_eq!(most(&(drop.repeat(444) + "[model]")), [16, 64, 512]);
        assert_eq!(most(&(drop.repeat(445) + "[model]")), [16, 64, 64]);
    }
}
