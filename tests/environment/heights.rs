//! Height maps of shelters, as OpenEXR and PNG have them; what holds none is refused in a line that says why.

use std::path::{Path, PathBuf};

use exr::prelude::{AnyChannel, AnyChannels, FlatSamples, Image, WritableImage as _};
use raindrops::Result;
use raindrops::picture::heights::{HeightMap, NOTHING};
use raindrops::scene::Scene;

use crate::files::Folder;

/// Three columns of two rows, in channels of these names.
fn exr(path: &Path, channels: &[(&str, [f32; 6])]) {
    let channel = |(name, values): &(&str, [f32; 6])| {
        AnyChannel::new(*name, FlatSamples::F32(values.to_vec()))
    };
    let channels = AnyChannels::sort(channels.iter().map(channel).collect());
    Image::from_channels((3, 2), channels).write().to_file(path).expect("a file");
}

fn read(path: &Path) -> Result<HeightMap> {
    HeightMap::read(path, 0.5)
}

const VALUES: [f32; 6] = [1.0, 2.0, f32::NEG_INFINITY, -3.0, -2e9, 0.0];

#[test]
fn heights_are_those_of_the_file_times_the_scale() {
    let folder = Folder::new();
    let path: PathBuf = folder.path("heights.exr");
    let expected =
        HeightMap { columns: 3, rows: 2, heights: vec![0.5, 1.0, NOTHING, -1.5, NOTHING, 0.0] };
    for name in ["Y", "Z", "depth.Z"] {
        exr(&path, &[(name, VALUES)]);
        assert_eq!(read(&path).expect(name), expected, "{name}");
    }
    exr(&path, &[("R", VALUES), ("G", VALUES), ("B", VALUES)]);
    assert_eq!(read(&path).expect("equal channels"), expected);
    let path = folder.path("heights.png");
    let texels = vec![0_u16, 1, 2, 65_535, 4, 5];
    let image = image::ImageBuffer::<image::Luma<u16>, _>::from_raw(3, 2, texels).expect("texels");
    image.save(&path).expect("a file");
    assert_eq!(read(&path).expect("a PNG").heights, [0.0, 0.5, 1.0, 32_767.5, 2.0, 2.5]);
}

#[test]
fn what_is_no_height_map_is_refused() {
    let folder = Folder::new();
    let path = folder.path("heights.exr");
    let with = |index: usize, value: f32| {
        let mut values = VALUES;
        values[index] = value;
        values
    };
    let refused = |told: &str| {
        let problem = read(&path).expect_err(told).to_string();
        assert!(problem.contains(told) && problem.contains("heights.exr"), "{problem}");
        assert_eq!(problem.lines().count(), 1, "{problem}");
    };
    exr(&path, &[("Y", with(4, f32::NAN))]);
    refused("column 1, row 1 is NaN; store -inf where nothing is");
    exr(&path, &[("Y", with(2, f32::INFINITY))]);
    refused("column 2, row 0 is inf; store -inf where nothing is");
    exr(&path, &[("R", VALUES), ("G", with(3, 8.0)), ("B", VALUES)]);
    refused("holds colours and no heights: its channels differ at column 0, row 1");
    exr(&path, &[("A", VALUES)]);
    refused("has no");
    std::fs::write(&path, b"no picture").expect("a file");
    refused("is no height map: an OpenEXR with a channel Y, or a PNG of 16 bits");
    std::fs::remove_file(&path).expect("a file");
    refused("cannot read");
}

/// A scene file's map is read with it, from its folder.
#[test]
fn a_scene_has_its_map() {
    let folder = Folder::new();
    exr(&folder.path("roofs.exr"), &[("Y", VALUES)]);
    let path = folder.path("scene.toml");
    std::fs::write(&path, "[shelter]\nheight = \"roofs.exr\"\n").expect("a file");
    let scene = Scene::load(&path).expect("a scene");
    let shelter = scene.shelter.as_ref().expect("a shelter");
    assert_eq!(shelter.map().expect("a map").heights[1], 2.0);
    assert_eq!(shelter.height, folder.path("roofs.exr"));
    // It is saved with the way to its map.
    let elsewhere = Folder::new();
    let copy = elsewhere.path("copy.toml");
    scene.save(&copy).expect("a file");
    assert_eq!(Scene::load(&copy).expect("a scene"), scene);
    std::fs::write(&path, "[shelter]\nheight = \"walls.exr\"\n").expect("a file");
    let problem = Scene::load(&path).expect_err("no map").to_string();
    assert!(problem.contains("walls.exr") && problem.contains("cannot read"), "{problem}");
}
