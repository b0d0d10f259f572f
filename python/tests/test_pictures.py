"""What pictures, videos, devices and benchmarks give."""

from __future__ import annotations

import io

import numpy as np
import pytest

import raindrops


def test_a_video_is_one_rain_in_time(image):
    rain = raindrops.Rain(rate=25, shutter=1 / 60)
    frames = list(rain.video([image] * 3, fps=24, seed=3, start=5.0))
    for number, frame in enumerate(frames):
        np.testing.assert_array_equal(frame.image, rain.over(image, seed=3, time=5 + number / 24).image)
    assert (frames[0].image != frames[1].image).any()
    with pytest.raises(ValueError, match="none for frame 1"):
        list(rain.video([image] * 2, depth=[np.ones((40, 64), np.float32)]))


def test_time_goes_on_for_a_running_pane(image):
    def glass(age: float, time: float) -> np.ndarray:
        pane = {"distance": 0.3, "rate": 100.0, "velocity": [0.0, 0.0, -9.0], "simulation": "running", "age": age}
        return raindrops.Rain(scene={"pane": pane}).over(image[:8, :8], time=time).layers["pane.A"]

    np.testing.assert_array_equal(glass(2.0, 3.0), glass(5.0, 0.0))
    assert (glass(2.0, 3.0) != glass(2.0, 0.0)).any()


def test_a_films_camera_is_moved_and_takes_the_angle(image):
    def seen(position: float, angle: float, **values) -> np.ndarray:
        at = {"position": [position, 0.0, 0.0], "target": [position, 0.0, -1.0]}
        keys = [{"at": seconds, "vertical_fov": angle, **at} for seconds in (0.0, 1.0)]
        drop = {"center": [0.0, 0.0, -4.0], "radius": 0.5}
        rain = raindrops.Rain(scene={"drop": [drop], "film": {"camera": keys}}, fov=values.pop("of_all", None))
        return rain.over(image, environment=image[:32], **values).image

    wanted = seen(0.25, 50.0)
    np.testing.assert_array_equal(seen(0.0, 90.0, moved=(0.25, 0, 0), fov=50), wanted)
    np.testing.assert_array_equal(seen(0.25, 90.0, of_all=50), wanted)
    for other in [seen(0.0, 50.0), seen(0.25, 90.0)]:
        assert (other != wanted).any()


def test_both_eyes_see_the_same_drops(image):
    rain = raindrops.Rain(rate=100, near=0.3)
    eyes = [rain.over(image, seed=1, moved=(x, 0, 0)).layers for x in (-0.03, 0.03)]
    left, right = ({number: z for number, z in zip(eye["id"].flat, eye["Z"].flat) if number} for eye in eyes)
    both = left.keys() & right.keys()
    # Drops keep number and depth; only where they are in the picture differs.
    assert len(both) > len(left) / 2
    assert all(left[number] == pytest.approx(right[number], rel=1e-3) for number in both)
    assert (eyes[0]["id"] != eyes[1]["id"]).any()


def test_layers_over_the_image_are_the_picture(image):
    plate = (image / np.float32(255)).astype(np.float32)
    out = raindrops.Rain(rate=50).over(plate)
    layers = out.layers
    assert set(layers) == {"R", "G", "B", "A", "Z", "motion.X", "motion.Y", "count", "id"}
    light = np.stack([layers[name] for name in "RGB"], axis=2).astype(np.float32)
    over = light + (1 - layers["A"].astype(np.float32))[..., None] * plate
    np.testing.assert_allclose(over, out.image, rtol=4e-3, atol=1e-3)
    assert out.motion.shape == (40, 64, 2) and out.motion.dtype == np.float16
    assert layers["id"].dtype == np.uint64


def test_notebooks_show_pictures(image):
    for shown in [
        raindrops.Rain(rate=25).over(image),
        raindrops.render(rate=25, preset="fast", size=(16, 12)),
        raindrops.compare(image, image[::-1]),
        raindrops.reference({"image": {"width": 8, "height": 8}, "rain": {"count": 10}}, samples=1),
    ]:
        png = shown._repr_png_()
        assert png.startswith(b"\x89PNG")
        image_module = pytest.importorskip("PIL.Image")
        read = np.asarray(image_module.open(io.BytesIO(png)))
        assert read.dtype == np.uint8
        if isinstance(shown, raindrops.Picture) and shown.image.dtype == np.uint8:
            np.testing.assert_array_equal(read, shown.image)


def test_devices_and_bench():
    devices = raindrops.devices()
    assert devices and {"name", "driver", "type", "missing"} <= devices[0].keys()
    rows = raindrops.bench(drops=[1000, 2000], preset=["paper", "fast"], size=(32, 32), seconds=0, min_frames=1)
    assert [(row["drops"], row["preset"]) for row in rows[::2]] == [
        (count, preset) for count in (1000, 2000) for preset in ("paper", "fast")
    ]
    assert all(row["median_ms"] > 0 and row["width"] == 32 for row in rows)


def test_defaults_of_the_schema_are_kept():
    # `fast` is the default of Rain alone: what a scene says stays.
    image = np.random.default_rng(1).integers(0, 255, (32, 32, 3), np.uint8)
    exact = raindrops.Rain(rate=100, scene={"model": {"preset": "exact"}}).over(image).image
    np.testing.assert_array_equal(exact, raindrops.Rain(rate=100, preset="exact").over(image).image)
    assert (raindrops.Rain(rate=100, preset="exact").over(image).linear != raindrops.Rain(rate=100).over(image).linear).any()
