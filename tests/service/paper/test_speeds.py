"""Processor time on machines of different speed."""

from pathlib import Path

import numpy as np
import pytest

from service.paper import speeds
from service.paper.measured import read_runs
from service.paper.speeds import Speed, slowness
from tests.service.paper.measured_folder import Runs, write_folder
from workers.training.fingerprint import fingerprint


def test_a_processor_is_slower_by_what_ddpg_takes_longer_there(tmp_path: Path) -> None:
    """ddpg's runs take a second each for 8,000 timesteps, so half of one for 4,000."""
    write_folder(tmp_path, [
        Runs("Pendulum", "ddpg", [4.0, 4.0]),
        Runs("Pendulum", "shac", [8.0], processor="slow"),
        Runs("Pendulum", "ppo", [8.0]),
        Runs("Pendulum", "td3", [8.0], processor="of unknown speed"),
    ])  # fmt: skip
    speeds.write(tmp_path, [Speed("slow", "Pendulum", 4000, 0.75)])
    *reference, slow, same, unknown = read_runs(tmp_path)
    of = slowness(tmp_path)
    assert (of(slow, reference), of(same, reference)) == (1.5, 1.0)
    assert np.isnan(of(unknown, reference))


def test_what_is_measured_again_replaces_what_was_known(tmp_path: Path) -> None:
    assert speeds.read(tmp_path) == []
    speeds.write(tmp_path, [Speed("a", "Pendulum", 4000, 0.75), Speed("b", "Pendulum", 4000, 1.0)])
    speeds.write(tmp_path, [Speed("a", "Pendulum", 8000, 0.25)])
    assert speeds.read(tmp_path) == [
        Speed("a", "Pendulum", 8000, 0.25), Speed("b", "Pendulum", 4000, 1.0)
    ]  # fmt: skip


@pytest.mark.slow
def test_it_is_measured_on_sixteen_seeds() -> None:
    [speed] = speeds.measure(["Pendulum"])
    assert speed.processor == fingerprint()["processor"]
    assert (speed.environment, speed.timesteps) == ("Pendulum", 800)
    assert speed.seconds > 0
