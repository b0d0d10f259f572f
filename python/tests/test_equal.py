"""Arrays equal what the command writes, byte for byte. Files are read by OpenEXR's own binding."""

from __future__ import annotations

import numpy as np
import OpenEXR
import pytest

import raindrops

RAIN = {
    "seed": 3,
    "image": {"width": 64, "height": 40},
    "camera": {"vertical_fov": 50.0, "near": 0.3},
    "rain": {"rate": 50.0, "wind": [2.0, 0.0, 0.0]},
    "model": {"preset": "fast"},
}
SETTINGS = [
    "seed=3",
    "image.width=64",
    "image.height=40",
    "camera.vertical_fov=50",
    "camera.near=0.3",
    "rain.rate=50",
    "rain.wind=2,0,0",
    "model.preset=fast",
]
SET = [word for key in SETTINGS for word in ("--set", key)]


def channels(path) -> dict[str, np.ndarray]:
    with OpenEXR.File(str(path), separate_channels=True) as file:
        return {name: channel.pixels for name, channel in file.channels().items()}


def rgb(path) -> np.ndarray:
    every = channels(path)
    return np.stack([every[name] for name in "RGB"], axis=2)


def write(path, **planes: np.ndarray) -> None:
    header = {"compression": OpenEXR.ZIP_COMPRESSION, "type": OpenEXR.scanlineimage}
    with OpenEXR.File(header, {name: np.ascontiguousarray(plane) for name, plane in planes.items()}) as file:
        file.write(str(path))


@pytest.mark.parametrize("shutter", [0.0, 1 / 60])
def test_render(command, tmp_path, shutter):
    command("render", *SET, "--set", f"camera.shutter={shutter!r}", "-o", "rain.exr")
    drawn = raindrops.render(RAIN, shutter=shutter)
    assert drawn.image.dtype == np.float32
    assert np.ptp(drawn.image) > 0
    np.testing.assert_array_equal(drawn.image, rgb(tmp_path / "rain.exr"))
    # The control: another seed is another picture.
    assert (raindrops.render(RAIN, shutter=shutter, seed=4).image != drawn.image).any()


def test_a_text_and_a_file_are_the_same_scene(tmp_path):
    text = "seed = 3\n[image]\nwidth = 64\nheight = 40\n[camera]\nvertical_fov = 50.0\nnear = 0.3\n"
    text += "[rain]\nrate = 50.0\nwind = [2.0, 0.0, 0.0]\n[model]\npreset = 'fast'\n"
    path = tmp_path / "scene.toml"
    path.write_text(text)
    as_dict = raindrops.render(RAIN, time=2.0).image
    np.testing.assert_array_equal(raindrops.render(text, time=2.0).image, as_dict)
    np.testing.assert_array_equal(raindrops.render(path, time=2.0).image, as_dict)


def test_display(command, tmp_path):
    pytest.importorskip("PIL")
    from PIL import Image

    command("render", *SET, "-o", "rain.png")
    shown = np.asarray(Image.open(tmp_path / "rain.png"))
    np.testing.assert_array_equal(raindrops.render(RAIN).display, shown)


def test_layers(command, tmp_path):
    command("render", *SET, "--layers", "-o", "rain.exr")
    written = channels(tmp_path / "rain.exr")
    layers = raindrops.render(RAIN).layers
    for name in ["R", "G", "B", "A", "Z", "motion.X", "motion.Y", "count"]:
        np.testing.assert_array_equal(layers[name], written[name], err_msg=name)
    number = written["id"].astype(np.uint64) | written["id_high"].astype(np.uint64) << np.uint64(32)
    np.testing.assert_array_equal(layers["id"], number)
    assert (number > 0).any() and np.isfinite(layers["Z"]).any()


#: A drop that falls through the middle of the picture in a third of a second.
FALLING = """
[image]
width = 32
height = 24
[[drop]]
center = [0.0, 1.5, -6.0]
radius = 1.0
velocity = [0.0, -9.0, 0.0]
[model]
preset = "fast"
"""


def motion(path) -> np.ndarray:
    every = channels(path)
    return np.stack([every["motion.X"], every["motion.Y"]], axis=2)


@pytest.mark.parametrize("number", [0, 5])
def test_motion_of_a_films_frame(command, tmp_path, number):
    path = tmp_path / "falling.toml"
    path.write_text(FALLING)
    command("render", path, "--frame", number, "--layers", "-o", "frame.exr")
    drawn = raindrops.render(path, frame=number).motion
    np.testing.assert_array_equal(drawn, motion(tmp_path / "frame.exr"))
    assert drawn[..., 1].max() > 0.5, "it falls by 0.3 m, which is half a pixel and more"


def test_motion_and_shutter_of_a_video_are_of_its_frames(command, tmp_path):
    path = tmp_path / "falling.toml"
    path.write_text(FALLING)
    plate = np.random.default_rng(1).random((24, 32, 3), np.float32)
    write(tmp_path / "photo.exr", R=plate[..., 0], G=plate[..., 1], B=plate[..., 2])
    words = ["--fps", 12, "--frame", 1, "--layers", "--background", "photo.exr"]
    command("render", path, *words, "-o", "frame.exr")
    for falling in [path, FALLING + "[film]\nfps = -60.0\npace = [{ at = 0.0, rate = 1.0 }]\n"]:
        _, second = raindrops.Rain(scene=falling).video([plate] * 2, fps=12)
        np.testing.assert_array_equal(second.motion, motion(tmp_path / "frame.exr"))
    # Half of a turn is half of a frame.
    angle = raindrops.Rain(scene=FALLING + "[camera]\nshutter_angle = 180.0\n")
    shutter = raindrops.Rain(scene=FALLING, shutter=0.5 / 12)
    _, second = angle.video([plate] * 2, fps=12)
    np.testing.assert_array_equal(second.image, shutter.over(plate, time=1 / 12).image)
    assert (second.image != angle.over(plate, time=1 / 12).image).any()


PANE = """
seed = 3
[image]
width = 32
height = 24
[rain]
rate = 50.0
[pane]
distance = 0.3
[[pane.drop]]
at = [0.05, 0.02]
radius = 0.08
[model]
preset = "fast"
"""


def test_layers_and_masks_of_a_pane(command, tmp_path):
    path = tmp_path / "pane.toml"
    path.write_text(PANE)
    command("render", path, "--layers", "-o", "pane.exr")
    picture, written = raindrops.render(path), channels(tmp_path / "pane.exr")
    np.testing.assert_array_equal(picture.layers["pane.A"], written["pane.A"])
    assert picture.layers["pane.A"].dtype == np.float16 and 0 < picture.layers["pane.A"].mean() < 1
    command("dataset", path, "--masks", "--views", 1, "-o", "set")
    written = channels(tmp_path / "set/00000/mask.exr")
    picture = raindrops.render(tmp_path / "set/00000/scene.toml")
    for name, mask in [("opacity", picture.opacity), ("contrast", picture.contrast)]:
        np.testing.assert_array_equal(mask.astype(np.float16), written[name], err_msg=name)


@pytest.mark.parametrize("kind", ["planar", "radial"])
def test_over(command, tmp_path, image, depth, kind):
    plate = (image / np.float32(255)).astype(np.float32)
    write(tmp_path / "photo.exr", R=plate[..., 0], G=plate[..., 1], B=plate[..., 2])
    write(tmp_path / "depth.exr", Z=depth)
    behind = ["--background", "photo.exr", "--depth", "depth.exr", "--depth-kind", kind]
    command("render", *SET, *behind, "-o", "rainy.exr")
    rain = raindrops.Rain(scene=RAIN)
    out = rain.over(plate, depth=depth, depth_kind=kind)
    np.testing.assert_array_equal(out.image, rgb(tmp_path / "rainy.exr"))
    # The control: without the wall there are more drops.
    assert (rain.over(plate).image != out.image).any()


def test_over_bytes(command, tmp_path, image):
    pytest.importorskip("PIL")
    from PIL import Image

    Image.fromarray(image).save(tmp_path / "photo.png")
    command("render", *SET, "--background", "photo.png", "-o", "rainy.exr")
    out = raindrops.Rain(scene=RAIN).over(image)
    np.testing.assert_array_equal(out.linear, rgb(tmp_path / "rainy.exr"))
    assert out.image.dtype == np.uint8
    # Where no rain is, bytes are those of the image: here for a scene without rain.
    plain = raindrops.Rain(scene={"rain": {"count": 0}}).over(image)
    np.testing.assert_array_equal(plain.image, image)


def test_masks(command, tmp_path, image):
    plate = (image / np.float32(255)).astype(np.float32)
    write(tmp_path / "photo.exr", R=plate[..., 0], G=plate[..., 1], B=plate[..., 2])
    command("dataset", *SET, "--background", "photo.exr", "--masks", "--views", 1, "-o", "set")
    written = channels(tmp_path / "set/00000/mask.exr")
    scene = (tmp_path / "set/00000/scene.toml").read_text()
    seed = int(next(line for line in scene.splitlines() if line.startswith("seed")).split("=")[1])
    out = raindrops.Rain(scene=RAIN).over(plate, seed=seed)
    for name, mask in [("opacity", out.opacity), ("contrast", out.contrast)]:
        np.testing.assert_array_equal(mask.astype(np.float16), written[name], err_msg=name)
        assert mask.max() > 0.01, name


def test_reference(command, tmp_path):
    drop = {"image": {"width": 24, "height": 16}, "drop": [{"center": [0.0, 0.0, -3.0], "radius": 1.0}]}
    path = tmp_path / "drop.toml"
    path.write_text("[image]\nwidth = 24\nheight = 16\n[[drop]]\ncenter = [0.0, 0.0, -3.0]\nradius = 1.0\n")
    command("reference", path, "--samples", 4, "-o", "truth.exr", "--coverage", "drops.exr")
    traced = raindrops.reference(drop, samples=4)
    np.testing.assert_array_equal(traced.image, rgb(tmp_path / "truth.exr"))
    np.testing.assert_array_equal(traced.coverage, rgb(tmp_path / "drops.exr")[..., 0])


def test_compare(command, tmp_path):
    import json

    a = raindrops.render(RAIN)
    b = raindrops.render(RAIN, seed=4)
    for name, picture in [("a.exr", a.image), ("b.exr", b.image)]:
        write(tmp_path / name, R=picture[..., 0], G=picture[..., 1], B=picture[..., 2])
    command("compare", "a.exr", "b.exr", "--json", "figures.json")
    figures = json.loads((tmp_path / "figures.json").read_text())
    found = raindrops.compare(a, b)
    assert found.flip == pytest.approx(figures["flip"], abs=0, rel=1e-12) and found.flip > 0
    assert found.rel_mse == pytest.approx(figures["rel_mse"], rel=1e-12)
    assert found.rmse == pytest.approx(10 ** (-figures["psnr_db"] / 20))
    assert found.flip_map.mean() == pytest.approx(found.flip, rel=1e-5)
    assert raindrops.compare(a, a).flip == 0
