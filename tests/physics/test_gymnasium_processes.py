"""Child processes of every start method find the tasks, from a script and without one."""

import os
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
SCRIPT = Path(__file__).parent / "subprocess_vector.py"

# Nothing that children could import again: the prefix leads them to the tasks, or a spec of ours.
NO_SCRIPT = """
import functools
import sys

import gymnasium
from gymnasium.vector import AsyncVectorEnv


def walk(vector):
    vector.reset(seed=0)
    vector.step(vector.action_space.sample())
    vector.close()


make = functools.partial(gymnasium.make, "physics:d3pg/MassPoint-v0")
walk(AsyncVectorEnv([make], context=sys.argv[1]))

import physics

settings = {"context": sys.argv[1]}
walk(gymnasium.make_vec("d3pg/MassPoint-v0", 1, "async", vector_kwargs=settings))
"""

every_method = pytest.mark.parametrize("method", ["fork", "spawn", "forkserver"])


def run(*arguments: str) -> None:
    answer = subprocess.run(
        [sys.executable, *arguments],
        capture_output=True,
        text=True,
        check=False,
        env={**os.environ, "PYTHONPATH": str(ROOT)},
    )
    assert answer.returncode == 0, answer.stderr


@every_method
def test_a_script_with_stable_baselines(method: str) -> None:
    run(str(SCRIPT), method)


@every_method
def test_gymnasiums_processes_without_a_script(method: str) -> None:
    run("-c", NO_SCRIPT, method)
