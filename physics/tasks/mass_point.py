"""MassPoint: a point on a line, moved by its velocity (Tan and others, section 3.3).

    s' = s + 0.01 v clip(a),    r = 1 / (s^2 + 1) - 1,    ends when |s'| < 0.01

Glossary:
    s   position (m)
    a   velocity, as a share of v = 1 m/s; p = (v,)

The reward is that of the state before the step.
"""

import numpy as np

from physics.drawing import Capsule, Drawing, disc
from physics.environment import BoolArray, Environment, FloatArray
from physics.kernels.compiled import compiled
from physics.parameter import Parameter, WithParameters

DT = 0.01
START = -0.5
GOAL_RADIUS = 0.01


@compiled
def step_rows(
    p: FloatArray,
    states: FloatArray,
    actions: FloatArray,
    next_states: FloatArray,
    rewards: FloatArray,
    terminated: BoolArray,
) -> int:
    """Step every row; see `Environment.step_kernel`."""
    for row in range(states.shape[0]):
        s = states[row, 0]
        following = s + DT * p[0] * min(max(actions[row, 0], -1.0), 1.0)
        next_states[row, 0] = following
        rewards[row] = 1.0 / (s * s + 1.0) - 1.0
        terminated[row] = abs(following) < GOAL_RADIUS
    return -1


@compiled
def differentiate_rows(
    p: FloatArray,
    states: FloatArray,
    actions: FloatArray,
    next_states: FloatArray,
    rewards: FloatArray,
    terminated: BoolArray,
    state_jacobians: FloatArray,
    action_jacobians: FloatArray,
    reward_state_gradients: FloatArray,
    reward_action_gradients: FloatArray,
    reward_next_state_gradients: FloatArray,
) -> int:
    """Step and differentiate every row; see `Environment.differentiate_kernel`."""
    step_rows(p, states, actions, next_states, rewards, terminated)
    for row in range(states.shape[0]):
        s = states[row, 0]
        state_jacobians[row, 0, 0] = 1.0
        action_jacobians[row, 0, 0] = DT * p[0] if abs(actions[row, 0]) <= 1.0 else 0.0
        reward_state_gradients[row, 0] = -2.0 * s / (s * s + 1.0) ** 2
        reward_action_gradients[row, 0] = 0.0
        reward_next_state_gradients[row, 0] = 0.0
    return -1


@compiled
def differentiate_parameters(
    p: FloatArray,  # noqa: ARG001 - for the common signature
    states: FloatArray,
    actions: FloatArray,
    next_by_parameter: FloatArray,
    reward_by_parameter: FloatArray,
) -> None:
    """Differentiate every row in p; see `Environment.parameter_kernel`."""
    reward_by_parameter[:] = 0.0
    for row in range(states.shape[0]):
        next_by_parameter[row, 0, 0] = DT * min(max(actions[row, 0], -1.0), 1.0)


class MassPoint(Environment):
    """A point that must reach the origin as quickly as possible."""

    name = "MassPoint"
    version = 1
    state_size = 1
    action_size = 1
    horizon = 200
    max_reward = 0.0
    step_seconds = DT
    max_speed = Parameter(1.0, "m/s", least=0.0, greatest=10.0, meaning="the greatest velocity")
    step_kernel = WithParameters(step_rows)
    differentiate_kernel = WithParameters(differentiate_rows)
    parameter_kernel = WithParameters(differentiate_parameters)

    def initial_state(self, generator: np.random.Generator) -> FloatArray:
        """Always -0.5."""
        del generator
        return np.array([START])

    def draw(self, state: FloatArray) -> Drawing:
        """The point on its line, and the goal."""
        return Drawing(
            view=(-2.7, -0.4, 1.7, 0.4),  # all that an episode can reach
            shapes=(
                Capsule((-2.7, 0.0), (1.7, 0.0), 0.01, "ground"),
                Capsule((0.0, -0.15), (0.0, 0.15), GOAL_RADIUS, "target"),
                disc((float(state[0]), 0.0), 0.06, "body"),
            ),
        )
