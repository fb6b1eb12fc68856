"""States outside a task's domain are refused by every call, and their rows are named."""

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
import torch

import physics
from physics.audit.differences import differences, relative_errors
from physics.environment import DomainError, Environment, FloatArray

OUTSIDE = [
    ("RollingDie", 1, -50.0, "no corner of the die below the ground"),
    ("RollingDie", 1, 0.49, "no corner of the die below the ground"),
    ("MountainCar", 0, 5.0, r"-1\.2 <= s\[0\] <= 0\.6 and -0\.07 <= s\[1\] <= 0\.07"),
    ("MountainCar", 0, -1.3, r"-1\.2 <= s\[0\]"),
    ("MountainCar", 1, 0.08, r"s\[1\] <= 0\.07"),
    ("Pendulum", 1, 100.0, r"-8 <= s\[1\] <= 8"),
    ("Acrobot", 2, -13.0, r"-12\.5664 <= s\[2\] <= 12\.5664"),
    ("Acrobot", 3, 1e300, r"-28\.2743 <= s\[3\] <= 28\.2743"),
    ("HalfCheetah", 1, -5.0, "nothing below the ground"),
    ("HalfCheetah", 3, 3.0, "no joint beyond its stop"),
]


def torch_step(task: Environment) -> Callable[[FloatArray, FloatArray], object]:
    return lambda s, a: physics.torch_step(task, torch.from_numpy(s), torch.from_numpy(a))


@pytest.mark.parametrize(("name", "coordinate", "value", "domain"), OUTSIDE)
def test_no_call_takes_a_state_from_outside(
    name: str, coordinate: int, value: float, domain: str
) -> None:
    task = physics.make(name)
    states = task.initial_states(range(5))
    states[[2, 4], coordinate] = value
    actions = np.zeros((5, task.action_size))
    assert task.outside(states).tolist() == [False, False, True, False, True]
    for call in (task.step, task.differentiate, task.contact_impulses, torch_step(task)):
        with pytest.raises(DomainError, match=domain) as caught:
            call(states, actions)
        assert caught.value.rows == (2, 4)
        assert f"{name}: row 2 lies outside the domain" in str(caught.value)


@pytest.mark.parametrize("name", physics.names())
@pytest.mark.parametrize("hold", [1, 20, 10_000])
def test_no_step_leads_outside(name: str, hold: int) -> None:
    """Bang-bang at random, held, and constant: also as a float32 keeps the states."""
    task = physics.make(name)
    random: Any = np.random.default_rng(hold)
    states = task.initial_states(range(16))
    for step in range(400):
        if step % hold == 0:
            actions = random.choice([-1.0, 1.0], (16, task.action_size))
        states = task.step(states, actions).next_state
        assert not task.outside(states).any()
        assert not task.outside(states.astype(np.float32).astype(np.float64)).any()


@pytest.mark.parametrize(
    ("name", "state"),
    [
        ("MountainCar", [-1.2, -0.07]),
        ("MountainCar", [0.6, 0.07]),
        ("Pendulum", [20.0, -8.0]),
        ("Acrobot", [7.0, -7.0, 4 * np.pi, -9 * np.pi]),
        ("RollingDie", [0.0, 0.5, 0.0, 1.0, 0.0, 0.0]),
        ("CartPole", [3.0, 50.0, 1.0, 50.0]),
        ("CartPoleSwingUp", [-3.0, 50.0, 100.0, -50.0]),
        ("MassPoint", [1e3]),
    ],
)
def test_the_edge_is_inside_and_so_is_what_has_no_edge(name: str, state: list[float]) -> None:
    task = physics.make(name)
    task.differentiate(np.array([state]), np.zeros((1, task.action_size)))


def test_differences_at_an_edge_come_from_inside() -> None:
    task, state, action = physics.make("MountainCar"), np.array([[0.6, 0.0]]), np.zeros((1, 1))
    found = differences(task, state, action)
    assert found.smooth.tolist() == [True]
    assert relative_errors(task.differentiate(state, action), found)[0] < 1e-6
