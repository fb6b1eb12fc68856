"""A run that goes on from its end has the bits of one that was as long from the start."""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest

from algorithms import catalogue
from algorithms.measurement import Measurement
from workers.checkpoints.place import folder_in
from workers.messages.assignment import Assignment
from workers.messages.progress import Progress
from workers.messages.run_spec import RunSpec, Weights
from workers.training.execute import execute

GOING_ON = sorted(name for name in catalogue.names() if catalogue.find(name).can_go_on)
WRAPPING = {"replay_size": 1000}
"""So few that the longer run forgets, and the shorter one does not."""


def spec_of(algorithm: str, timesteps: int, config: Mapping[str, Any]) -> RunSpec:
    weights = Weights(0.1, 0.1) if catalogue.find(algorithm).uses_weights else Weights()
    return RunSpec(algorithm, "Pendulum", 3, weights, timesteps, config)


def trained(spec: RunSpec, attempt: int, place: Path) -> list[Progress]:
    return list(execute([Assignment("run-3", attempt, spec, 1)], place, tuple, lambda: None))


def points(said: Sequence[Progress]) -> list[Measurement]:
    """All but what it cost, in order."""
    found = [m for progress in said for m in progress.measurements]
    return [replace(m, seconds=0.0, compile_seconds=0.0) for m in found]


def begun_at(said: Sequence[Progress]) -> int:
    [resumed] = [each for progress in said for each in progress.resumed]
    return resumed.timestep


@pytest.mark.parametrize("algorithm", GOING_ON)
@pytest.mark.parametrize("config", [{}, WRAPPING])
def test_to_the_bits_of_a_run_that_was_as_long_from_the_start(
    tmp_path: Path, algorithm: str, config: Mapping[str, Any]
) -> None:
    short, long = (spec_of(algorithm, timesteps, config) for timesteps in (800, 1600))
    trained(short, 1, tmp_path / "two")
    went_on = trained(long, 2, tmp_path / "two")
    assert begun_at(went_on) == 800
    assert points(went_on) == points(trained(long, 1, tmp_path / "one"))
    policies = [folder_in(tmp_path / way, "run-3").read("policy") for way in ("one", "two")]
    assert policies[0] == policies[1]


def test_off_the_grid_it_begins_where_it_is_on_the_way(tmp_path: Path) -> None:
    """The end of 1,000 timesteps was measured, and would not be in a longer run."""
    short, long = spec_of("ddpg", 1000, {}), spec_of("ddpg", 1600, {})
    assert [m.timestep for m in points(trained(short, 1, tmp_path / "two"))] == [800, 1000]
    went_on = trained(long, 2, tmp_path / "two")
    assert begun_at(went_on) == 0
    assert points(went_on) == points(trained(long, 1, tmp_path / "one"))


@pytest.mark.parametrize("algorithm", ["gd", "ppo"])
def test_what_depends_on_all_its_timesteps_begins_anew(tmp_path: Path, algorithm: str) -> None:
    trained(spec_of(algorithm, 800, {}), 1, tmp_path)
    assert begun_at(trained(spec_of(algorithm, 1600, {}), 2, tmp_path)) == 0


def test_every_setting_but_the_timesteps_still_tells_runs_apart(tmp_path: Path) -> None:
    trained(spec_of("ddpg", 800, {}), 1, tmp_path)
    other = spec_of("ddpg", 1600, {"noise": 0.3})
    assert begun_at(trained(other, 2, tmp_path)) == 0


def test_one_that_was_lost_at_its_end_is_told_to_have_ended(tmp_path: Path) -> None:
    """Its last checkpoint was written, and the worker was lost before it said so."""
    spec = spec_of("ddpg", 800, {})
    first = trained(spec, 1, tmp_path)
    (tmp_path / "run-3" / "policy").unlink()
    again = trained(spec, 2, tmp_path)
    assert begun_at(again) == 800
    assert [seed for progress in again for seed in progress.finished] == [3]
    assert points(again) == points(first)
    assert (tmp_path / "run-3" / "policy").exists()
