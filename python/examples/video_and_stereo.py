"""One rain through a video, seen by both eyes of a stereo pair."""

from __future__ import annotations

import numpy as np

import raindrops

APART = 0.12  # metres between the eyes

# A street for the example: sky above, dark ground from 3 to 60 m below.
height, width = 72, 128
street = np.full((height, width, 3), 150, np.uint8)
street[36:] = 40
depth = np.full((height, width), np.inf, np.float32)
depth[36:] = np.geomspace(60, 3, 36, dtype=np.float32)[:, None]

rain = raindrops.Rain(rate=50, shutter=1 / 250, near=0.3, fov=50)
left = rain.video([street] * 4, depth=[depth] * 4, fps=30, seed=7)
right = rain.video([street] * 4, depth=[depth] * 4, fps=30, seed=7, moved=(APART, 0, 0))
for number, (one, other) in enumerate(zip(left, right)):
    changed = [(eye.image != street).any(axis=2).mean() for eye in (one, other)]
    print(f"frame {number}: rain changes {changed[0]:.0%} and {changed[1]:.0%} of the pixels")
