"""What is drawn, traced and compared."""

from __future__ import annotations

import struct
import zlib
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np
import numpy.typing as npt

from . import _native


def _png(srgb: npt.NDArray[np.uint8]) -> bytes:
    """A PNG of H x W x 3 sRGB bytes."""

    def chunk(kind: bytes, data: bytes) -> bytes:
        return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))

    height, width, _ = srgb.shape
    rows = np.zeros((height, 1 + 3 * width), np.uint8)
    rows[:, 1:] = srgb.reshape(height, -1)
    head = struct.pack(">IIBBBBB", width, height, 8, 2, 0, 0, 0)
    data = zlib.compress(rows.tobytes(), 3)
    parts = [chunk(b"IHDR", head), chunk(b"sRGB", b"\0"), chunk(b"IDAT", data), chunk(b"IEND", b"")]
    return b"\x89PNG\r\n\x1a\n" + b"".join(parts)


class Layers(Mapping[str, npt.NDArray[Any]]):
    """The rain without what is behind it, H x W each, as the command ``render --layers`` has it.

    ``R G B A`` float16: premultiplied light and opacity; over a picture: ``rgb + (1 - A) * picture``. ``Z`` float32:
    depth of the nearest drop's centre along the view axis, scene units, inf where no drop is. ``motion.X motion.Y``
    float16: pixels right and down. ``count`` uint32: drops that cover a part of the pixel. ``id`` uint64: number of the
    nearest drop, 0 for none. ``pane.A`` float16, of a scene with a pane alone: part of the pixel that drops on it cover.

    ``Z``, ``motion``, ``count`` and ``id`` are of drops that are drawn one by one: with a shutter most drops are streaks
    of one colour, which have none, unless the preset is ``exact``.
    """

    def __init__(self, drawn: dict[str, Any]) -> None:
        color = drawn["color"].view(np.float16)
        #: H x W x 2 float16: motion.X and motion.Y.
        self.motion: npt.NDArray[np.float16] = drawn["motion"].view(np.float16)
        self._all: dict[str, npt.NDArray[Any]] = {name: color[..., at] for at, name in enumerate("RGBA")}
        self._all["Z"] = drawn["Z"]
        self._all["motion.X"] = self.motion[..., 0]
        self._all["motion.Y"] = self.motion[..., 1]
        self._all["count"] = drawn["count"]
        self._all["id"] = drawn["id"]
        if "pane.A" in drawn:
            self._all["pane.A"] = drawn["pane.A"].view(np.float16)

    def __getitem__(self, name: str) -> npt.NDArray[Any]:
        return self._all[name]

    def __iter__(self) -> Iterator[str]:
        return iter(self._all)

    def __len__(self) -> int:
        return len(self._all)


class Picture:
    """A picture with rain. ``image`` is drawn already; all else is drawn when it is first read, and kept.

    Pickling keeps what was read: read what you want to send before you send it.
    """

    def __init__(self, drawing: _native.Drawing, dtype: npt.DTypeLike) -> None:
        self._drawing: _native.Drawing | None = drawing
        self._kept: dict[str, Any] = {"linear": drawing.radiance()}
        linear: npt.NDArray[np.float32] = self._kept["linear"]
        #: H x W x 3: of the type of the image that was given, uint8 sRGB (clipped at 1) or linear floats.
        self.image: npt.NDArray[Any] = linear
        if dtype == np.uint8:
            self.image = _native.srgb(linear)
        elif dtype == np.float16:
            self.image = np.minimum(linear, np.finfo(np.float16).max).astype(np.float16)

    def _drawn(self, name: str) -> Any:
        if name not in self._kept:
            if self._drawing is None:
                raise RuntimeError(f"{name} was not read before the picture was pickled")
            drawing = self._drawing
            if name == "layers":
                self._kept[name] = Layers(drawing.layers())
            elif name == "display":
                self._kept[name] = drawing.display()
            else:
                self._kept["opacity"], self._kept["contrast"] = drawing.masks()
        return self._kept[name]

    @property
    def linear(self) -> npt.NDArray[np.float32]:
        """H x W x 3 float32, linear Rec. 709: what the command writes as EXR."""
        made: npt.NDArray[np.float32] = self._drawn("linear")
        return made

    @property
    def display(self) -> npt.NDArray[np.uint8]:
        """H x W x 3 uint8 sRGB, tone mapped by the scene's operator: what the command writes as PNG."""
        made: npt.NDArray[np.uint8] = self._drawn("display")
        return made

    @property
    def layers(self) -> Layers:
        """The rain alone."""
        made: Layers = self._drawn("layers")
        return made

    @property
    def motion(self) -> npt.NDArray[np.float16]:
        """H x W x 2 float16, pixels right and down, of each pixel's nearest drop: ``layers.motion``."""
        return self.layers.motion

    @property
    def opacity(self) -> npt.NDArray[np.float32]:
        """H x W float32: share of the light behind that single drops take, over what the medium of far drops takes.

        Slightly below 0 between drops. The opacity of all rain, the medium included, is ``layers["A"]``.
        """
        made: npt.NDArray[np.float32] = self._drawn("opacity")
        return made

    @property
    def contrast(self) -> npt.NDArray[np.float32]:
        """H x W float32, at least 0: how far brightness is from that with all rain as a medium, over the latter."""
        made: npt.NDArray[np.float32] = self._drawn("contrast")
        return made

    def __array__(self, dtype: npt.DTypeLike | None = None, copy: bool | None = None) -> npt.NDArray[Any]:
        return np.array(self.image, dtype=dtype, copy=bool(copy)) if copy else np.asarray(self.image, dtype=dtype)

    def __getstate__(self) -> dict[str, Any]:
        return {**self.__dict__, "_drawing": None}

    def _repr_png_(self) -> bytes:
        return _png(self.image if self.image.dtype == np.uint8 else self.display)


@dataclass(frozen=True, eq=False)
class Reference:
    """A picture by the float64 ray tracer."""

    #: H x W x 3 float32, linear Rec. 709.
    image: npt.NDArray[np.float32]
    #: H x W float32, 0 to 1: share of each pixel that drops cover; a medium of far drops covers nothing.
    coverage: npt.NDArray[np.float32]
    #: H x W float32, 0 to 1: share of the light behind that drops and medium take.
    opacity: npt.NDArray[np.float32]

    def _repr_png_(self) -> bytes:
        mean = float(self.image.mean())
        return _png(_native.srgb(np.ascontiguousarray(self.image * np.float32(0.4 / max(mean, 1e-30)))))


@dataclass(frozen=True, eq=False)
class Comparison:
    """How far a picture is from the truth."""

    #: Mean FLIP error, 0 to 1.
    flip: float
    #: 99th percentile of the FLIP errors.
    flip_p99: float
    #: Root mean square of the difference of sRGB values, 0 to 1.
    rmse: float
    #: Peak signal-to-noise ratio of sRGB values, decibels; inf for equal pictures.
    psnr_db: float
    #: Relative mean squared error of linear radiance.
    rel_mse: float
    #: Largest difference of a channel, linear radiance.
    max_error: float
    #: Column and row of that pixel.
    max_error_at: tuple[int, int]
    #: H x W float32: the FLIP error of each pixel.
    flip_map: npt.NDArray[np.float32] = field(repr=False)

    def _repr_png_(self) -> bytes:
        grey = np.repeat((255 * np.sqrt(self.flip_map)).astype(np.uint8)[..., None], 3, axis=2)
        return _png(grey)
