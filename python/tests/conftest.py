"""What the tests share: a picture, a depth, and the command."""

from __future__ import annotations

import os
import subprocess
import sys
import textwrap
from pathlib import Path

import numpy as np
import pytest

ROOT = Path(__file__).resolve().parents[2]


@pytest.fixture
def image() -> np.ndarray:
    """A dark picture with a bright upper half, 40 x 64, sRGB."""
    made = np.zeros((40, 64, 3), np.uint8)
    made[:20] = (90, 120, 180)
    made[20:] = np.random.default_rng(1).integers(10, 60, (20, 64, 3), np.uint8)
    return made


@pytest.fixture
def depth() -> np.ndarray:
    """A wall from 4 to 40 metres, and the sky above it."""
    made = np.full((40, 64), np.inf, np.float32)
    made[20:] = np.linspace(4, 40, 64, dtype=np.float32)
    return made


@pytest.fixture
def command(tmp_path):
    """Runs the command ``raindrops`` in a folder of the test's own; what it says on stderr."""
    program = os.environ.get("RAINDROPS_COMMAND", str(ROOT / "target/debug/raindrops"))

    def run(*arguments: object, status: int = 0) -> str:
        words = [program, *map(str, arguments)]
        done = subprocess.run(words, cwd=tmp_path, capture_output=True, text=True, check=False)
        assert done.returncode == status, done.stderr
        return done.stderr

    return run


@pytest.fixture
def python(tmp_path):
    """Runs a program in a process of its own; its status and all that it says."""

    def run(text: str, seconds: float = 900, **variables: str) -> tuple[int, str]:
        path = tmp_path / "program.py"
        path.write_text(textwrap.dedent(text))
        environment = {**os.environ, **variables}
        done = subprocess.run(
            [sys.executable, str(path)],
            cwd=tmp_path,
            env=environment,
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            text=True,
            timeout=seconds,
            check=False,
        )
        return done.returncode, done.stdout

    return run
