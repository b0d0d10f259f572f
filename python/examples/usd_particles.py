"""Points of a USD stage as a sequence of particles: one NPZ file a frame.

Needs usd-core: pip install usd-core
"""

from __future__ import annotations

import tempfile
from pathlib import Path

import numpy as np
from pxr import Gf, Usd, UsdGeom

import raindrops


def write_frames(points: UsdGeom.Points, frames: range, pattern: str) -> None:
    """World positions, diameters, velocities and ids; Z up is turned into Y up. Places are in the stage's units."""
    z_up = UsdGeom.GetStageUpAxis(points.GetPrim().GetStage()) == UsdGeom.Tokens.z
    up = np.array([[1, 0, 0], [0, 0, -1], [0, 1, 0]] if z_up else np.eye(3), float)  # rows are vectors
    for frame in frames:
        time = Usd.TimeCode(frame)
        world = np.array(UsdGeom.XformCache(time).GetLocalToWorldTransform(points.GetPrim()))
        columns = {
            "P": (np.array(points.GetPointsAttr().Get(time)) @ world[:3, :3] + world[3, :3]) @ up,
            "widths": np.array(points.GetWidthsAttr().Get(time)) * np.cbrt(abs(np.linalg.det(world[:3, :3]))),
        }
        if velocities := points.GetVelocitiesAttr().Get(time):
            columns["v"] = np.array(velocities) @ world[:3, :3] @ up
        if ids := points.GetIdsAttr().Get(time):
            columns["id"] = np.array(ids)
        np.savez(pattern % frame, **columns)


if __name__ == "__main__":
    stage = Usd.Stage.CreateInMemory()
    UsdGeom.SetStageUpAxis(stage, UsdGeom.Tokens.z)
    UsdGeom.Xform.Define(stage, "/spray").AddTranslateOp().Set(Gf.Vec3d(0, 4, 2))  # 4 ahead, 2 up
    points = UsdGeom.Points.Define(stage, "/spray/drops")
    for frame in (1, 2):
        points.GetPointsAttr().Set([(-0.5, 0, 0.25 * frame), (0.5, 1, 0)], frame)
    points.GetWidthsAttr().Set([0.5, 0.25])
    points.GetVelocitiesAttr().Set([(0, 0, 0.25 * 24), (0, 0, 0)])
    points.GetIdsAttr().Set([7, 9])
    with tempfile.TemporaryDirectory() as folder:
        pattern = str(Path(folder) / "spray.%04d.npz")
        write_frames(points, range(1, 3), pattern)
        view = {"image": {"width": 96, "height": 64}, "camera": {"position": [0, 2, 0], "target": [0, 2, -1]}}
        drawn = raindrops.render({**view, "particles": {"file": pattern, "fps": 24}}, time=1 / 24)
        ids = drawn.layers["id"]
    # Both drops of frame 2 again, placed by hand.
    by_hand = [
        {"center": [-0.5, 2.5, -4], "radius": 0.25, "velocity": [0, 6, 0], "id": 7},
        {"center": [0.5, 2, -5], "radius": 0.125, "velocity": [0, 0, 0], "id": 9},
    ]
    expected = raindrops.render({**view, "drop": by_hand})
    np.testing.assert_array_equal(drawn.image, expected.image)
    np.testing.assert_array_equal(ids, expected.layers["id"])
    assert set(np.unique(ids)) == {0, 7, 9}
    print("particles of USD are the drops placed by hand")
