//! Scenes of the kinds that were plainly wrong once, within the bounds of the search: drops out of focus, side by side in
//! motion, with a long way, and in one another.

use std::fmt::Write as _;
use std::path::Path;

use raindrops::glam::Vec3;
use raindrops::picture::Picture;

use crate::bounds::Miss;

use crate::common::{folder, on_device, painted};
use crate::drawn::hunt;
use crate::folder::{read, write};
use crate::measure::Asked;
use crate::row::Row;
use crate::scene::{Beside, Made};

/// A blue sky over brown ground, with bright walls between: what a drop shows has edges and other colours on each side.
fn street() -> (String, Beside) {
    let street = painted(512, |d| {
        let turn = d.x.atan2(-d.z);
        match d.y {
            y if y.abs() < 0.3 && (3.0 * turn).sin() > 0.2 => Vec3::new(2.5, 2.2, 1.8),
            y if y > 0.0 => Vec3::new(0.4, 0.7, 1.2),
            _ => Vec3::new(0.12, 0.08, 0.05),
        }
    });
    let (width, height) = (street.width(), street.height());
    let pixels = street.texels().to_vec();
    ("sky.exr".into(), Beside::Radiance(Picture { width, height, pixels }))
}

/// Measures the models' pictures of a scene of so many pixels; `wall`: how far a wall behind it all is.
fn measured(
    name: &str,
    [width, height]: [u32; 2],
    camera: &str,
    drops: &[String],
    wall: Option<f32>,
) -> Row {
    let (pixels, mut files) = ((width * height) as usize, vec![street()]);
    let mut text = format!(
        "[camera]\n{camera}\n[image]\nwidth = {width}\nheight = {height}\n[environment]\nfile = \"sky.exr\"\n"
    );
    for drop in drops {
        write!(text, "[[drop]]\n{drop}\n").expect("a text");
    }
    if let Some(wall) = wall {
        text += "[background]\ncolor = \"color.exr\"\ndepth = \"depth.exr\"\n";
        let pixels = vec![Vec3::splat(0.3); pixels];
        files.push(("color.exr".into(), Beside::Radiance(Picture { width, height, pixels })));
        let depth = vec![wall; (width * height) as usize];
        files.push(("depth.exr".into(), Beside::Depth([width, height], depth)));
    }
    let place = folder();
    write(&Made { text, files }, place.path()).expect("a scene");
    let loaded = read(&place.path().join("scene.toml"), Path::new("none")).expect("a scene");
    let mut row = None;
    on_device(|device| {
        let measured =
            hunt(device, None).measure(name, &loaded, &Asked::default()).expect("figures");
        for (model, row) in &measured.row.models {
            println!("{name}, {model}: {:?}", row.figures);
        }
        row = Some(measured.row);
    });
    row.expect("a device")
}

/// Measures such a scene; panics with what is over a bound.
fn assert_within(
    name: &str,
    size: [u32; 2],
    camera: &str,
    drops: &[String],
    wall: Option<f32>,
) -> Row {
    let row = measured(name, size, camera, drops, wall);
    let misses: Vec<_> = row.misses().into_iter().filter(Miss::counts).collect();
    assert!(misses.is_empty(), "{name}: {misses:?}");
    row
}

/// A drop 50 units before the camera, so many pixels beside the middle of a picture of 64 rows at ten degrees.
fn drop_at(across: f64, down: f64, radius: f64) -> String {
    let pixel = 50.0 * 2.0 * 5.0_f64.to_radians().tan() / 64.0;
    format!("center = [{}, {}, -50.0]\nradius = {}", across * pixel, -down * pixel, radius * pixel)
}

#[test]
fn drops_out_of_focus_are_their_pictures_blurred() {
    let drops = [(-46.0, 3.0), (-22.0, 5.0), (6.0, 8.0), (42.0, 11.5)];
    let drops: Vec<_> =
        drops.iter().map(|(across, radius)| drop_at(*across, 0.0, *radius)).collect();
    for blur in [3.0, 8.0] {
        // The disc has the aperture's size at the drop: pixels are 0.137 units there.
        let camera = format!("vertical_fov = 10.0\nfocus = inf\naperture = {}", 0.2734 * blur);
        assert_within("out of focus", [128, 64], &camera, &drops, None);
    }
}

#[test]
fn drops_that_move_have_their_colours_along_the_way() {
    let radii = [(-46.0, 3.0), (-22.0, 5.0), (6.0, 8.0), (42.0, 12.5)];
    let drops: Vec<_> = radii
        .iter()
        .map(|(across, radius)| {
            format!("{}\nvelocity = [0.8, -3.4, 0.0]", drop_at(*across, -12.0, *radius))
        })
        .collect();
    assert_within("a long way", [128, 64], "vertical_fov = 10.0\nshutter = 1.0", &drops, None);
}

#[test]
fn equal_drops_that_fall_side_by_side_are_equal() {
    let drops: Vec<_> = (0..4)
        .map(|number| {
            let across = -0.6 + 0.4 * f64::from(number);
            format!("center = [{across}, 0.25, -1.5]\nradius = 0.13\nvelocity = [0.0, -25.0, 0.0]")
        })
        .collect();
    let camera = "vertical_fov = 60.0\nshutter = 0.02";
    let row = assert_within("side by side", [96, 64], camera, &drops, None);
    // 0.8; 1.8 if all pixels of a drop take the same moments.
    assert!(row.models["fast"].figures.boxes < 1.3, "{:?}", row.models["fast"].figures);
}

#[test]
fn drops_in_one_another_hide_each_other_where_they_are_nearer() {
    let shapes = ["", "axis_ratio = 0.35", "", "shape = \"equilibrium\"", "axis_ratio = 0.8"];
    let drops: Vec<_> = (0..)
        .zip(shapes)
        .map(|(number, shape)| {
            let along = f64::from(number) - 2.0;
            format!(
                "center = [{}, {}, {}]\nradius = 1.4\n{shape}",
                1.2 * along,
                -0.5 * along,
                -30.0 + 0.3 * along
            )
        })
        .collect();
    // Which is nearer is told by tiles of 4 x 2 pixels: boxes are off by 11.5 levels, by 55 in the order of whole drops.
    let row = measured("in one another", [96, 64], "vertical_fov = 14.0", &drops, None);
    for (model, row) in &row.models {
        assert!(row.figures.boxes < 20.0, "{model}: {:?}", row.figures);
    }
}

/// One by its picture, one by rays that fly evenly, one by rays that find what it covers.
#[test]
fn drops_that_come_out_of_a_wall_fade_in() {
    let drops: Vec<_> = [(-16.0, 2.0, 0.2), (0.0, 5.0, 2.0), (16.0, 5.0, 20.0)]
        .map(|(across, radius, nearer)| {
            let of_drop = drop_at(across, -4.0, radius);
            format!("{of_drop}\nvelocity = [0.3, -1.4, {nearer}]")
        })
        .into();
    // FLIP is 0.09 to 0.11, of a drop that is cut at one moment's depth 0.18 to 0.19.
    let camera = "vertical_fov = 10.0\nshutter = 1.0";
    let row = measured("out of a wall", [64, 64], camera, &drops, Some(49.7));
    for (model, row) in &row.models {
        assert!(row.figures.flip < 0.15, "{model}: {:?}", row.figures);
    }
}

/// Seen level and from above: few drops are drawn by rays from the first pixel on.
#[test]
fn flattened_drops_of_some_pixels_have_their_rings() {
    let drops: Vec<_> = [(-40.0, 1.5), (-26.0, 2.5), (-8.0, 4.0), (14.0, 7.0), (42.0, 11.5)]
        .map(|(across, radius)| format!("{}\naxis_ratio = 0.7", drop_at(across, 0.0, radius)))
        .into();
    let level = "vertical_fov = 10.0";
    let above = "vertical_fov = 10.0\nposition = [0.0, 40.0, -20.0]\ntarget = [0.0, 0.0, -50.0]";
    for (name, camera) in [("flattened, level", level), ("flattened, from above", above)] {
        let row = assert_within(name, [128, 64], camera, &drops, None);
        // 0.7; 2.7 and 3.0 if what they cover of a pixel is a ramp across the rim.
        assert!(row.models["exact"].figures.dots < 1.6, "{:?}", row.models["exact"].figures);
    }
}
