"""What a folder of results has of sweeps that need not be trained again."""

from pathlib import Path
from typing import Any

import pytest

from algorithms.presets import preset
from service.paper.evaluation import LEARNED, ON_POLICY, SOFT, evaluation
from service.paper.former import NOTHING, former, whole_sweeps
from tests.service.paper.measured_folder import Runs, write_evidence, write_folder
from workers.training.fingerprint import code_hash

REQUEST = {**ON_POLICY, "seeds": 2}
ENDED = [
    Runs(task, "ppo", [5.0, 6.0], preset("ppo", task).config) for task in ("Pendulum", "CartPole")
]


def test_a_sweep_is_whole_where_all_of_it_ended_by_this_code(tmp_path: Path) -> None:
    write_folder(tmp_path, ENDED)
    write_evidence(tmp_path, REQUEST)
    assert whole_sweeps(tmp_path, [SOFT, REQUEST]) == [REQUEST]


@pytest.mark.parametrize(
    "changed",
    [
        {"runs": {"total": 4, "succeeded": 3, "diverged": 0, "failed": 0, "queued": 1}},
        {"runs": {"total": 4, "succeeded": 3, "diverged": 0, "failed": 0, "cancelled": 1}},
        {"request": {**REQUEST, "seeds": 3}},
        {"fingerprints": [{"code": "of another day"}]},
        {"fingerprints": [{"code": code_hash()}, {"code": "of another day"}]},
    ],
)
def test_any_other_is_to_be_trained(tmp_path: Path, changed: dict[str, Any]) -> None:
    write_folder(tmp_path, ENDED)
    write_evidence(tmp_path, REQUEST, **changed)
    assert whole_sweeps(tmp_path, [REQUEST]) == []


def test_what_diverged_or_failed_has_ended(tmp_path: Path) -> None:
    write_folder(tmp_path, ENDED)
    runs = {"total": 4, "succeeded": 2, "diverged": 1, "failed": 1}
    write_evidence(tmp_path, REQUEST, runs=runs)
    assert whole_sweeps(tmp_path, [REQUEST]) == [REQUEST]


def test_the_place_in_the_queue_does_not_matter(tmp_path: Path) -> None:
    write_folder(tmp_path, ENDED)
    write_evidence(tmp_path, {**REQUEST, "priority": -4})
    moved = {**REQUEST, "priority": -3}
    assert whole_sweeps(tmp_path, [moved]) == [moved]


def test_a_caller_can_accept_any_code(tmp_path: Path) -> None:
    write_folder(tmp_path, ENDED)
    write_evidence(tmp_path, REQUEST, fingerprints=[{"code": "of another day"}])
    assert whole_sweeps(tmp_path, [REQUEST]) == []
    assert whole_sweeps(tmp_path, [REQUEST], any_code=True) == [REQUEST]


@pytest.mark.parametrize(
    "other", [Runs("Pendulum", "ppo", [5.0], {"rate": 0.5}), Runs("Pendulum", "shac", [5.0])]
)
def test_runs_with_settings_that_the_presets_no_longer_have_are_to_be_trained(
    tmp_path: Path, other: Runs
) -> None:
    """A change of presets.toml alone: no request and no source changes with it."""
    write_folder(tmp_path, [*ENDED, other])
    write_evidence(tmp_path, REQUEST)
    assert whole_sweeps(tmp_path, [REQUEST], any_code=True) == []


def test_an_empty_folder_has_nothing(tmp_path: Path) -> None:
    assert whole_sweeps(tmp_path, evaluation()) == []
    assert former(tmp_path, []) is NOTHING


def test_its_lines_are_those_of_its_tasks_and_learners(tmp_path: Path) -> None:
    """The sweep has sac on Acrobot, and on CartPole with a learned temperature alone."""
    algorithms = [{"name": "sac", "environments": ["Acrobot"]}, *LEARNED["algorithms"]]
    sweep = {**LEARNED, "algorithms": algorithms, "environments": ["CartPole"]}
    learned = {"temperature": "learned"}
    write_folder(tmp_path, [
        Runs("CartPole", "sac", [1.0]),
        Runs("CartPole", "sac", [2.0], learned),
        Runs("Acrobot", "sac", [3.0]),
        Runs("Acrobot", "ppo", [4.0]),
        Runs("MassPoint", "ddpg", [5.0]),
    ])  # fmt: skip
    write_evidence(tmp_path, sweep)
    found = former(tmp_path, [sweep])
    assert [line["final"] for line in found.scores] == ["2.0", "3.0"]
    assert [line["environment"] for line in found.random_returns] == ["Acrobot", "CartPole"]
    assert list(found.evidence) == list(found.statistics) == [sweep["name"]]
