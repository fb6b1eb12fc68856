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
    timesteps = TIMESTEPS.get(algorithm, USUAL)
    told = subprocess.run(
        [
            *(sys.executable, "-m", "tests.workers.killed_training"),
            *(algorithm, "Pendulum", str(timesteps), str(TRIALS)),
        ],
        env=os.environ | {"PYTHONPATH": os.getcwd()},
        stdout=subprocess.PIPE,
        text=True,
        check=True,
    )
    found = json.loads(told.stdout.strip().splitlines()[-1])
    assert found["killed"] == TRIALS, "too many had ended before they could be killed"
    assert found["equal"] == TRIALS
    assert found["resumed"] >= 0.9 * TRIALS, "too many were killed before their first checkpoint"
