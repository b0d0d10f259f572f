"""Rain: read once, drawn over any number of pictures."""

from __future__ import annotations

import copy
import os
from collections.abc import Iterable, Iterator, Mapping, Sequence
from typing import Any, Union

import numpy as np

from . import _native
from ._arrays import Image, array_of as _array_of, depth as _depth, panorama as _panorama, picture as _picture, whole as _whole
from ._errors import ArrayError
from ._results import Picture, Reference

#: A scene: a dict of the keys of a scene file, a path to one, its text (with a line end in it), or None: the default.
SceneLike = Union[Mapping[str, Any], str, "os.PathLike[str]", None]

#: Short names of keys.
_KEYS = {
    "rate": "rain.rate",
    "wind": "rain.wind",
    "extent": "rain.extent",
    "sizes": "rain.sizes",
    "shutter": "camera.shutter",
    "near": "camera.near",
    "preset": "model.preset",
    "time": "time",
}

#: The largest seed.
_MOST_SEED = 2**64 - 1


def read(scene: SceneLike, keys: Mapping[str, Any], **values: Any) -> _native.Scene:
    """A scene with short names of keys set, and values as of `changed`; those that are None stay."""
    given = {_KEYS[name]: value for name, value in keys.items() if value is not None}
    if scene is None or isinstance(scene, Mapping):
        made = _native.Scene.read(dict=dict(scene or {}), keys=given)
    elif isinstance(scene, str) and "\n" in scene:
        made = _native.Scene.read(text=scene, keys=given)
    elif isinstance(scene, (str, os.PathLike)):
        made = _native.Scene.read(path=os.fspath(scene), keys=given)
    else:
        raise TypeError(f"scene: a {type(scene).__name__} is none; give a dict, a path or the text of a scene file")
    return changed(made, **values)


def changed(scene: _native.Scene, size: Sequence[int] | None = None, seed: int | None = None, **values: Any) -> _native.Scene:
    """A scene with other values of a picture; those that are None stay."""
    edges = None
    if size is not None:
        width, height = size
        edges = _whole(width, "width", _native.MOST_EDGE, 1), _whole(height, "height", _native.MOST_EDGE, 1)
    if seed is not None:
        seed = _whole(seed, "seed", _MOST_SEED)
    return scene.with_(size=edges, seed=seed, **values)


def device_of(name: str | None) -> str | None:
    """The device that is asked for."""
    return name or os.environ.get("RAINDROPS_DEVICE") or None


class Rain:
    """The same rain for any number of pictures.

    Making it opens nothing and draws nothing: the device is opened with the first picture of the process. It may be
    pickled, and shared by threads.

    Args:
        rate: millimetres an hour, 0.001 to 2000; needed unless the scene has rain.
        shutter: seconds of exposure, which makes streaks; 0 is an instant, in which drops are points.
        wind: metres a second, x right, y up, z towards the camera.
        extent: metres from the camera to the rain's end.
        near: scene units; nearer drops are left out.
        fov: the camera's vertical field of view in degrees; 90 unless the scene says otherwise.
        preset: the models; ``fast``, ``exact``, ``auto``; ``fast`` unless the dict says otherwise, or the file's.
        seed: chooses the drops' places.
        scene: a dict of the keys of a scene file, or a path to one, for all other keys.
        device: a part of a Vulkan device's name or driver, or its index in ``devices()``; else that of the environment
            variable RAINDROPS_DEVICE, else the fittest.

    Raises:
        TypeError: there is no rate, and the scene names no rain and no drops.
        SceneError: a key or a value is wrong.
        FileError: the scene file cannot be read.
    """

    def __init__(
        self,
        rate: float | None = None,
        *,
        shutter: float | None = None,
        wind: Sequence[float] | None = None,
        extent: float | None = None,
        near: float | None = None,
        fov: float | None = None,
        preset: str | None = None,
        seed: int | None = None,
        scene: SceneLike = None,
        device: str | None = None,
    ) -> None:
        if preset is None and (scene is None or isinstance(scene, Mapping)):
            model = (scene or {}).get("model", {})
            preset = None if isinstance(model, Mapping) and "preset" in model else "fast"
        keys = {
            "rate": rate,
            "shutter": shutter,
            "wind": wind,
            "extent": extent,
            "near": near,
            "preset": preset,
        }
        values = {"seed": seed, "fov": fov}
        # What is pickled later is of the same rain, whatever becomes of the caller's dict and arrays.
        self._made = copy.deepcopy((dict(scene) if isinstance(scene, Mapping) else scene, keys, values, device))
        self._open()

    def _open(self) -> None:
        scene, keys, values, device = self._made
        self._scene = read(scene, keys, **values)
        if not self._scene.names_rain:
            raise TypeError("rate: give millimetres an hour, or a scene with rain")
        self._session = _native.Session(device_of(device))

    def __getstate__(self) -> Any:
        return self._made

    def __setstate__(self, made: Any) -> None:
        self._made = made
        self._open()

    def over(
        self,
        image: Image,
        *,
        depth: Any = None,
        depth_kind: str = "planar",
        depth_invalid: float | None = None,
        environment: Image = None,
        fov: float | None = None,
        seed: int | None = None,
        time: float | None = None,
        moved: Sequence[float] | None = None,
        fps: float | None = None,
    ) -> Picture:
        """Draws the rain over a picture.

        Args:
            image: H x W x 3, row 0 at the top; uint8 sRGB, or float16 or float32 linear. A NumPy array, or what has
                ``__array__`` or, on the CPU, ``__dlpack__``. It is read, never written.
            depth: H x W floats over 0, in scene units (metres); drops that are farther are hidden. Infinity is the sky.
            depth_kind: ``planar``, along the view axis, or ``radial``, along the ray.
            depth_invalid: the number that stands for an unknown depth (may be NaN); such pixels take the nearest known one.
            environment: H x 2H x 3, a latitude-longitude panorama of what the drops show; guessed from the picture if None,
                with a `RaindropsNote`.
            fov: vertical field of view in degrees.
            seed: chooses the drops' places, but of rain with a seed of its own.
            time: seconds; the same seed at another time is the same rain later.
            moved: x, y, z: the camera by so much, scene units, looking the same way; the other eye of a stereo pair.
            fps: frames a second, of a picture of a video: of motion without a shutter, and of ``camera.shutter_angle``; those
                of the scene's film if None.

        Raises:
            ArrayError: a shape, a type or a place of an array is wrong.
            SceneError: a value is out of its range; a depth is NaN or not over 0.
            NoDeviceError, DeviceError: nothing to draw on.
            ForkError: the process was forked from one in which raindrops had computed.
        """
        if fps is not None:
            _check_fps(fps)
        given = _array_of(image, "image")
        pixels = _picture(given, "image")
        height, width, _ = pixels.shape
        way = None if moved is None else tuple(float(part) for part in np.atleast_1d(moved))
        if way is not None and len(way) != 3:
            raise ValueError(f"moved: {len(way)} numbers; give three, x, y and z")
        scene = changed(self._scene, size=(width, height), seed=seed, time=time, fov=fov, moved=way, fps=fps)
        depths = None
        if depth is not None:
            depths, depth_invalid = _depth(depth, pixels.shape, depth_invalid)
        drawing = _native.Drawing(
            self._session,
            scene,
            color=pixels,
            depth=depths,
            depth_kind=depth_kind,
            depth_invalid=depth_invalid,
            environment=_panorama(environment),
        )
        is_half = given.dtype.newbyteorder("=") == np.float16
        return Picture(drawing, np.float16 if is_half else pixels.dtype)

    def video(
        self,
        frames: Iterable[Image],
        *,
        depth: Iterable[Any] | None = None,
        fps: float = 30.0,
        start: float | None = None,
        **keywords: Any,
    ) -> Iterator[Picture]:
        """Draws one rain over the frames of a video, in turn: frame n at ``start + n / fps`` seconds.

        Args:
            frames: pictures as of `over`.
            depth: as many depths.
            fps: frames a second; also of motion and of ``camera.shutter_angle``.
            start: seconds of the first frame; the scene's time if None.
            **keywords: as of `over`.
        """
        _check_fps(fps)
        first = self._scene.time if start is None else start
        if getattr(depth, "ndim", 3) == 2:
            raise ArrayError("depth: one for all frames; give one a frame, such as itertools.repeat(depth)")
        depths = None if depth is None else iter(depth)
        for number, image in enumerate(frames):
            of_frame = None
            if depths is not None:
                of_frame = next(depths, None)
                if of_frame is None:
                    raise ValueError(f"depth: there is none for frame {number}")
            yield self.over(image, depth=of_frame, time=first + number / fps, fps=fps, **keywords)


def _check_fps(fps: float) -> None:
    if not 0 < fps < float("inf"):
        raise ValueError(f"fps = {fps} is not finite and over 0")


def render(
    scene: SceneLike = None,
    *,
    size: tuple[int, int] | None = None,
    rate: float | None = None,
    shutter: float | None = None,
    fov: float | None = None,
    preset: str | None = None,
    seed: int | None = None,
    time: float | None = None,
    environment: Image = None,
    frame: int = 0,
    device: str | None = None,
) -> Picture:
    """Draws a scene, as the command ``render`` does.

    Args:
        scene: a dict of the keys of a scene file, a path to one, or its text; None: the paper's million drops.
        size: width and height in pixels.
        rate, shutter, fov, preset, seed, time: as of `Rain`.
        environment: H x 2H x 3, a latitude-longitude panorama in place of the scene's.
        frame: number of a frame of the scene's film.
        device: as of `Rain`.

    Raises:
        As `Rain.over`.
    """
    number = _whole(frame, "frame", 2**32 - 1)
    keys = {"rate": rate, "shutter": shutter, "preset": preset, "time": time}
    made = read(scene, keys, size=size, seed=seed, fov=fov)
    around = _panorama(environment)
    session = _native.Session(device_of(device))
    return Picture(_native.Drawing(session, made, environment=around, frame=number), np.float32)


def reference(
    scene: SceneLike = None,
    *,
    samples: int = 64,
    size: tuple[int, int] | None = None,
    rate: float | None = None,
    shutter: float | None = None,
    fov: float | None = None,
    seed: int | None = None,
    time: float | None = None,
    environment: Image = None,
    sample_seed: int = 0,
    rain_to: float | None = None,
) -> Reference:
    """Traces a scene by the float64 ray tracer on the CPU; needs no device. Ctrl-C ends it.

    Args:
        scene: as of `render`.
        samples: samples a pixel, 1 to 2**20.
        sample_seed: chooses the samples' places.
        rain_to: metres to which real rain is traced drop by drop, a medium beyond; as far as the picture holds 30 million
            drops if None, which may take minutes.
        size, rate, shutter, fov, seed, time, environment: as of `render`.

    Raises:
        SceneError, ArrayError, FileError: as `render`.
        KeyboardInterrupt: it was interrupted.
    """
    samples = _whole(samples, "samples", 1 << 20, 1)
    sample_seed = _whole(sample_seed, "sample_seed", _MOST_SEED)
    if rain_to is not None and not 0 <= rain_to < float("inf"):
        raise ValueError(f"rain_to = {rain_to}: give metres, 0 or more")
    keys = {"rate": rate, "shutter": shutter, "time": time}
    made = read(scene, keys, size=size, seed=seed, fov=fov)
    around = _panorama(environment)
    drawing = _native.Drawing(_native.Session(), made, environment=around)
    return Reference(*drawing.reference(samples, seed=sample_seed, rain_to=rain_to))
