"""Rain as an albumentations transform: image, mask and video alike, its rate drawn by the library's own generator.

Needs albumentations 2: pip install albumentations
"""

from __future__ import annotations

from typing import Any

import albumentations as A
import numpy as np

import raindrops


class Rain(A.ImageOnlyTransform):  # type: ignore[misc]
    """Rain of a random rate over uint8 RGB images; masks, which say what is there, stay as they are."""

    def __init__(self, rate: tuple[float, float] = (2, 50), shutter: float = 1 / 60, fov: float = 50, p: float = 1) -> None:
        super().__init__(p=p)
        self.rate, self.shutter, self.fov = rate, shutter, fov

    def get_params(self) -> dict[str, Any]:
        low, high = np.log(self.rate)
        return {"rate": float(np.exp(self.py_random.uniform(low, high))), "seed": self.py_random.getrandbits(32)}

    def apply(self, img: np.ndarray, rate: float, seed: int, **params: Any) -> np.ndarray:
        rain = raindrops.Rain(rate=rate, shutter=self.shutter, fov=self.fov)
        return rain.over(img, seed=seed).image

    def apply_to_images(self, images: np.ndarray, rate: float, seed: int, **params: Any) -> np.ndarray:
        rain = raindrops.Rain(rate=rate, shutter=self.shutter, fov=self.fov)
        return np.stack([frame.image for frame in rain.video(images, fps=30, seed=seed)])


if __name__ == "__main__":
    photo = np.random.default_rng(1).integers(20, 120, (96, 128, 3), np.uint8)
    drawn = A.Compose([Rain(), A.HorizontalFlip(p=0.5)], seed=1)(image=photo, mask=photo[..., 0])
    clip = A.Compose([Rain()], seed=1)(images=np.stack([photo] * 3))["images"]
    print(drawn["image"].shape, drawn["mask"].max(), (clip[0] != clip[1]).any())
