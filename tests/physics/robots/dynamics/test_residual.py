"""The residual passes over no number that is none."""

import numpy as np
import pytest

from physics.environment import FloatArray
from physics.kernels.compiled import compiled
from physics.record import Records
from physics.robots.dynamics.body import load_action, load_state
from physics.robots.dynamics.residual import BOUND, residual
from physics.robots.dynamics.substep import solve_substep
from physics.tasks.half_cheetah import HalfCheetah

DT = HalfCheetah.substep_seconds


@compiled
def spoiled_residual(
    mechanisms: Records, bodies: Records, states: FloatArray, actions: FloatArray, value: float
) -> tuple[int, float, float]:
    """How many contacts a solved substep has, its residual, and that with one impulse spoiled."""
    mechanism, body = mechanisms[0], bodies[0]
    load_state(mechanism, states, 0, body)
    load_action(mechanism, actions, 0, body)
    solve_substep(mechanism, DT, body)
    before = residual(mechanism, body)
    body.problem.impulse[0] = value
    return body.problem.count, before, residual(mechanism, body)


@pytest.mark.parametrize("value", [np.nan, np.inf, -np.inf])
def test_an_impulse_that_is_no_number_is_infinitely_wrong(value: float) -> None:
    environment = HalfCheetah()
    states, actions = environment.initial_states([0]), np.zeros((1, 4))
    for _ in range(20):
        states = environment.step(states, actions).next_state
    robot = environment.mechanism, np.empty(1, environment.body_type)
    contacts, before, spoiled = spoiled_residual(*robot, states, actions, value)
    assert contacts > 0
    assert before < BOUND
    assert spoiled == np.inf
