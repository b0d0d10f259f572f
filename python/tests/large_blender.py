"""What Blender reads of layers is what OpenEXR's own binding reads. Run by scripts/python-large.sh: large_blender.py rain.exr"""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np
import OpenEXR

sys.path.insert(0, str(Path(__file__).parent.parent / "examples"))
import blender_layers

path = sys.argv[1]
found = blender_layers.passes(path)
with OpenEXR.File(path, separate_channels=True) as file:
    channels = {name: channel.pixels for name, channel in file.channels().items()}
ids = channels["id"].astype(np.uint64) | channels["id_high"].astype(np.uint64) << np.uint64(32)
assert ids.max() > 1 << 48 and len(np.unique(ids)) > 50, "numbers of real rain"
np.testing.assert_array_equal(blender_layers.ids(found), ids)
for name, pass_, at in [
    *(("RGBA"[at], "Combined", at) for at in range(4)),
    ("Z", "Depth", 0),
    ("motion.X", "motion", 0),
    ("motion.Y", "motion", 1),
    ("count", "count", 0),
]:
    np.testing.assert_array_equal(found[pass_][..., at], channels[name].astype(np.float32), err_msg=name)
    assert np.ptp(found[pass_][np.isfinite(found[pass_])]) > 0, name
print("Blender", blender_layers.bpy.app.version_string, "reads every layer exactly")
