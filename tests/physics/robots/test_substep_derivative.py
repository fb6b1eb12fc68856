"""The derivative of contact where it is known by hand, and on robots other than the cheetah."""

import json
import os
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest


@pytest.fixture(scope="module")
def found() -> dict[str, Any]:
    """What other_robots.py finds, uncompiled."""
    root = Path(__file__).parents[3]
    environment = {**os.environ, "NUMBA_DISABLE_JIT": "1", "PYTHONPATH": str(root)}
    run = subprocess.run(
        [sys.executable, "-m", "tests.physics.other_robots"],
        env=environment,
        cwd=root,
        capture_output=True,
        text=True,
        check=False,
    )
    assert run.returncode == 0, run.stderr
    result: dict[str, Any] = json.loads(run.stdout)
    return result


def test_sliding_takes_the_transposed_operator(found: dict[str, Any]) -> None:
    """A unit mass slides at mu = 0.3, momentum p: `vx' = px + 0.3 pz`, for friction takes 0.3 pn.

    With the untransposed operator the second derivative comes out as 0 (a published defect).
    """
    assert found["ahead"] == pytest.approx([1.0, 0.3], abs=1e-12)
    assert found["back"] == pytest.approx([1.0, -0.3], abs=1e-12)


def test_a_new_robot_is_a_description(found: dict[str, Any]) -> None:
    hop = found["hop"]
    assert hop["worst"] < 1e-6
    assert hop["residual"] < 1e-11
    assert hop["compared"] > 30
    assert hop["contacts"] > 10
