"""The ready-made tasks are Gymnasium's v5 environments: rewards, ends, observations and starts."""

from collections.abc import Iterator
from typing import Any

import gymnasium
import numpy as np
import pytest

import physics
from physics.catalogue import EXTRAS
from physics.environment import FloatArray
from physics.mujoco import MujocoTask
from physics.randomness import generator

STEPS = 1_500
CLOSE = 1e-10


@pytest.fixture(params=EXTRAS["mujoco"], scope="module")
def task(request: pytest.FixtureRequest) -> MujocoTask:
    made = physics.make(request.param)
    assert isinstance(made, MujocoTask)
    return made


@pytest.fixture
def peer(task: MujocoTask) -> Iterator[Any]:
    # Its half cheetah has an attribute that MuJoCo warns of, in a file of the working folder.
    made: Any = gymnasium.make(f"{task.name.removeprefix('mujoco/')}-v5")
    yield made.unwrapped
    made.close()


def state_of(task: MujocoTask, peer: Any) -> FloatArray:
    """The state that Gymnasium's environment is in; a step does not depend on its measures."""
    coordinates = np.concatenate([peer.data.qpos, peer.data.qvel])
    return np.concatenate([coordinates, np.zeros(task.state_size - len(coordinates))])


@pytest.mark.parametrize("from_zero", [True, False])
def test_steps_along_random_rollouts(task: MujocoTask, peer: Any, from_zero: bool) -> None:
    """Steps from Gymnasium's states, its solver begun from zero as ours is, or where it was.

    Where the solver stops before it has converged, its begin shows: in a step of a thousand or so.
    """
    random, ends, apart = generator(0, "parity"), 0, []
    peer.reset(seed=0)
    for step in range(STEPS):
        state, action = state_of(task, peer), random.uniform(-1.0, 1.0, task.action_size)
        if from_zero:
            peer.data.qacc_warmstart[:] = 0.0
        observation, reward, terminated, _, _ = peer.step(action)
        ours = task.step(state[None], action[None])
        seen = np.abs(task.features(ours.next_state)[0] - observation).max()
        apart.append(max(float(seen), abs(float(ours.reward[0]) - reward)))
        assert ours.terminated[0] == terminated
        ends += terminated
        if terminated or step % 150 == 149:
            peer.reset()
    if from_zero:
        assert max(apart) < CLOSE
    else:
        assert np.mean(np.array(apart) < CLOSE) > 0.995
        assert max(apart) < 1e-4
    assert (ends > 0) == (
        task.name.split("/")[1] in {"Hopper", "Walker2d", "InvertedDoublePendulum"}
    )


def test_observations_of_starts(task: MujocoTask, peer: Any) -> None:
    for seed in range(20):
        observation, _ = peer.reset(seed=seed)
        start = task.simulation.completed(state_of(task, peer)[: task.simulation.coordinates])
        np.testing.assert_allclose(task.features(start[None])[0], observation, 0, CLOSE)


def test_starts_are_drawn_as_there(task: MujocoTask, peer: Any) -> None:
    """Means and spreads of many starts; the generators are not the same."""
    ours = task.initial_states(range(1_000))[:, : task.simulation.coordinates]
    theirs = []
    for seed in range(1_000):
        peer.reset(seed=seed)
        theirs.append(state_of(task, peer)[: task.simulation.coordinates])
    spread = np.std(theirs, axis=0)
    assert (np.abs(ours.mean(axis=0) - np.mean(theirs, axis=0)) <= 0.2 * spread + 1e-12).all()
    np.testing.assert_allclose(ours.std(axis=0), spread, rtol=0.1, atol=1e-12)


def test_it_is_declared_as_there(task: MujocoTask, peer: Any) -> None:
    assert (
        task.horizon == gymnasium.spec(f"{task.name.removeprefix('mujoco/')}-v5").max_episode_steps
    )
    assert task.step_seconds == pytest.approx(peer.dt, rel=1e-15)
    assert task.feature_size == peer.observation_space.shape[0]
    assert task.action_size == peer.action_space.shape[0]
    assert peer.action_space.low.tolist() == [-1.0] * task.action_size


@pytest.mark.parametrize("name", ["Swimmer", "Reacher", "InvertedDoublePendulum"])
def test_a_whole_episode_where_motion_is_not_chaotic(name: str) -> None:
    """Free rollouts from one start; where contacts amplify rounding, they part after some steps."""
    task, random = physics.make(f"mujoco/{name}"), generator(1, "parity")
    ours = gymnasium.make(f"d3pg/mujoco-{name}-v0", jacobians=False)
    peer: Any = gymnasium.make(f"{name}-v5")
    peer.reset(seed=0)
    assert isinstance(task, MujocoTask)
    ours.reset(seed=0, options={"state": state_of(task, peer.unwrapped)})
    steps, over = 0, False
    while not over and steps < 300:
        action = random.uniform(-1.0, 1.0, task.action_size)
        one, other = ours.step(action), peer.step(action)
        np.testing.assert_allclose(one[0], other[0], 0, CLOSE)
        assert one[1] == pytest.approx(other[1], rel=0, abs=CLOSE)
        assert one[2:4] == other[2:4]
        steps, over = steps + 1, one[2] or one[3]
    assert steps > 5
    peer.close()
