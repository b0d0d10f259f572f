"""Rain over a Hugging Face data set by `map`, in two processes.

Needs datasets and pillow: pip install datasets pillow
"""

from __future__ import annotations

from typing import Any

import multiprocess  # what datasets starts its processes by
import numpy as np
from datasets import Dataset, Features, Image

import raindrops

rain = raindrops.Rain(rate=25, shutter=1 / 60, fov=50)


def with_rain(row: dict[str, Any], number: int) -> dict[str, Any]:
    """A row with its image in the rain; every row has drops of its own."""
    photo = np.asarray(row["image"].convert("RGB"))
    return {"image": row["image"], "rainy": rain.over(photo, seed=number).image}


if __name__ == "__main__":
    # Workers may be forked, as this process draws nothing before.
    multiprocess.set_start_method("spawn", force=True)
    photos = [np.random.default_rng(n).integers(20, 120, (48, 64, 3), np.uint8) for n in range(4)]
    clean = Dataset.from_dict({"image": photos}, features=Features({"image": Image()}))
    both = Features({"image": Image(), "rainy": Image()})
    rainy = clean.map(with_rain, with_indices=True, num_proc=2, features=both)
    print(rainy, np.asarray(rainy[0]["rainy"]).shape)
