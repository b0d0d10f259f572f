"""The compiled part: arrays of known types and shapes, and nothing checked twice."""

from typing import Any

import numpy as np
import numpy.typing as npt

__version__: str
MOST_EDGE: int
MOST_DROPS: int

class Scene:
    @staticmethod
    def read(
        dict: dict[str, Any] | None = None,
        text: str | None = None,
        path: str | None = None,
        keys: dict[str, Any] | None = None,
    ) -> Scene: ...
    def with_(
        self,
        size: tuple[int, int] | None = None,
        seed: int | None = None,
        time: float | None = None,
        fov: float | None = None,
        moved: tuple[float, ...] | None = None,
        fps: float | None = None,
    ) -> Scene: ...
    @property
    def size(self) -> tuple[int, int]: ...
    @property
    def time(self) -> float: ...
    @property
    def seed(self) -> int: ...
    @property
    def names_rain(self) -> bool: ...

class Session:
    def __init__(self, device: str | None = None) -> None: ...

class Drawing:
    def __init__(
        self,
        session: Session,
        scene: Scene,
        color: npt.NDArray[Any] | None = None,
        depth: npt.NDArray[np.float64] | None = None,
        depth_kind: str = "planar",
        depth_invalid: float | None = None,
        environment: npt.NDArray[Any] | None = None,
        frame: int = 0,
    ) -> None: ...
    def radiance(self) -> npt.NDArray[np.float32]: ...
    def display(self) -> npt.NDArray[np.uint8]: ...
    def layers(self) -> dict[str, Any]: ...
    def masks(self) -> tuple[npt.NDArray[np.float32], npt.NDArray[np.float32]]: ...
    def reference(
        self, samples: int, seed: int = 0, rain_to: float | None = None
    ) -> tuple[npt.NDArray[np.float32], npt.NDArray[np.float32], npt.NDArray[np.float32]]: ...

def compare(
    a: npt.NDArray[Any],
    b: npt.NDArray[Any],
    curve: bool = True,
    key: float | None = None,
    exposure: float | None = None,
) -> dict[str, Any]: ...
def srgb(picture: npt.NDArray[np.float32]) -> npt.NDArray[np.uint8]: ...
def bench(
    session: Session,
    scene: Scene,
    drops: list[int],
    rates: list[float],
    presets: list[str],
    seconds: float,
    frames: int,
) -> str: ...
def devices() -> list[dict[str, Any]]: ...
def close() -> None: ...
