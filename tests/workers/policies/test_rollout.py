"""A rollout: the snapshot that was written, acting, and MassPoint's surface."""

import pytest

import physics
from tests.workers.policies.test_episode import learnt
from workers.checkpoints import sealed_file
from workers.checkpoints.checkpoint_folder import POLICY
from workers.checkpoints.place import Place, folder_in
from workers.messages.run_spec import RunSpec
from workers.policies.rollout import rollout
from workers.policies.start_error import StartError

RUN = "0123456789ab-0"


def write_policy(place: Place, run_id: str, environment: str) -> None:
    """Leave what a run has learned where its worker would; the task as `physics.make` takes it."""
    snapshot = learnt(physics.make(environment))
    packed = sealed_file.packed(snapshot.arrays())
    sealed_file.write(folder_in(place, run_id), POLICY, packed)


def test_nothing_learned_is_none(place: Place) -> None:
    assert rollout(place, RUN, RunSpec("ddpg", "MassPoint", 0), None, 0) is None


def test_mass_point_comes_with_its_surface(place: Place) -> None:
    write_policy(place, RUN, "MassPoint")
    spec = RunSpec("ddpg", "MassPoint", 0, config={"gamma": 0.9})
    answer = rollout(place, RUN, spec, None, [-0.25])
    assert answer is not None
    assert answer["states"][0] == [-0.25]
    surface = answer["surface"]
    assert len(surface["value"]) == len(surface["positions"])
    assert len(surface["value"][0]) == len(surface["actions"])
    patient = rollout(place, RUN, RunSpec("ddpg", "MassPoint", 0), None, [-0.25])
    assert patient is not None
    assert patient["surface"]["truth"] != surface["truth"]
    assert patient["surface"]["value"] == surface["value"]


def test_a_start_of_another_size_is_refused(place: Place) -> None:
    write_policy(place, RUN, "MassPoint")
    with pytest.raises(StartError, match="has 1 numbers, got 2"):
        rollout(place, RUN, RunSpec("ddpg", "MassPoint", 0), None, [0.0, 0.0])
