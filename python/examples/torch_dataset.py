"""Rain in a torch Dataset, drawn by two workers.

Needs torch: pip install torch --index-url https://download.pytorch.org/whl/cpu
"""

from __future__ import annotations

import numpy as np
import torch
from torch.utils.data import DataLoader

from rainy_dataset import Photos, RainyPhotos


class RainyTensors(torch.utils.data.Dataset[tuple[torch.Tensor, torch.Tensor]]):
    """The pictures of `RainyPhotos` as tensors, channels first."""

    def __init__(self, photos: Photos) -> None:
        self.rainy = RainyPhotos(photos)

    def __len__(self) -> int:
        return len(self.rainy)

    def __getitem__(self, index: int) -> tuple[torch.Tensor, torch.Tensor]:
        image, mask = self.rainy[index]
        return torch.from_numpy(image).permute(2, 0, 1), torch.from_numpy(mask)


if __name__ == "__main__":
    photos = [np.random.default_rng(n).integers(20, 120, (48, 64, 3), np.uint8) for n in range(8)]
    # Workers are spawned: a graphics driver does not live on in a forked child.
    loader = DataLoader(RainyTensors(photos), batch_size=4, num_workers=2, multiprocessing_context="spawn")
    for images, masks in loader:
        print(tuple(images.shape), tuple(masks.shape))
