"""Tasks with noise: what it moves, what it leaves alone, and whether the derivatives are right."""

import copy
import pickle
from typing import Any

import gymnasium
import numpy as np
import pytest
import torch
from gymnasium.utils.env_checker import check_env

import physics
from physics.audit.audit import audit
from physics.audit.notes import failures, notes
from physics.environment import DomainError, Environment, FloatArray
from physics.gym.env import GymnasiumEnvironment
from physics.noisy_task import NoisyTask
from physics.randomness import generator
from tests.physics.small_tasks import Plain

NOISE: dict[str, Any] = {"process_noise": 0.01, "observation_noise": 0.02}
TASKS = [name for name in physics.names() if not name.startswith("mujoco/")]
every_task = pytest.mark.parametrize("name", TASKS)


def rolled(task: Environment, steps: int, rows: int = 4) -> tuple[FloatArray, FloatArray]:
    """States [steps rows, n] along episodes under random actions, and these."""
    draw = generator(0, "noisy")
    states, lived = task.initial_states(range(rows)), []
    for _ in range(steps):
        actions = draw.uniform(-1.2, 1.2, (rows, task.action_size))
        lived.append((states, actions))
        states = task.step(states, actions).next_state
    return tuple(map(np.concatenate, zip(*lived, strict=True)))  # type: ignore[return-value]


def disturbed(task: Environment, states: FloatArray) -> FloatArray:
    assert isinstance(task, NoisyTask)
    return task.disturbed(states)


@every_task
def test_a_step_is_that_of_the_disturbed_state_alone_and_in_a_batch(name: str) -> None:
    exact, task = physics.make(name), physics.make(name, **NOISE)
    n = exact.state_size
    states, actions = rolled(task, 12)
    np.testing.assert_array_equal(states[:4, :n], exact.initial_states(range(4)))
    found = task.differentiate(states, actions)
    step = exact.differentiate(disturbed(task, states), actions)
    np.testing.assert_array_equal(found.transition.next_state[:, :n], step.transition.next_state)
    np.testing.assert_array_equal(found.transition.reward, step.transition.reward)
    np.testing.assert_array_equal(found.transition.terminated, step.transition.terminated)
    np.testing.assert_array_equal(found.action_jacobian[:, :n], step.action_jacobian)
    for one, other in zip(found.transition, task.step(states, actions), strict=True):
        np.testing.assert_array_equal(one, other)
    for row in (0, 7):
        alone = task.differentiate(states[row : row + 1], actions[row : row + 1])
        for one, other in zip(alone[1:], found[1:], strict=True):
            np.testing.assert_array_equal(one[0], other[row])
    assert not found.state_jacobian[:, n:].any()
    assert not found.state_jacobian[:, :, n:].any()


@every_task
def test_without_noise_the_task_and_its_bits_are_the_same(name: str) -> None:
    exact, task = physics.make(name), physics.make(name, process_noise=0, observation_noise=0)
    assert type(task) is type(exact)
    unplanned = physics.make(name, **NOISE).without_noise()
    states, actions = rolled(unplanned, 3)
    own = np.ascontiguousarray(states[:, : exact.state_size])
    np.testing.assert_array_equal(unplanned.features(states), exact.features(own))
    np.testing.assert_array_equal(
        unplanned.step(states, actions).next_state[:, : exact.state_size],
        task.step(own, actions).next_state,
    )


def test_process_noise_has_the_deviation_asked_for_in_every_coordinate_that_it_moves() -> None:
    task = physics.make("RollingDie", process_noise=0.3)
    states = task.initial_states(range(2000))
    moved = disturbed(task, states) - states[:, :6]
    assert not moved[:, :3].any()
    assert moved[:, 3:].std(axis=0) == pytest.approx(0.3, rel=0.06)


def test_observation_noise_leaves_the_steps_alone() -> None:
    exact, task = physics.make("Pendulum"), physics.make("Pendulum", observation_noise=0.1)
    states, actions = task.initial_states(range(2000)), np.zeros((2000, 1))
    own = np.ascontiguousarray(states[:, :2])
    np.testing.assert_array_equal(
        task.step(states, actions).next_state[:, :2], exact.step(own, actions).next_state
    )
    features = task.features(states)
    assert (features[:, 2] - own[:, 1]).std() == pytest.approx(0.1, rel=0.06)
    np.testing.assert_allclose(np.hypot(features[:, 0], features[:, 1]), 1.0, rtol=1e-12)


def test_features_of_tensors_are_those_of_arrays_and_differentiable() -> None:
    task = physics.make("Pendulum", **NOISE)
    states, _ = rolled(task, 3)
    tensor = torch.from_numpy(states).requires_grad_()
    features = task.features(tensor)
    np.testing.assert_allclose(features.detach().numpy(), task.features(states), rtol=1e-15)
    features.sum().backward()  # type: ignore[no-untyped-call]
    slopes = task.feature_slopes(task.features(states))
    assert tensor.grad is not None
    np.testing.assert_allclose(tensor.grad[:, 0], slopes[:, 0] + slopes[:, 1], rtol=1e-12)
    half = torch.from_numpy(states).to(torch.float32)
    assert task.features(half).dtype == torch.float32


@pytest.mark.parametrize("name", ["MountainCar", "Pendulum", "RollingDie"])
def test_the_audit_passes_at_the_noise_drawn(name: str) -> None:
    task = physics.make(name, process_noise=0.05, observation_noise=0.1)
    rows = audit(task, 60)
    assert failures(rows, 60) == []
    assert {row.environment for row in rows} == {task.label}
    told = "\n".join(notes(task, rows))
    assert "process noise 0.05, observation noise 0.1: the derivatives compared are" in told


def test_noise_holds_a_state_within_its_bounds_where_its_derivative_is_0() -> None:
    task = physics.make("MountainCar", process_noise=0.5)
    states = task.initial_states(range(200))
    moved, bounds = disturbed(task, states), task.bounds
    for i in (0, 1):
        assert bounds[i][0] <= moved[:, i].min() < moved[:, i].max() <= bounds[i][1]
    stopped = moved[:, 0] == bounds[0][0]
    assert stopped.any()
    jacobians = task.differentiate(states, np.zeros((200, 1))).state_jacobian
    assert not jacobians[stopped, :, 0].any()


class Walled(Plain):
    """A line that ends at 1, in a way that its bounds do not tell."""

    name = "Walled"

    def check_inside(self, states: FloatArray, actions: FloatArray) -> None:
        super().check_inside(states, actions)
        if (beyond := states[:, 0] > 1.0).any():
            raise DomainError("Walled: beyond the wall", np.flatnonzero(beyond))


def test_noise_that_leaves_the_domain_says_how_to_prevent_it() -> None:
    task = Walled().with_parameters(process_noise=5.0)
    states = task.initial_states(range(20))
    with pytest.raises(DomainError, match=r"beyond the wall; .*factor of 0 in .* noise_factors"):
        task.step(states, np.zeros((20, 1)))


def test_a_torch_task_takes_noise_as_any_other_does() -> None:
    exact, task = Plain(), Plain().with_parameters(process_noise=0.1)
    assert task.label == "Plain(process_noise=0.1)"
    states, actions = rolled(task, 5)
    step = exact.step(disturbed(task, states), actions)
    np.testing.assert_array_equal(task.step(states, actions).next_state[:, :2], step.next_state)


def test_a_task_with_noise_can_be_changed_copied_and_sent() -> None:
    task = physics.make("Pendulum(gravity=9.81, process_noise=0.1)")
    assert (task.process_noise, task.observation_noise, task.state_size) == (0.1, 0.0, 4)
    assert task.with_parameters(observation_noise=1).label == (
        "Pendulum(gravity=9.81, observation_noise=1, process_noise=0.1)"
    )
    assert task.with_parameters(process_noise=0.0).state_size == 2
    assert task.parameters == physics.make("Pendulum", gravity=9.81).parameters
    states, actions = rolled(task, 2)
    for other in (copy.deepcopy(task), pickle.loads(pickle.dumps(task))):  # noqa: S301
        np.testing.assert_array_equal(
            other.step(states, actions).next_state, task.step(states, actions).next_state
        )


@pytest.mark.parametrize("value", [-0.1, float("nan"), 2e3])
def test_a_deviation_out_of_range_is_refused(value: float) -> None:
    with pytest.raises(ValueError, match="process_noise must be a number from 0 to 1000, not"):
        physics.make("Pendulum", process_noise=value)


def test_a_misspelt_name_is_told_the_nearest() -> None:
    with pytest.raises(ValueError, match=r"'proces_noise'; did you mean 'process_noise'\?"):
        physics.make("MassPoint", proces_noise=0.1)


def test_states_without_their_place_in_the_noise_are_refused() -> None:
    task = physics.make("Pendulum", **NOISE)
    with pytest.raises(ValueError, match="the last two the place in the noise"):
        task.features(np.zeros((3, 2)))
    with pytest.raises(ValueError, match=r"states must be float64 \[batch, 4\]"):
        task.step(np.zeros((3, 2)), np.zeros((3, 1)))


@pytest.mark.filterwarnings("ignore:.*A Box observation space:UserWarning")
def test_gymnasium_accepts_it_and_repeats_an_episode_of_a_seed() -> None:
    env = gymnasium.make("d3pg/MountainCar-v0", **NOISE)
    check_env(env.unwrapped, skip_render_check=True)
    noisy = GymnasiumEnvironment("MountainCar", **NOISE)
    vector = gymnasium.make_vec("d3pg/MountainCar-v0", num_envs=2, **NOISE)
    seen = vector.reset(seed=3)[0][0]
    np.testing.assert_array_equal(noisy.reset(seed=3)[0], seen)
    for _ in range(5):
        np.testing.assert_array_equal(noisy.step(np.ones(1))[0], vector.step(np.ones((2, 1)))[0][0])
