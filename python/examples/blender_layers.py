"""Layers of rain in Blender's compositor: colour, alpha, depth, motion and the number of the drop at every pixel.

Needs Blender's module: pip install bpy, in the Python version that it is made for. Usage: blender_layers.py rain.exr
"""

from __future__ import annotations

import sys
import tempfile
from pathlib import Path

import bpy
import numpy as np


def passes(path: str) -> dict[str, np.ndarray]:
    """Each pass of a file as Blender's compositor has it, H x W x 4, row 0 at the top."""
    image = bpy.data.images.load(path)
    scene = bpy.context.scene
    scene.use_nodes = True
    nodes, links = scene.node_tree.nodes, scene.node_tree.links
    nodes.clear()
    source = nodes.new("CompositorNodeImage")
    source.image = image
    with tempfile.TemporaryDirectory() as folder:
        out = nodes.new("CompositorNodeOutputFile")
        out.base_path = folder
        out.format.file_format, out.format.color_depth = "OPEN_EXR", "32"
        out.file_slots.clear()
        for each in source.outputs:
            out.file_slots.new(each.name)
            links.new(each, out.inputs[each.name])
        bpy.ops.render.render()
        found = {}
        for file in Path(folder).iterdir():
            loaded = bpy.data.images.load(str(file))
            loaded.colorspace_settings.name = "Non-Color"
            width, height = loaded.size
            pixels = np.empty(width * height * 4, np.float32)
            loaded.pixels.foreach_get(pixels)
            found[file.stem.removesuffix("0001")] = pixels.reshape(height, width, 4)[::-1]
    return found


def ids(found: dict[str, np.ndarray]) -> np.ndarray:
    """Numbers of drops, exact, as integers of 64 bits."""
    low, high, top = (found["id24"][..., channel].astype(np.uint64) for channel in range(3))
    return low | high << np.uint64(24) | top << np.uint64(48)


if __name__ == "__main__":
    found = passes(sys.argv[1])
    print({name: pass_.shape for name, pass_ in found.items()}, len(np.unique(ids(found))), "drops and none")
