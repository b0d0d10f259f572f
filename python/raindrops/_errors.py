"""What can go wrong, and what is worth knowing beside a result."""

from __future__ import annotations

import logging
import os
import sys
import warnings
from collections.abc import Sequence

_FOLDER = os.path.dirname(__file__)
_LOG = logging.getLogger("raindrops")


class Error(Exception):
    """What the command would print on stderr: one line that names the thing, the place and the mend."""


class SceneError(Error, ValueError):
    """A key or value of a scene is wrong, or a value of a background's or an environment's array."""


class ArrayError(Error, ValueError):
    """An array has a shape, a type or a place that cannot be used."""


class FileError(Error, OSError):
    """A file cannot be read or written, or is not what it should be; one of an environment or a background, too."""


class DeviceError(Error, RuntimeError):
    """No device is meant by the name, the device lacks something, or a call of it failed."""


class NoDeviceError(DeviceError):
    """There is no Vulkan driver, or none that finds a device."""


class ForkError(DeviceError):
    """This process was forked from one that had drawn, traced, compared, measured or listed devices.

    Start workers by spawn or forkserver.
    """


class RaindropsWarning(UserWarning):
    """The result may not be what was asked for."""


class RaindropsNote(RaindropsWarning):
    """Good to know; the result is what was asked for."""


def tell(lines: Sequence[tuple[str, str]]) -> None:
    """Gives lines as warnings that name the caller's line; details go to the logger ``raindrops``."""
    level, frame = 1, sys._getframe()
    while frame.f_back is not None and os.path.dirname(frame.f_code.co_filename) == _FOLDER:
        level, frame = level + 1, frame.f_back
    for severity, text in lines:
        if severity == "detail":
            _LOG.debug("%s", text)
        else:
            category = RaindropsNote if severity == "note" else RaindropsWarning
            warnings.warn(text, category, stacklevel=level)
