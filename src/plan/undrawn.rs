//! What a scene may ask for and no preset draws: said, never left out in silence.

use crate::scene::Scene;
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
    let camera = &scene.camera;
    let keys = [(camera.aperture > 0.0, "camera: aperture", "a lens")];
    let found = keys.into_iter().find(|(is_asked, ..)| *is_asked);
    found.map(|(_, key, what)| (key.to_string(), what))
}
