"""A rollout: the snapshot on disk, acting, and MassPoint's surface."""

from pathlib import Path

import pytest

import physics
from tests.workers.test_episode import learnt
from workers import sealed_file
from workers.checkpoint_folder import POLICY, folder_of
from workers.rollout import STEP_SECONDS, rollout
from workers.run_spec import RunSpec
from workers.start_error import StartError

RUN = "0123456789ab-0"


def write_policy(checkpoints: Path, run_id: str, environment: str) -> None:
    """Leave what a run has learned where its worker would."""
    folder = folder_of(checkpoints, run_id)
    folder.mkdir(parents=True)
    snapshot = learnt(physics.make(environment))
    sealed_file.write(folder / POLICY, sealed_file.packed(snapshot.arrays()))


def test_nothing_learned_is_none(tmp_path: Path) -> None:
    assert rollout(tmp_path, RUN, RunSpec("ddpg", "MassPoint", 0), 0) is None


def test_mass_point_comes_with_its_surface(tmp_path: Path) -> None:
    write_policy(tmp_path, RUN, "MassPoint")
    spec = RunSpec("ddpg", "MassPoint", 0, config={"gamma": 0.9})
    answer = rollout(tmp_path, RUN, spec, [-0.25])
    assert answer is not None
    assert answer["states"][0] == [-0.25]
    surface = answer["surface"]
    assert len(surface["value"]) == len(surface["positions"])
    assert len(surface["value"][0]) == len(surface["actions"])
    patient = rollout(tmp_path, RUN, RunSpec("ddpg", "MassPoint", 0), [-0.25])
    assert patient is not None
    assert patient["surface"]["truth"] != surface["truth"]
    assert patient["surface"]["value"] == surface["value"]


def test_a_start_of_another_size_is_refused(tmp_path: Path) -> None:
    write_policy(tmp_path, RUN, "MassPoint")
    with pytest.raises(StartError, match="has 1 numbers, got 2"):
        rollout(tmp_path, RUN, RunSpec("ddpg", "MassPoint", 0), [0.0, 0.0])


def test_every_task_has_its_pace() -> None:
    assert set(STEP_SECONDS) == set(physics.names())
