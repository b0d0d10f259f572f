"""Arrays and whole numbers of users, checked: what comes out is of a type and a layout that the compiled part takes."""

from __future__ import annotations

import math
import operator
from typing import Any

import numpy as np
import numpy.typing as npt

from ._errors import ArrayError, SceneError

#: A picture: H x W x 3, row 0 at the top; uint8 sRGB, or float16 or float32 linear.
Image = Any


def whole(value: Any, name: str, most: int, least: int = 0) -> int:
    """A whole number within bounds."""
    try:
        number = operator.index(value)
    except TypeError:
        raise TypeError(f"{name}: a {type(value).__name__} is no whole number") from None
    if not least <= number <= most:
        bound = "2**64 - 1" if most == 2**64 - 1 else str(most)
        raise SceneError(f"{name} = {number} is not within {least} to {bound}")
    return number


def array_of(value: Any, name: str) -> npt.NDArray[Any]:
    """Of an array, of what has ``__array__``, or of a DLPack tensor on the CPU; not copied where it need not be."""
    if isinstance(value, np.ndarray):
        return value
    try:
        if hasattr(value, "__array__") or hasattr(value, "__array_interface__"):
            return np.asarray(value)
        if hasattr(value, "__dlpack__"):
            return np.from_dlpack(value)
    except Exception as error:
        raise ArrayError(f"{name}: cannot be read as an array on the CPU: {error}") from error
    kind = type(value).__name__
    raise ArrayError(f"{name}: a {kind} is no array; give a NumPy array, or what has __array__ or __dlpack__")


def _laid_out(array: npt.NDArray[Any], kind: type[np.generic]) -> npt.NDArray[Any]:
    """As the compiled part takes it: C-contiguous, aligned, no subclass; not copied where it is so already."""
    return np.require(array, kind, ["C", "A", "E"])


def picture(value: Image, name: str) -> npt.NDArray[Any]:
    """A picture as uint8 or float32."""
    array = array_of(value, name)
    if array.ndim != 3 or array.shape[2] != 3:
        mend = ""
        if array.ndim == 3 and array.shape[2] == 4:
            mend = "; leave out the alpha: [..., :3]"
        elif array.ndim == 3 and array.shape[0] == 3:
            mend = "; channels come last: transpose(1, 2, 0), of a tensor permute(1, 2, 0)"
        raise ArrayError(f"{name}: its shape is {array.shape}, not (height, width, 3){mend}")
    if array.size == 0:
        raise ArrayError(f"{name}: its shape is {array.shape}: it has no pixels")
    if array.dtype == np.uint8:
        return _laid_out(array, np.uint8)
    if array.dtype.newbyteorder("=") in (np.float16, np.float32):
        return _laid_out(array, np.float32)
    raise ArrayError(
        f"{name}: its type is {array.dtype}; give uint8 (sRGB), or float16 or float32 (linear), "
        "such as by astype(numpy.uint8) of 0 to 255, astype(numpy.float32) of linear light"
    )


def panorama(value: Image) -> npt.NDArray[Any] | None:
    """A latitude-longitude picture of all directions as uint8 or float32; None of None."""
    if value is None:
        return None
    array = picture(value, "environment")
    height, width = array.shape[:2]
    if width != 2 * height:
        raise ArrayError(
            f"environment: its shape is {array.shape}; a latitude-longitude panorama of this height is "
            f"({height}, {2 * height}, 3)"
        )
    return array


def depth(value: Any, shape: tuple[int, ...], invalid: float | None) -> tuple[npt.NDArray[np.float64], float | None]:
    """Depth of a picture of this shape, as float64, and the number in it that stands for an unknown one."""
    array = array_of(value, "depth")
    if array.ndim == 3 and array.shape[2] == 1:
        array = array[:, :, 0]
    if array.ndim != 2 or array.shape != shape[:2]:
        raise ArrayError(f"depth: its shape is {array.shape}, the image's is {shape}: give {shape[:2]}")
    kind = array.dtype.newbyteorder("=")
    if kind not in (np.float16, np.float32, np.float64):
        raise ArrayError(
            f"depth: its type is {array.dtype}; give floats, in scene units: "
            "of whole millimetres depth.astype(numpy.float32) / 1000"
        )
    if invalid is not None:
        # 0.1 is another number in float32. One that is too large for the type is not the infinity of the sky.
        with np.errstate(over="ignore"):
            stored = float(np.float64(invalid).astype(kind))
        invalid = invalid if math.isinf(stored) else stored
    return _laid_out(array, np.float64), invalid
