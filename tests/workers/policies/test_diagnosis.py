"""A diagnosis of the snapshot that was written."""

import algorithms
import physics
from tests.workers.policies.test_episode import learnt
from tests.workers.policies.test_rollout import RUN, write_policy
from workers.checkpoints import sealed_file
from workers.checkpoints.checkpoint_folder import POLICY
from workers.checkpoints.place import Place, folder_in
from workers.messages.run_spec import RunSpec
from workers.policies.diagnosis import diagnosis


def test_nothing_learned_is_none(place: Place) -> None:
    assert diagnosis(place, RUN, RunSpec("ddpg", "MassPoint", 0), None) is None


def test_it_is_that_of_the_snapshot_with_the_run_s_discount_and_seed(place: Place) -> None:
    write_policy(place, RUN, "MassPoint")
    spec = RunSpec("ddpg", "MassPoint", 3, config={"gamma": 0.9})
    snapshot = learnt(physics.make("MassPoint"))
    expected = algorithms.diagnose("MassPoint", snapshot, 0.9, seed=3)
    assert repr(diagnosis(place, RUN, spec, None)) == repr(expected), "as text, where NaN is NaN"


def test_of_an_algorithm_without_a_critic_there_are_findings_too(place: Place) -> None:
    """Also where its settings have no discount."""
    snapshot = learnt(physics.make("MassPoint"))._replace(critic=None)
    packed = sealed_file.packed(snapshot.arrays())
    sealed_file.write(folder_in(place, RUN), POLICY, packed)
    found = diagnosis(place, RUN, RunSpec("gd", "MassPoint", 0), None)
    assert found is not None
    assert {each.diagnostic for each in found} == {"smoothing", "growth", "kinks"}
