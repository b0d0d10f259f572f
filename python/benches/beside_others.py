"""Rain over one picture by this package, albumentations and kornia: processor time a picture, one process on one core.

    python beside_others.py ENVIRONMENT.exr [--frame COMMAND] [-o SHOWN.png]

The pictures are a view of the environment, turned by as much as their seed says: no two are the same. --frame: a program `raindrops`, whose frame of the same rain is timed in the same run. Prints a table in Markdown.
SHOWN.png has the picture with the rain of each beside each other. Needs albumentations 2, kornia and opencv; Linux.
"""

from __future__ import annotations

import argparse
import json
import os
import statistics
import subprocess
import tempfile
import time
import warnings
from collections.abc import Callable
from pathlib import Path

os.sched_setaffinity(0, {min(os.sched_getaffinity(0))})  # before llvmpipe and torch count the cores

import albumentations  # noqa: E402
import cv2  # noqa: E402
import kornia  # noqa: E402
import numpy as np  # noqa: E402
import torch  # noqa: E402

import raindrops  # noqa: E402

SIZES = (256, 512, 1024)
RATE, SHUTTER, FOV = 25, 1 / 60, 60
ROUNDS, PICTURES = 3, 4


def by_raindrops(panorama: np.ndarray | None) -> Callable[[np.ndarray, int], np.ndarray]:
    rain = raindrops.Rain(rate=RATE, shutter=SHUTTER, fov=FOV)
    return lambda image, seed: rain.over(image, seed=seed, environment=panorama).image


def by_albumentations() -> Callable[[np.ndarray, int], np.ndarray]:
    transform = albumentations.Compose([albumentations.RandomRain(p=1)], seed=1)
    return lambda image, _: transform(image=image)["image"]


def by_kornia() -> Callable[[np.ndarray, int], np.ndarray]:
    transform = kornia.augmentation.RandomRain(p=1)

    def draw(image: np.ndarray, seed: int) -> np.ndarray:
        torch.manual_seed(seed)
        tensor = torch.from_numpy(image).permute(2, 0, 1)[None].float() / 255
        return (transform(tensor)[0].permute(1, 2, 0).numpy() * 255).astype(np.uint8)

    return draw


def frame_seconds(command: str, size: int) -> float:
    """Processor time of a frame of the command's; on one core that is the time that passes."""
    with tempfile.TemporaryDirectory() as folder:
        scene, found = Path(folder, "rain.toml"), Path(folder, "found.json")
        scene.write_text(f"""[image]\nwidth = {size}\nheight = {size}\n[camera]\nvertical_fov = {FOV}
shutter = {SHUTTER}\n[rain]\nrate = {RATE}\n""")
        words = [command, "bench", scene, "--preset", "fast", "--seconds", "1", "--json", found]
        subprocess.run(list(map(str, words)), check=True, capture_output=True)
        return json.loads(found.read_text())["rows"][0]["median_ms"] / 1000


def main() -> None:
    options = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    options.add_argument("environment")
    options.add_argument("--frame", help="a program raindrops to be timed as well")
    options.add_argument("-o", dest="shown", type=Path)
    given = options.parse_args()
    warnings.simplefilter("ignore", raindrops.RaindropsNote)
    torch.set_num_threads(1)
    cv2.setNumThreads(1)
    view = {"environment": {"file": given.environment}, "camera": {"vertical_fov": FOV}, "rain": {"count": 0}}
    photo = raindrops.render(view, size=(1024, 1024)).display
    panorama = cv2.resize(photo, (1024, 512))
    drawn_by = {
        "raindrops, a panorama given": by_raindrops(panorama),
        "raindrops, none": by_raindrops(None),
        "albumentations": by_albumentations(), "kornia": by_kornia(),
    }
    columns = [*drawn_by, *(["a frame of the given command"] if given.frame else [])]
    print("| picture |", " | ".join(columns), "|")
    print("|---" * (len(columns) + 1) + "|")
    for size in SIZES:
        image = np.ascontiguousarray(cv2.resize(photo, (size, size), interpolation=cv2.INTER_AREA))
        times: dict[str, list[float]] = {name: [] for name in columns}
        for draw in drawn_by.values():
            draw(image, 0)
        for turn in range(ROUNDS):
            for name, draw in drawn_by.items():
                before = time.process_time()
                for seed in range(turn * PICTURES, (turn + 1) * PICTURES):
                    draw(np.roll(image, 5 * seed, axis=1), seed)
                times[name].append((time.process_time() - before) / PICTURES)
            if given.frame:
                times[columns[-1]].append(frame_seconds(given.frame, size))
        print(f"| {size} x {size} |", " | ".join(f"{1000 * statistics.median(of):.1f} ms" for of in times.values()), "|", flush=True)
    if given.shown:
        image = np.ascontiguousarray(cv2.resize(photo, (384, 384), interpolation=cv2.INTER_AREA))
        shown = np.hstack([draw(image, 3) for draw in drawn_by.values()])
        cv2.imwrite(str(given.shown), shown[..., ::-1])


if __name__ == "__main__":
    main()
