"""A data set of photographs with rain and its mask, for any loader that asks for __len__ and __getitem__."""

from __future__ import annotations

from collections.abc import Sequence
from multiprocessing import get_context

import numpy as np
import numpy.typing as npt

import raindrops

Photos = Sequence[npt.NDArray[np.uint8]]


class RainyPhotos:
    """Item n is photograph n with rain of seed n, and how much light its single drops take."""

    def __init__(self, photos: Photos) -> None:
        self.photos = photos
        self.rain = raindrops.Rain(rate=25, shutter=1 / 60, fov=50)

    def __len__(self) -> int:
        return len(self.photos)

    def __getitem__(self, index: int) -> tuple[npt.NDArray[np.uint8], npt.NDArray[np.float32]]:
        out = self.rain.over(self.photos[index], seed=index)
        return out.image, out.opacity


if __name__ == "__main__":
    photos = [np.random.default_rng(n).integers(20, 120, (48, 64, 3), np.uint8) for n in range(4)]
    dataset = RainyPhotos(photos)
    with get_context("spawn").Pool(2) as workers:
        drawn = workers.map(dataset.__getitem__, range(len(dataset)))
    for image, mask in drawn:
        print(image.shape, image.dtype, f"{mask.max():.2f}")
