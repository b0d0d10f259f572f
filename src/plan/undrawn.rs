//! What a scene may ask for and no preset draws: said, never left out in silence.

use crate::scene::Scene;
use crate::scene::model::DropShape;
use crate::{Error, Result};

/// Whether the renderer can follow every key of `scene`.
///
/// # Errors
/// [`Error::Scene`] with the first key that no preset draws, and the command that can.
pub fn check_drawable(scene: &Scene) -> Result<()> {
    let refuse = |place: String, problem: String| Err(Error::Scene { place, problem });
    match undrawn(scene) {
        Some((key, what)) => {
            refuse(key, format!("no preset draws {what}; `raindrops reference` does"))
        }
        None => Ok(()),
    }
}

/// The first key that the renderer cannot follow, and what it would have to draw.
fn undrawn(scene: &Scene) -> Option<(String, &'static str)> {
    scene.drops.iter().zip(1..).find_map(|(drop, number)| {
        let key = |key: &str| format!("drop {number}: {key}");
        if drop.axis_ratio.is_some_and(|ratio| ratio != 1.0) {
            Some((key("axis_ratio"), "a drop that is no sphere"))
        } else if drop.shape.is_some_and(|shape| shape != DropShape::Sphere) {
            Some((key("shape"), "a drop that is no sphere"))
        } else {
            None
        }
    })
}
