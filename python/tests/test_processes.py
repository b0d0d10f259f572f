"""Processes, threads, signals, pickling."""

from __future__ import annotations

import json
import pickle
import subprocess
import threading
from pathlib import Path

import numpy as np
import pytest

import raindrops

ROOT = Path(__file__).resolve().parents[2]

DRAW = """
import multiprocessing, os, sys, time
import numpy as np
import raindrops

rain = raindrops.Rain(rate=200)
image = np.random.default_rng(1).integers(0, 255, (16, 16, 3), np.uint8)

def draw(seed):
    return rain.over(image, seed=seed).linear
"""


def test_nothing_is_opened_before_the_first_picture(python):
    status, said = python(
        DRAW
        + """
def loaded():
    return any("vulkan" in line.lower() or "lvp" in line for line in open("/proc/self/maps"))

assert not loaded()
threads = len(os.listdir("/proc/self/task"))
pickle = __import__("pickle").dumps(rain)
assert not loaded() and threads == len(os.listdir("/proc/self/task"))
draw(1)
assert loaded()
"""
    )
    assert status == 0, said


@pytest.mark.parametrize("method", ["fork", "spawn", "forkserver"])
def test_workers_draw_the_same(python, method):
    status, said = python(
        DRAW
        + f"""
if __name__ == "__main__":
    with multiprocessing.get_context("{method}").Pool(2) as pool:
        pictures = pool.map(draw, [1, 2, 1])
    # Only now, as a child of one that has drawn could not.
    assert all((picture == draw(seed)).all() for picture, seed in zip(pictures, [1, 2, 1]))
    assert (pictures[0] != pictures[1]).any()
"""
    )
    assert status == 0, said


def test_a_child_of_one_that_has_drawn_raises_at_once(python):
    status, said = python(
        DRAW
        + """
draw(1)
child = os.fork()
if child == 0:
    start = time.monotonic()
    try:
        draw(2)
    except raindrops.ForkError as error:
        print(error)
        # Also what it drops, and its end, touch no device.
        del rain
        sys.exit(0 if time.monotonic() - start < 1 else 3)
    os._exit(4)
_, status = os.waitpid(child, 0)
assert os.waitstatus_to_exitcode(status) == 0
assert (draw(1) == draw(1)).all()
"""
    )
    assert status == 0 and "start workers by spawn or forkserver" in said, said


def test_a_child_of_one_that_has_compared_is_told_what_is_so(python):
    status, said = python(
        """
        import os, sys
        import numpy as np
        import raindrops

        image = np.zeros((8, 8, 3), np.uint8)
        raindrops.compare(image, image)
        child = os.fork()
        if child == 0:
            try:
                raindrops.devices()
            except raindrops.ForkError as error:
                print(error, flush=True)
                os._exit(0)
            os._exit(4)
        _, status = os.waitpid(child, 0)
        sys.exit(os.waitstatus_to_exitcode(status))
        """
    )
    assert status == 0 and "after raindrops had computed in that one" in said and "drawn" not in said, said


def test_a_lost_device_is_followed_by_another(python, tmp_path):
    layer = ROOT / "tests/view/fault_layer.rs"
    words = ["rustc", "--edition", "2024", "--crate-type", "cdylib", "-o", str(tmp_path / "fault.so"), str(layer)]
    subprocess.run(words, check=True)
    manifest = {"name": "VK_LAYER_RAINDROPS_fault", "type": "GLOBAL", "library_path": "./fault.so"}
    manifest |= {"api_version": "1.3.0", "implementation_version": "1", "description": "a call fails"}
    (tmp_path / "fault.json").write_text(json.dumps({"file_format_version": "1.1.2", "layer": manifest}))
    status, said = python(
        DRAW
        + """
first = draw(1)
for lose in [lambda: draw(1), lambda: raindrops.bench(drops=[10], size=(8, 8), seconds=0, min_frames=1)]:
    open(os.environ["RAINDROPS_FAULT"], "w").write("vkQueueSubmit2 -4")
    try:
        lose()
        sys.exit("nothing was lost")
    except raindrops.DeviceError as error:
        assert "ERROR_DEVICE_LOST" in str(error) or "lost" in str(error), error
    assert (draw(1) == first).all()
""",
        VK_ADD_LAYER_PATH=str(tmp_path),
        VK_INSTANCE_LAYERS="VK_LAYER_RAINDROPS_fault",
        RAINDROPS_FAULT=str(tmp_path / "fault"),
    )
    assert status == 0, said


def test_the_signal_that_ends_a_pools_workers_waits_until_files_are_whole(python):
    status, said = python(
        """
        import os, signal
        import raindrops

        def write():
            os.kill(os.getpid(), signal.SIGTERM)
            print("whole", flush=True)

        raindrops._native.close = write
        """
    )
    assert status == 0 and said.strip() == "whole", said


def test_threads_share_a_rain(image):
    rain = raindrops.Rain(rate=25)
    alone = [rain.over(image, seed=seed).image for seed in range(4)]
    shared: dict[int, np.ndarray] = {}

    def draw(seed: int) -> None:
        shared[seed] = rain.over(image, seed=seed).image

    threads = [threading.Thread(target=draw, args=(seed,)) for seed in range(4)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    for seed in range(4):
        np.testing.assert_array_equal(shared[seed], alone[seed])


def test_the_lock_is_released_while_it_draws():
    turns = 0
    is_done = threading.Event()

    def count() -> None:
        nonlocal turns
        while not is_done.wait(0.001):
            turns += 1

    thread = threading.Thread(target=count)
    thread.start()
    before = turns
    raindrops.reference({"image": {"width": 64, "height": 64}, "rain": {"count": 100_000}}, samples=16)
    during = turns - before
    is_done.set()
    thread.join()
    # Held, the lock would leave the counter no turn.
    assert during > 2


def test_objects_pickle(image):
    rain = pickle.loads(pickle.dumps(raindrops.Rain(rate=25, wind=(1, 0, 0), scene={"camera": {"near": 0.2}})))
    out = raindrops.Rain(rate=25, wind=(1, 0, 0), scene={"camera": {"near": 0.2}}).over(image, seed=5)
    np.testing.assert_array_equal(rain.over(image, seed=5).image, out.image)
    depth = out.layers["Z"]
    copy = pickle.loads(pickle.dumps(out))
    np.testing.assert_array_equal(copy.image, out.image)
    np.testing.assert_array_equal(copy.layers["Z"], depth)
    with pytest.raises(RuntimeError, match="contrast was not read before"):
        copy.contrast
    scene = {"camera": {"near": 0.2}}
    wind = np.array([1.0, 0.0, 0.0])
    kept = raindrops.Rain(rate=25, wind=wind, scene=scene)
    scene["camera"]["near"], wind[0] = 3.0, 9.0
    np.testing.assert_array_equal(pickle.loads(pickle.dumps(kept)).over(image, seed=5).image, out.image)
    found = raindrops.compare(out, out)
    assert pickle.loads(pickle.dumps(found)).flip == found.flip


@pytest.mark.parametrize(
    ("traced", "after"),
    [
        # Many tiles; one that takes long, of drops in a box, of far rain; what is prepared for rain, a ray for each sample.
        ("""{"image": {"width": 4096, "height": 4096}, "rain": {"count": 1000}}, samples=64""", 1),
        ("""{"image": {"width": 8, "height": 8}, "rain": {"count": 3000, "radius": 0.001}}, samples=1 << 20""", 1),
        ("""{"image": {"width": 8, "height": 8}, "rain": {"rate": 100.0}}, samples=1, rain_to=60""", 4),
        ("""{"image": {"width": 64, "height": 64}, "rain": {"rate": 100.0}}, samples=1 << 16, rain_to=0""", 1),
    ],
)
def test_ctrl_c_ends_a_reference(python, traced, after):
    status, said = python(
        f"""
        import os, signal, threading, time
        import raindrops

        threading.Timer({after}, os.kill, (os.getpid(), signal.SIGINT)).start()
        try:
            raindrops.reference({traced})
        except KeyboardInterrupt:
            # What was stopped does not stop what comes after.
            raindrops.reference({{"image": {{"width": 8, "height": 8}}, "rain": {{"count": 10}}}}, samples=1)
            print("interrupted")
        """,
        seconds=120,
    )
    assert status == 0 and said.strip() == "interrupted", said
