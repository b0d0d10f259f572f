//! Which panes are refused, and why: the camera on the wrong side, drops that overlap, rain that has no end.

use glam::DVec3;

use super::{Frame, Pane, PaneDrop};
use crate::scene::Scene;

/// Most arrivals that are followed, which take minutes. After some hundred seconds of rain a pane is as it stays.
const MOST_ARRIVALS: f64 = 1e8;

/// Most drops of a host's: devices take 2^27 texels of a buffer, and one of what drops look like has 208 for each.
const MOST_OF_HOST: u32 = 1 << 19;

/// Fastest pane, m/s: that of sound.
const FASTEST: f64 = 340.0;

/// Says what is wrong with a scene's pane, and what would be right.
pub(in crate::scene) fn problem(scene: &Scene) -> Result<(), String> {
    let own = scene.host_pane_drops;
    let Some(pane) = &scene.pane else {
        return check(own == 0, || "there is none for the host's drops; give one".into());
    };
    check(own <= MOST_OF_HOST, || format!("host_pane_drops = {own} is over {MOST_OF_HOST}"))?;
    check(own == 0 || pane.drops.is_empty() && !pane.has_population(), || {
        "a host's drops are instead of all others; take out host_pane_drops, or the drops and all keys of rain on the pane".into()
    })?;
    place(pane)?;
    if scene.water.outside != 1.0 {
        return Err("pane: water.outside must be 1: the pane stands in air".into());
    }
    camera_side(scene)?;
    placed(pane)?;
    population(scene, pane)
}

fn check(good: bool, problem: impl FnOnce() -> String) -> Result<(), String> {
    if good { Ok(()) } else { Err(format!("pane: {}", problem())) }
}

/// Where it stands.
fn place(pane: &Pane) -> Result<(), String> {
    let Pane { point, normal, distance, tilt, .. } = pane;
    check(distance.is_none() || (point.is_none() && normal.is_none()), || {
        "give point and normal, or distance, not both".into()
    })?;
    check(distance.is_some() || (point.is_some() && normal.is_some()), || {
        "it has no place: give point and normal, or distance".into()
    })?;
    check(distance.is_some() || tilt.is_none(), || "tilt goes with distance".into())?;
    check(normal.is_none_or(|normal| normal.length() > 0.0), || {
        "normal must be a vector that is not zero".into()
    })
}

/// Whether all of the lens is on the dry side, as the shutter opens and closes, and at every key of a film.
fn camera_side(scene: &Scene) -> Result<(), String> {
    let Some((pane, face)) = scene.pane.as_ref().zip(scene.pane_face()) else { return Ok(()) };
    let is_fixed = pane.frame == Frame::World && pane.distance.is_none();
    let moved = if pane.frame == Frame::World { scene.camera_motion() } else { DVec3::ZERO };
    let keys = scene.film.camera.iter().filter(|_| is_fixed).map(|key| key.position);
    let view = scene.view();
    let lens =
        0.5 * scene.camera.aperture * view.right.dot(face.normal).hypot(view.up.dot(face.normal));
    for position in keys.chain([scene.camera.position, scene.camera.position + moved]) {
        // Towards the inside, from the dry face.
        let before = -(position - face.point).dot(face.normal) - pane.thickness;
        if before > lens {
            continue;
        }
        let DVec3 { x, y, z } = position;
        let problem = if before + pane.thickness < 0.0 {
            "on the wet side; turn normal, which points outside, away from the camera".into()
        } else if before <= 0.0 {
            format!("within the glass, of thickness = {}", pane.thickness)
        } else {
            format!(
                "nearer to the dry face than its lens, of aperture = {}, is wide",
                scene.camera.aperture
            )
        };
        return Err(format!("pane: the camera at [{x}, {y}, {z}] is {problem}"));
    }
    Ok(())
}

/// Drops placed by hand.
fn placed(pane: &Pane) -> Result<(), String> {
    if pane.has_population() {
        return Ok(());
    }
    match overlapping(&pane.drops) {
        Some((one, other)) => Err(format!(
            "pane: drop {other}: its disc overlaps that of drop {one}, and water that touches is one drop; move it, or make \
             one of both"
        )),
        None => Ok(()),
    }
}

/// Numbers from 1 of two drops whose discs overlap.
fn overlapping(drops: &[PaneDrop]) -> Option<(usize, usize)> {
    let mut by_left: Vec<usize> = (0..drops.len()).collect();
    let left = |number: &usize| drops[*number].at.x - drops[*number].radius;
    by_left.sort_by(|a, b| left(a).total_cmp(&left(b)));
    for (place, &one) in by_left.iter().enumerate() {
        let right = drops[one].at.x + drops[one].radius;
        for &other in by_left[place + 1..].iter().take_while(|other| left(other) < right) {
            let both = drops[one].radius + drops[other].radius;
            // Discs that touch by rounding do not overlap.
            if drops[one].at.distance(drops[other].at) < both * (1.0 - 1e-9) {
                return Some((1 + one.min(other), 1 + one.max(other)));
            }
        }
    }
    None
}

/// Rain on the pane.
fn population(scene: &Scene, pane: &Pane) -> Result<(), String> {
    if !pane.has_population() {
        return Ok(());
    }
    let Some(rain) = scene.pane_rain() else {
        return Err("pane: random drops need a rate (mm/h), of the pane or of [rain]".into());
    };
    if rain.rate > 0.0 {
        rain.validate().map_err(|problem| problem.replacen("rain:", "pane:", 1))?;
    }
    let age = pane.age();
    let DVec3 { x, y, z } = pane.velocity();
    check(pane.velocity().length() <= FASTEST, || {
        format!("velocity = [{x}, {y}, {z}] is not up to {FASTEST} m/s")
    })?;
    let [advancing, receding] = pane.angles();
    check(advancing >= receding, || {
        format!(
            "angles = [{advancing}, {receding}] must be the advancing and then the receding contact angle"
        )
    })?;
    check(
        pane.extent.is_some() || pane.frame == Frame::Camera || scene.film.camera.is_empty(),
        || {
            "in a film whose camera moves, where rain falls on the pane must be said: give extent (metres along u and v)"
            .into()
        },
    )?;
    let (from, to) = scene.pane_extent()?;
    for (number, drop) in (1..).zip(&pane.drops).filter(|_| pane.extent.is_some()) {
        let (at, radius) = (drop.at * scene.metres, drop.radius * scene.metres);
        check((at - radius).cmpge(from).all() && (at + radius).cmple(to).all(), || {
            format!(
                "drop {number}: radius = {} at {} reaches beyond the pane's extent",
                drop.radius, drop.at
            )
        })?;
    }
    let arrivals = scene.pane_flux().map_or(0.0, |flux| flux.number());
    let arrivals = arrivals * (to - from).element_product() * age;
    check(arrivals <= MOST_ARRIVALS, || {
        format!(
            "age = {age} s: some {arrivals:.1e} drops would arrive, over {MOST_ARRIVALS:.0e}; a pane is as it stays after \
             minutes of rain: give a smaller age, or extent"
        )
    })
}
