"""Jacobians by differences in the tangent space, against those of steps in coordinates."""

from typing import Any

import numpy as np
import pytest
import torch

from physics.environment import Environment, FloatArray
from physics.mujoco import task
from physics.mujoco.derivatives import has_transition_derivatives
from physics.randomness import generator
from tests.physics.mujoco.models import ARM, FREE, distance, nearness

QUATERNIONS = ([3, 4, 5, 6], [7, 8, 9, 10])
"""Places of the two of FREE."""


def height(state: torch.Tensor, action: torch.Tensor, next_state: torch.Tensor) -> torch.Tensor:
    """A reward."""
    del state, action
    return next_state[2]


def tumbling(integrator: str, **changes: Any) -> Environment:
    """A free body with a ball joint, a hinge and an actuator that has a state."""
    arguments: dict[str, Any] = {
        "model": FREE.replace("INTEGRATOR", integrator), "reward": height, "name": "Tumbling",
        "horizon": 50, "max_reward": 2.0, "substeps": 3,
    }  # fmt: skip
    return task(**{**arguments, **changes})()


def flying(environment: Environment, length: float) -> tuple[FloatArray, FloatArray]:
    """States above the ground, their quaternions of this length, and actions."""
    random = generator(0, "flying")
    states = random.normal(size=(6, environment.state_size))
    states[:, 2] = 3.0
    for places in QUATERNIONS:
        states[:, places] *= length / np.linalg.norm(states[:, places], axis=1, keepdims=True)
    return states, random.uniform(-0.9, 0.9, (6, 2 if environment.action_size == 2 else 4))


def by_coordinates(
    environment: Environment, states: FloatArray, actions: FloatArray, width: float = 1e-5
) -> FloatArray:
    """Central differences of steps, coordinate by coordinate [batch, n, n + m]."""
    n, columns = environment.state_size, []
    for i in range(n + environment.action_size):
        moved = []
        for side in (width, -width):
            s, a = states.copy(), actions.copy()
            (s if i < n else a)[:, i if i < n else i - n] += side
            moved.append(environment.step(s, a).next_state)
        columns.append((moved[0] - moved[1]) / (2 * width))
    return np.stack(columns, axis=2)


@pytest.mark.parametrize("integrator", ["Euler", "implicitfast", "RK4"])
@pytest.mark.parametrize("length", [1.0, 1.3])
def test_a_jacobian_is_that_in_the_coordinates_of_quaternions(
    integrator: str, length: float
) -> None:
    environment = tumbling(integrator)
    states, actions = flying(environment, length)
    found = environment.differentiate(states, actions)
    ours = np.concatenate([found.state_jacobian, found.action_jacobian], axis=2)
    np.testing.assert_allclose(ours, by_coordinates(environment, states, actions), 0, 2e-6)
    for places in QUATERNIONS:
        along = found.state_jacobian[:, :, places] @ states[:, places, None]
        np.testing.assert_allclose(along, 0.0, atol=1e-12)
        lengths = np.linalg.norm(found.transition.next_state[:, places], axis=1)
        np.testing.assert_allclose(lengths, 1.0, rtol=1e-12)


def test_the_engines_derivatives_are_used_where_there_are_any() -> None:
    assert has_transition_derivatives(tumbling("implicitfast").model)  # type: ignore[attr-defined]
    assert not has_transition_derivatives(tumbling("RK4").model)  # type: ignore[attr-defined]


@pytest.mark.parametrize("integrator", ["Euler", "RK4"])
def test_forward_differences_are_less_exact(integrator: str) -> None:
    centred, forward = tumbling(integrator), tumbling(integrator, centred=False)
    states, actions = flying(centred, 1.0)
    near = by_coordinates(centred, states, actions)[:, :, : centred.state_size]
    errors = [
        np.abs(each.differentiate(states, actions).state_jacobian - near).max()
        for each in (centred, forward)
    ]
    assert errors[0] < 1e-6
    assert 2 * errors[0] < errors[1] < 1e-3


def test_measures_have_rows_and_no_columns() -> None:
    arm = task(
        ARM, nearness, name="Arm", horizon=100, max_reward=0.0, substeps=2, measure=distance
    )()
    random = generator(0, "arm")
    states, actions = random.uniform(-1.0, 1.0, (5, 7)), random.uniform(-0.9, 0.9, (5, 2))
    found = arm.differentiate(states, actions)
    ours = np.concatenate([found.state_jacobian, found.action_jacobian], axis=2)
    np.testing.assert_allclose(ours, by_coordinates(arm, states, actions), 0, 1e-7)
    assert not found.state_jacobian[:, :, 4:].any()
    assert found.state_jacobian[:, 4:, :4].any()


def test_on_the_edge_of_the_box_the_difference_is_the_one_inwards() -> None:
    for environment in (
        tumbling("RK4"),
        task(ARM, nearness, name="Arm", horizon=9, max_reward=0.0, measure=distance)(),
    ):
        states = environment.initial_states(range(3))
        inside, edge, beyond = (
            environment.differentiate(states, np.full((3, environment.action_size), a))
            for a in (1.0 - 1e-4, 1.0, 1.0 + 1e-9)
        )
        np.testing.assert_allclose(edge.action_jacobian, inside.action_jacobian, 1e-3, 1e-7)
        assert edge.action_jacobian.any()
        assert not beyond.action_jacobian.any()
