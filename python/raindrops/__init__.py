"""Rain drawn drop by drop, over your pictures or as scenes, with the error known.

>>> rain = raindrops.Rain(rate=25, shutter=1 / 60)
>>> out = rain.over(image, depth=z, fov=50, seed=7)
>>> out.image, out.opacity, out.layers["Z"]

Pictures are NumPy arrays, H x W x 3 with row 0 at the top: uint8 sRGB, or linear floats. Scenes have the keys of the
scene file. Importing opens nothing; the Vulkan device is opened with the first picture.
"""

from __future__ import annotations

import atexit
import json
import signal
from collections.abc import Sequence
from typing import Any

from . import _native
from ._arrays import Image, picture as _picture, whole as _whole
from ._errors import (
    ArrayError,
    DeviceError,
    Error,
    FileError,
    ForkError,
    NoDeviceError,
    RaindropsNote,
    RaindropsWarning,
    SceneError,
)
from ._rain import Rain, SceneLike, device_of as _device_of, read as _read, reference, render
from ._results import Comparison, Layers, Picture, Reference

__version__: str = _native.__version__
__all__ = [
    "ArrayError",
    "Comparison",
    "DeviceError",
    "Error",
    "FileError",
    "ForkError",
    "Layers",
    "NoDeviceError",
    "Picture",
    "Rain",
    "RaindropsNote",
    "RaindropsWarning",
    "Reference",
    "SceneError",
    "bench",
    "compare",
    "devices",
    "reference",
    "render",
]


def _close() -> None:
    """Keeps compiled pipelines for the next process."""
    try:
        # A pool ends its workers by this signal, also while they write, which would leave half a file in the user's cache.
        before = signal.signal(signal.SIGTERM, signal.SIG_IGN)
    except ValueError:
        # Signals are the main thread's.
        _native.close()
        return
    _native.close()
    if before is not None:
        signal.signal(signal.SIGTERM, before)


atexit.register(_close)


def compare(
    truth: Image,
    image: Image,
    *,
    tone_map: str = "photographic",
    key: float | None = None,
    exposure: float | None = None,
) -> Comparison:
    """How far a picture is from the truth, as the command ``compare`` has it.

    Args:
        truth: H x W x 3; two uint8 pictures are compared as they are, two linear ones after tone mapping.
        image: the same of the other picture.
        tone_map: ``photographic`` or ``none``; of linear pictures, before FLIP, RMSE and PSNR.
        key: luminance to which the truth's log-average is scaled before the curve; 0.18.
        exposure: a fixed factor instead.

    Raises:
        ArrayError: the pictures differ in size or kind, or are none.
    """
    kinds = ("photographic", "none")
    if tone_map not in kinds:
        raise ValueError(f"tone_map is '{tone_map}': 'photographic' or 'none'")
    a, b = (_picture(getattr(of, "image", of), name) for of, name in ((truth, "truth"), (image, "image")))
    if a.shape != b.shape:
        raise ArrayError(f"image: its shape is {b.shape}, the truth's {a.shape}: sizes must agree")
    if a.dtype != b.dtype:
        raise ArrayError(f"image: its type is {b.dtype}, the truth's {a.dtype}: compare uint8 with uint8, floats with floats")
    return Comparison(**_native.compare(a, b, curve=tone_map == "photographic", key=key, exposure=exposure))


def devices() -> list[dict[str, Any]]:
    """Every Vulkan device: name, driver, driver_info, api_version, type, and what it lacks (missing).

    Raises:
        NoDeviceError: there is none.
    """
    return _native.devices()


def bench(
    scene: SceneLike = None,
    *,
    drops: Sequence[int] = (),
    rain: Sequence[float] = (),
    preset: str | Sequence[str] = "fast",
    size: tuple[int, int] | None = None,
    seconds: float = 2.0,
    min_frames: int = 12,
    device: str | None = None,
) -> list[dict[str, Any]]:
    """Frame times, as the command ``bench`` measures them: rows of ``raindrops-bench/1`` as dicts.

    Args:
        scene: as of `render`.
        drops: numbers of random drops, a row each; the scene's own if neither drops nor rain is given.
        rain: rates of real rain, mm/h, a row each.
        preset: one or several.
        size: width and height in pixels.
        seconds: to measure a row for, or longer for ``min_frames``.

    Raises:
        As `render`.
    """
    presets = [preset] if isinstance(preset, str) else list(preset)
    if not 0 <= seconds < float("inf"):
        raise ValueError(f"seconds = {seconds} is not finite and at least 0")
    counts = [_whole(count, "drops", _native.MOST_DROPS) for count in drops]
    least = _whole(min_frames, "min_frames", 2**32 - 1)
    session = _native.Session(_device_of(device))
    made = _read(scene, {}, size=size)
    rows: list[dict[str, Any]] = json.loads(_native.bench(session, made, counts, list(rain), presets, seconds, least))
    return rows
