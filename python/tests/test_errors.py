"""What is wrong is said in one line, before anything is drawn."""

from __future__ import annotations

import re
import warnings

import numpy as np
import pytest

import raindrops


@pytest.fixture
def rain():
    return raindrops.Rain(rate=25)


@pytest.mark.parametrize(
    ("made", "said"),
    [
        (np.zeros((4, 5), np.uint8), r"image: its shape is \(4, 5\), not \(height, width, 3\)"),
        (np.zeros((3, 4, 5), np.uint8), "channels come last"),
        (np.zeros((4, 5, 4), np.uint8), "leave out the alpha"),
        (np.zeros((0, 5, 3), np.uint8), "it has no pixels"),
        (np.zeros((4, 5, 3), np.float64), r"its type is float64; give uint8"),
        (np.zeros((4, 5, 3), np.int64), "its type is int64"),
        ([[1, 2, 3]], "a list is no array"),
        (None, "a NoneType is no array"),
    ],
)
def test_images(rain, made, said):
    with pytest.raises(raindrops.ArrayError, match=said):
        rain.over(made)


def test_depths(rain, image, depth):
    holes = depth.copy()
    holes[3, 7] = np.nan
    for made, error, said in [
        (depth[1:], raindrops.ArrayError, r"its shape is \(39, 64\), the image's is \(40, 64, 3\)"),
        (np.ones((40, 64), np.uint16), raindrops.ArrayError, "its type is uint16; give floats"),
        (holes, raindrops.SceneError, r"not over 0: column 7, row 3 is NaN.*depth_invalid = nan"),
        (-depth, raindrops.SceneError, "not over 0"),
    ]:
        with pytest.raises(error, match=said):
            rain.over(image, depth=made)
    # Unknown ones take the nearest known, which is said.
    with pytest.warns(raindrops.RaindropsNote, match="1 texels of unknown depth"):
        rain.over(image, depth=holes, depth_invalid=np.nan)
    with pytest.raises(raindrops.SceneError, match="depth_kind is 'along'"):
        rain.over(image, depth=depth, depth_kind="along")


@pytest.mark.parametrize("kind", ["float16", "float32", "float64", ">f4"])
def test_an_unknown_depth_is_a_number_of_the_depths_own_type(rain, image, depth, kind):
    holes = depth.astype(kind)
    holes[30, 7] = 0.1
    with pytest.warns(raindrops.RaindropsNote, match="1 texels of unknown depth"):
        rain.over(image, depth=holes, depth_invalid=0.1)


def test_the_sky_is_no_unknown_depth(rain, image, depth):
    with pytest.warns(raindrops.RaindropsNote, match="0 texels of unknown depth"):
        rain.over(image, depth=depth.astype(np.float16), depth_invalid=65535)


def test_environments(rain, image):
    wanted = re.escape("environment: its shape is (40, 64, 3); a latitude-longitude panorama of this height is (40, 80, 3)")
    with pytest.raises(raindrops.ArrayError, match=wanted):
        rain.over(image, environment=image)
    with pytest.raises(raindrops.ArrayError, match=wanted):
        raindrops.render({}, environment=image)
    panorama = np.ones((8, 16, 3), np.float32)
    panorama[2, 3] = np.nan
    with pytest.warns(raindrops.RaindropsWarning, match="1 NaN"):
        rain.over(image, environment=panorama)


@pytest.mark.parametrize("content", [None, b"no picture"])
def test_an_environment_that_is_no_file_or_no_picture(tmp_path, content):
    path = tmp_path / "sky.exr"
    if content is not None:
        path.write_bytes(content)
    scene = {"environment": {"file": path}, "image": {"width": 8, "height": 8}}
    for call in [raindrops.render, raindrops.reference, raindrops.bench]:
        with pytest.raises(raindrops.FileError, match="sky.exr"):
            call(scene)


def test_pixels_that_are_no_number_are_mended_with_a_warning(rain, image):
    plate = (image / np.float32(255)).astype(np.float32)
    plate[1, 1] = np.nan
    with pytest.warns(raindrops.RaindropsWarning, match="1 NaN"):
        out = rain.over(plate)
    assert np.isfinite(out.image).all()


def test_strides_types_and_read_only_arrays_make_no_difference(rain, image):
    plain = rain.over(image).image
    fixed = image.copy()
    fixed.setflags(write=False)
    turned = image[::-1].copy()[::-1]
    apart = np.repeat(image, 2, axis=1)[:, ::2]

    class Wrapped:
        def __array__(self, dtype=None, copy=None):
            return image

    class Tensor:
        def __dlpack__(self, **keywords):
            return image.__dlpack__(**keywords)

        def __dlpack_device__(self):
            return image.__dlpack_device__()

    for other in [fixed, turned, apart, Wrapped(), Tensor()]:
        np.testing.assert_array_equal(rain.over(other).image, plain)
    half = (image / np.float32(255)).astype(np.float16)
    assert rain.over(half).image.dtype == np.float16
    swapped = half.astype(np.float32).astype(">f4")
    np.testing.assert_array_equal(rain.over(swapped).image, rain.over(half).linear)

    class Half:
        dtype = "torch.float16"

        def __array__(self, dtype=None, copy=None):
            return half

    for other in [half.astype(">f2"), Half()]:
        drawn = rain.over(other).image
        assert drawn.dtype == np.float16
        np.testing.assert_array_equal(drawn, rain.over(half).image)


@pytest.mark.parametrize("kind", ["float16", "float32", "float64"])
def test_arrays_may_begin_anywhere(rain, image, depth, kind):
    def apart(made: np.ndarray) -> np.ndarray:
        there = np.frombuffer(b"-" + made.tobytes(), made.dtype, offset=1).reshape(made.shape)
        assert not there.flags.aligned
        return there

    plate = (image / np.float32(255)).astype(np.float16 if kind == "float16" else np.float32)
    depth = depth.astype(kind)
    drawn = rain.over(apart(plate), depth=apart(depth)).image
    np.testing.assert_array_equal(drawn, rain.over(plate, depth=depth).image)
    assert raindrops.compare(apart(plate), plate).flip == 0


@pytest.mark.parametrize(
    ("scene", "said"),
    [
        ({"rain": {"rat": 5}}, r"scene, \[rain\] rat = 5: unknown field `rat`.*did you mean `rate`"),
        ({"rain": {"rate": -1.0}}, r"scene, \[rain\] rate = -1.0: .*not within"),
        ({"rain": {"rate": "much"}}, "rate: invalid type"),
        ({"seed": {"more": 1}}, "seed"),
        ("seed = 1\nrate = 5\n", "scene:2: unknown field `rate`"),
    ],
)
def test_scenes(scene, said):
    with pytest.raises(raindrops.SceneError, match=said):
        raindrops.render(scene)


def test_the_line_is_the_commands(command, tmp_path):
    path = tmp_path / "wrong.toml"
    path.write_text("seed = 1\n[rain]\nrate = 3000.0\n")
    with pytest.raises(raindrops.SceneError) as raised:
        raindrops.render(path)
    said = command("render", path, "-o", "out.png", status=2)
    assert said.strip().endswith(str(raised.value)) and "wrong.toml:3" in said


def test_a_rain_without_rain(tmp_path):
    path = tmp_path / "scene.toml"
    path.write_text("seed = 1\n")
    for scene in [None, {}, {"camera": {"near": 0.3}}, "seed = 1\n", path]:
        with pytest.raises(TypeError, match="rate: give millimetres an hour, or a scene with rain"):
            raindrops.Rain(scene=scene)
        raindrops.Rain(rate=25, scene=scene)
    # The default's own drops may be asked for.
    path.write_text("[rain]\ncount = 1_000_000\n")
    drop = {"center": [0.0, 0.0, -3.0], "radius": 1.0}
    for scene in [path, path.read_text(), {"rain": {}}, {"rain": {"count": 0}}, {"drop": [drop]}, {"pane": {"distance": 0.3}}]:
        raindrops.Rain(scene=scene)


def test_values(image):
    for call, error, said in [
        (lambda: raindrops.Rain(rate=0), raindrops.SceneError, "rate"),
        (lambda: raindrops.Rain(rate=25, wind=[1, 2]), raindrops.SceneError, "wind"),
        (lambda: raindrops.Rain(rate=25, scene={"rain": None}), TypeError, "rain is None"),
        (lambda: raindrops.Rain(rate=25, scene=7), TypeError, "a int is none"),
        (lambda: raindrops.Rain(rate=25).over(image, fov=180), raindrops.SceneError, "vertical_fov"),
        (lambda: raindrops.Rain(rate=25).over(image, moved=[1, 2]), ValueError, "give three"),
        (lambda: raindrops.render("missing.toml"), raindrops.FileError, "cannot read missing.toml"),
        (lambda: raindrops.render(rate=25, device="nothing"), raindrops.DeviceError, "no Vulkan device matches 'nothing'"),
        (lambda: raindrops.reference(samples=0), ValueError, "samples = 0"),
        (lambda: raindrops.compare(image, image[1:]), raindrops.ArrayError, "sizes must agree"),
        (lambda: raindrops.compare(image, image.astype(np.float32)), raindrops.ArrayError, "compare uint8 with uint8"),
        (lambda: raindrops.bench(preset="faster"), raindrops.SceneError, "faster"),
        (lambda: raindrops.Rain(rate=25, seed=-1), raindrops.SceneError, r"seed = -1 is not within 0 to 2\*\*64 - 1"),
        (lambda: raindrops.Rain(rate=25).over(image, seed=1 << 64), raindrops.SceneError, "seed = 18446744073709551616 is not"),
        (lambda: raindrops.render(seed=0.5), TypeError, "seed: a float is no whole number"),
        (lambda: raindrops.render(size=(-1, 8)), raindrops.SceneError, "width = -1 is not within 1 to 32768"),
        (lambda: raindrops.bench(size=(8, 1 << 40)), raindrops.SceneError, "height = 1099511627776 is not within"),
        (lambda: raindrops.render(frame=-1), raindrops.SceneError, "frame = -1 is not within"),
        (lambda: raindrops.reference(sample_seed=-1), raindrops.SceneError, "sample_seed = -1"),
        (lambda: raindrops.bench(drops=[8, -1]), raindrops.SceneError, "drops = -1"),
        (lambda: raindrops.bench(min_frames=-1), raindrops.SceneError, "min_frames = -1"),
        (lambda: raindrops.Rain(rate=25).over(image, fps=0), ValueError, "fps = 0 is not finite and over 0"),
        (lambda: next(raindrops.Rain(rate=25).video([image], fps=float("inf"))), ValueError, "fps = inf"),
        (lambda: raindrops.Rain(rate=25).over(image, moved=0.1), ValueError, "moved: 1 numbers; give three"),
        (
            lambda: next(raindrops.Rain(rate=25).video([image], depth=np.ones((40, 64)))),
            raindrops.ArrayError,
            "depth: one for all frames; give one a frame",
        ),
    ]:
        with pytest.raises(error, match=said):
            call()


def test_warnings_name_the_callers_line_and_may_be_errors(rain, image):
    with pytest.warns(raindrops.RaindropsNote, match="guessed from the picture") as caught:
        rain.over(image)
    assert {str(one.filename) for one in caught} == {__file__}
    with warnings.catch_warnings():
        warnings.simplefilter("error", raindrops.RaindropsNote)
        with pytest.raises(raindrops.RaindropsNote):
            rain.over(image)


def test_without_a_driver(python):
    status, said = python(
        """
        import raindrops
        try:
            raindrops.render(rate=25, size=(8, 8))
        except raindrops.NoDeviceError as error:
            print(error)
        """,
        VK_DRIVER_FILES="/nowhere.json",
        VK_ICD_FILENAMES="/nowhere.json",
    )
    assert status == 0 and len(said.splitlines()) == 1, said
    assert "apt install libvulkan1 mesa-vulkan-drivers" in said
