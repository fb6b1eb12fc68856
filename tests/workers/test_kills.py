"""A run that was killed twice, at any moment, ends with the bits of one that never was."""

import json
import os
import subprocess
import sys

import pytest

from algorithms import catalogue

TRIALS = 20
TIMESTEPS = {"gd": 60_000, "mpc": 10**7}
"""Some seconds of work (MPC ends with its episode); off-policy learners take as much for this:"""
USUAL = 4_800


@pytest.mark.slow
@pytest.mark.timeout(1800)
@pytest.mark.parametrize("algorithm", catalogue.OWN)
def test_killed_twice_it_ends_with_the_same_bits(algorithm: str) -> None:
    found = killed(algorithm, TRIALS, TIMESTEPS.get(algorithm, USUAL))
    assert found["equal"] == found["killed"] == TRIALS
    assert found["resumed"] >= 0.9 * TRIALS, "too many were killed before their first checkpoint"


@pytest.mark.slow
@pytest.mark.timeout(1800)
def test_its_checkpoints_may_lie_in_a_bucket(bucket: str) -> None:
    found = killed("ddpg", 3, timesteps=1600, place=f"{bucket}/kills")
    assert found["equal"] == found["killed"] == 3
    assert found["resumed"] >= 1, "all were killed before their first checkpoint"


def killed(algorithm: str, trials: int, timesteps: int, place: str = "") -> dict[str, int]:
    """What came of so many trials, `killed` of them alive."""
    told = subprocess.run(
        [
            *(sys.executable, "-m", "tests.workers.killed_training"),
            *(algorithm, "Pendulum", str(timesteps), str(trials), place),
        ],
        env=os.environ | {"PYTHONPATH": os.getcwd()},
        stdout=subprocess.PIPE,
        text=True,
        check=True,
    )
    found: dict[str, int] = json.loads(told.stdout.strip().splitlines()[-1])
    return found
