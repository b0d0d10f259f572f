//! What a host's frame is refused for, before anything of it is recorded.

use ash::vk;

use super::view::{View, refuse};
use super::{FrameInput, HostBackground, HostMotion, ViewInfo};
use crate::gpu::HostImage;
use crate::passes::output::FORMATS;
use crate::scene::Scene;
use crate::{Error, Result};

/// Formats that a depth may be in; of those with stencil the view is of depth alone.
const DEPTH_FORMATS: [vk::Format; 8] = [
    vk::Format::D16_UNORM,
    vk::Format::X8_D24_UNORM_PACK32,
    vk::Format::D32_SFLOAT,
    vk::Format::D16_UNORM_S8_UINT,
    vk::Format::D24_UNORM_S8_UINT,
    vk::Format::D32_SFLOAT_S8_UINT,
    vk::Format::R16_SFLOAT,
    vk::Format::R32_SFLOAT,
];

/// Refuses a background that is not what the view was made for, or cannot be read.
pub(super) fn check_background(
    background: &HostBackground,
    info: &ViewInfo,
    scene: &Scene,
) -> Result<()> {
    let whole = (scene.image.width, scene.image.height);
    let fits = |name: &str, is: bool, wanted: bool| match (is, wanted) {
        (true, false) => refuse(&format!("the view was made for no background {name}")),
        (false, true) => refuse(&format!("the view was made for a background {name}; name one")),
        _ => Ok(()),
    };
    fits("colour", background.color.is_some(), info.has_color)?;
    fits("depth", background.depth.is_some(), info.has_depth)?;
    let refuse_image = |name: &str, problem: String| Err(Error::scene(name, problem));
    if let Some((image, radiance)) = &background.color {
        let name = "the background colour";
        if !FORMATS.contains(&image.format) {
            return refuse_image(name, format!("its format is {:?}, no colour", image.format));
        }
        if !(radiance.is_finite() && *radiance > 0.0) {
            let problem = format!("the radiance of a 1 is {radiance}, not finite and over 0");
            return refuse_image(name, problem);
        }
        image.check(name, whole, true)?;
    }
    if let Some((image, convention)) = &background.depth {
        let name = "the background depth";
        if !DEPTH_FORMATS.contains(&image.format) {
            return refuse_image(name, format!("its format is {:?}, no depth", image.format));
        }
        if convention.map.iter().any(|number| !number.is_finite()) {
            let problem = format!("its convention is {:?}, not finite", convention.map);
            return refuse_image(name, problem);
        }
        image.check(name, whole, true)?;
    }
    Ok(())
}

/// Refuses images of motion and depth that are not what the view was made for, or cannot be drawn into.
pub(super) fn check_nearest(
    input: &FrameInput<'_>,
    info: &ViewInfo,
    size: (u32, u32),
) -> Result<()> {
    let motion = input.motion.map(|motion| motion.image);
    for (name, image, wanted) in [
        ("motion", motion, info.motion),
        ("nearest depth", input.nearest_depth, info.nearest_depth),
        ("nearest number", input.nearest_number, info.nearest_number),
    ] {
        match (image, wanted) {
            (None, None) => {}
            (Some(image), Some(format)) if image.format == format => {
                image.check(name, size, true)?
            }
            (Some(image), Some(format)) => {
                return refuse(&format!(
                    "the format of {name} is {:?}; the view was made for {format:?}",
                    image.format
                ));
            }
            (Some(_), None) => return refuse(&format!("the view was made for no {name}")),
            (None, Some(_)) => {
                return refuse(&format!("the view was made to draw {name}; name an image for it"));
            }
        }
    }
    let Some(HostMotion { camera, time, pixel, .. }) = input.motion else { return Ok(()) };
    if !time.is_finite() || !pixel.iter().all(|part| part.is_finite()) {
        return refuse("motion is since a time or in a unit that is not finite");
    }
    let of_before = |problem| Error::Scene { place: "the frame before".into(), problem };
    camera.validate(input.scene.image).map_err(of_before)
}

/// Refuses drops of the host's own that the view was not made for, or cannot be read.
pub(super) fn check_own(view: &View, input: &FrameInput<'_>) -> Result<()> {
    let FrameInput { particles, drops_on_pane, .. } = input;
    let Scene { host_particles, host_pane_drops, .. } = view.made_for;
    for (what, key, is_named, most) in [
        ("particles", "host_particles", particles.is_some(), host_particles),
        ("drops on the pane", "host_pane_drops", drops_on_pane.is_some(), host_pane_drops),
    ] {
        if is_named && most == 0 {
            return refuse(&format!("the view was made for no {what}; set {key} of its scene"));
        }
        if !is_named && most > 0 {
            return refuse(&format!(
                "the view was made for a host's {what}; name them, were it a count of 0"
            ));
        }
    }
    let device = &view.device;
    particles.map_or(Ok(()), |particles| particles.check(device, host_particles))?;
    drops_on_pane.map_or(Ok(()), |drops| drops.check(device, host_pane_drops))
}

/// Refuses a shelter that the view was not made for, or that cannot be read.
pub(super) fn check_shelter(input: &FrameInput<'_>, made_for: &Scene) -> Result<()> {
    match (&input.shelter, made_for.host_shelter()) {
        (None, None) => Ok(()),
        (Some(shelter), Some(size)) => {
            let format = shelter.image.format;
            if !DEPTH_FORMATS.contains(&format) {
                let problem = format!("its format is {format:?}, neither height nor depth");
                return Err(Error::scene("the shelter", problem));
            }
            shelter.check(size)
        }
        (Some(_), None) => refuse(
            "the view was made for no shelter of a host's; make its scene's by Shelter::of_host",
        ),
        (None, Some(_)) => refuse("the view was made for a host's shelter; name its map"),
    }
}

/// Refuses one image for two things: it is taken from one layout and handed back in one.
pub(super) fn check_apart(input: &FrameInput<'_>) -> Result<()> {
    let images = [
        ("the output", Some(input.output)),
        ("the background colour", input.background.color.map(|(image, _)| image)),
        ("the background depth", input.background.depth.map(|(image, _)| image)),
        ("the environment", input.environment.map(|environment| environment.image)),
        ("the shelter", input.shelter.map(|shelter| shelter.image)),
        ("motion", input.motion.map(|motion| motion.image)),
        ("nearest depth", input.nearest_depth),
        ("nearest number", input.nearest_number),
    ];
    for (number, (name, image)) in images.iter().enumerate() {
        let Some(image) = image else { continue };
        let is_same = |other: &HostImage| other.image == image.image;
        if let Some((other, _)) =
            images[..number].iter().find(|(_, other)| other.as_ref().is_some_and(is_same))
        {
            return refuse(&format!("{other} and {name} are one image; each needs its own"));
        }
    }
    Ok(())
}
