//! Depth as other programs write it: where it is found among other passes, in which units, and what is unknown.

use raindrops::Result;
use raindrops::picture::depth::SKY;
use raindrops::picture::plate::Plate;
use raindrops::remark::Severity;
use raindrops::scene::background::Background;

use crate::files::Folder;
use crate::reading::{case, refusal, says};

pub fn depth(name: &str, edit: impl Fn(&mut Background)) -> Result<Plate> {
    let mut background = Background { depth: Some(case(name)), ..Background::default() };
    edit(&mut background);
    Plate::open(&background, 96, 64)
}

#[test]
fn depth_among_other_passes_is_found() {
    for name in ["z-alone", "arnold", "nuke-depth", "blender-multilayer"] {
        let plate = depth(&format!("07-depth-among-aovs/{name}.exr"), |_| ()).expect("depth");
        let values = &plate.depth().expect("depth").values;
        assert!(values.iter().all(|depth| *depth == 20.0), "{name}: {}", values[0]);
    }
    let only_normals = depth("07-depth-among-aovs/blender-normals-only.exr", |_| ());
    refusal(only_normals, "has no depth");
    let named = |background: &mut Background| background.depth_layer = Some("Depth".into());
    depth("07-depth-among-aovs/blender-multilayer.exr", named).expect("depth by its name");
    let wrong = |background: &mut Background| background.depth_layer = Some("Mist".into());
    refusal(
        depth("07-depth-among-aovs/blender-multilayer.exr", wrong),
        "has no layer 'Mist', which background.depth_layer names; it has ViewLayer.Combined.A",
    );
}

/// A wall at 20 m below the sky.
#[test]
fn depth_is_read_as_tools_write_it() {
    let right = depth("09-depth-as-tools-write-it/right.exr", |_| ()).expect("depth");
    let right = &right.depth().expect("depth").values;
    assert_eq!((right[0], right[40 * 96]), (SKY, 20.0));
    for name in ["rgb-equal.exr", "v.exr", "y.exr", "half-inf.exr"] {
        let plate = depth(&format!("09-depth-as-tools-write-it/{name}"), |_| ()).expect("depth");
        assert!(plate.depth().expect("depth").values == *right, "{name}");
    }
    // 65535, the most that a PNG can hold, is the sky.
    let metres = |background: &mut Background| background.depth_scale = Some(1.0 / 256.0);
    let plate = depth("09-depth-as-tools-write-it/opencv-3ch.png", metres).expect("depth");
    let values = &plate.depth().expect("depth").values;
    let others: Vec<usize> = (0..96 * 64).filter(|at| values[*at] != right[*at]).collect();
    assert_eq!(others, [40 * 96 + 50], "but for the one texel that nothing was measured at");
    let centimetres = |background: &mut Background| background.depth_scale = Some(0.01);
    let plate = depth("09-depth-as-tools-write-it/unreal-cm.exr", centimetres).expect("depth");
    assert!(plate.depth().expect("depth").values == *right);

    let file = "09-depth-as-tools-write-it/kitti.png";
    let unmeasured = depth(file, metres).expect_err("0 is no depth").to_string();
    assert!(unmeasured.contains("give background.depth_invalid = 0"), "{unmeasured}");
    assert!(!unmeasured.contains("65535"), "a wall in the sky: {unmeasured}");
    let measured = |background: &mut Background| {
        metres(background);
        background.depth_invalid = Some(0.0);
    };
    let plate = depth(file, measured).expect("depth");
    assert!(plate.depth().expect("depth").values.iter().all(|depth| *depth == 20.0));
    let said = plate.remarks().iter().map(|(_, remark)| remark.clone());
    assert!(says(
        said,
        Severity::Note,
        "2305 texels of unknown depth (0) have the nearest known one"
    ));

    refusal(depth("09-depth-as-tools-write-it/middlebury.pfm", |_| ()), "is no depth");
    refusal(depth("14-png-kinds/gray8.png", metres), "depth in a PNG has 16 bits");
    refusal(depth("06-exr-windows/plate.exr", |_| ()), "holds colours and no depth");
    refusal(depth("09-depth-as-tools-write-it/kitti.png", |_| ()), "needs a scale");
}

/// Depth in memory, as a 16-bit PNG.
fn depth_png(width: u32, values: &[u16], invalid: Option<f64>) -> Result<Vec<f64>> {
    let folder = Folder::new();
    let (path, height) = (folder.path("depth.png"), values.len() as u32 / width);
    let image = image::ImageBuffer::<image::Luma<u16>, _>::from_raw(width, height, values.to_vec());
    image.expect("pixels").save(&path).expect("a file");
    let background = Background {
        depth: Some(path),
        depth_scale: Some(0.5),
        depth_invalid: invalid,
        ..Background::default()
    };
    let plate = Plate::open(&background, width, height)?;
    Ok(plate.depth().expect("depth").values.clone())
}

#[test]
fn unknown_depth_is_the_nearest_that_is_known() {
    // The hole in the middle is nearer to 8 than to 4; its own row and column decide nothing.
    let stored = [4, 9, 9, 9, 9, 9, 9, 9, 8];
    let found = depth_png(3, &stored, Some(9.0)).expect("depth");
    assert_eq!([found[1], found[3], found[5], found[7]], [2.0, 2.0, 4.0, 4.0]);
    assert_eq!(depth_png(3, &stored, None).expect("depth")[4], 4.5);
    refusal(depth_png(2, &[7; 4], Some(7.0)), "has no known depth: every texel is 7");
    // Unknown goes before the sky.
    let found = depth_png(2, &[65_535, 6, 6, 6], Some(65_535.0)).expect("depth");
    assert_eq!(found, [3.0; 4]);
    assert_eq!(depth_png(2, &[65_535, 6, 6, 6], None).expect("depth")[0], SKY);
}

#[test]
fn depth_of_another_size_says_what_helps() {
    let mut background = Background {
        depth: Some(case("06-exr-windows/depth.exr")),
        color: Some(case("04-colour-profile/srgb.png")),
        ..Background::default()
    };
    let said = Plate::open(&background, 64, 64).expect_err("sizes differ").to_string();
    assert!(said.contains("resample it to 64 x 64") && !said.contains("--size"), "{said}");
    background.color = None;
    let said = Plate::open(&background, 64, 64).expect_err("sizes differ").to_string();
    assert!(said.contains("resample it to 64 x 64, or --size 96x64"), "{said}");
}
