"""LinearQuadratic: a task with a known answer, to hold planners against.

    s' = F s + B clip(a),    r = -(s' W s' + s' U s + a R a) / 2,    never ends

The reward depends on all three of its arguments, and mixes two of them. Stacked over x = (s, a) the
cost of a step is x' C x / 2 with C positive semi-definite.
"""

import numpy as np

from physics.drawing import Drawing
from physics.environment import BoolArray, Environment, FloatArray

F = np.array([[1.0, 0.1, 0.0], [0.0, 0.9, 0.2], [-0.1, 0.0, 1.05]])
B = np.array([[0.0, 0.1], [0.2, 0.0], [0.05, 0.3]])
W = np.array([[2.0, 0.3, 0.0], [0.3, 1.0, 0.0], [0.0, 0.0, 0.5]])
U = np.array([[0.2, 0.0, 0.1], [0.0, 0.1, 0.0], [0.0, -0.1, 0.1]])
R = np.array([[0.5, 0.1], [0.1, 0.3]])

FB = np.hstack([F, B])
MIXED = FB.T @ np.hstack([U, np.zeros((3, 2))])
COST = FB.T @ W @ FB + (MIXED + MIXED.T) / 2 + np.block([[np.zeros((3, 5))], [np.zeros((2, 3)), R]])
"""C"""


def step_rows(
    states: FloatArray,
    actions: FloatArray,
    next_states: FloatArray,
    rewards: FloatArray,
    terminated: BoolArray,
) -> int:
    x = np.concatenate([states, np.clip(actions, -1.0, 1.0)], axis=1)
    next_states[:] = x @ FB.T
    rewards[:] = -np.einsum("bi,ij,bj->b", x, COST, x) / 2
    terminated[:] = False
    return -1


def differentiate_rows(
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
    step_rows(states, actions, next_states, rewards, terminated)
    is_inside = np.abs(actions) <= 1.0
    state_jacobians[:] = F
    action_jacobians[:] = B * is_inside[:, None]
    reward_state_gradients[:] = -next_states @ U / 2
    reward_action_gradients[:] = -np.clip(actions, -1.0, 1.0) @ R * is_inside
    reward_next_state_gradients[:] = -next_states @ W - states @ U.T / 2
    return -1


class LinearQuadratic(Environment):
    """Bring a linear system to rest."""

    name = "LinearQuadratic"
    version = 1
    state_size = 3
    action_size = 2
    horizon = 20
    max_reward = 0.0
    step_kernel = staticmethod(step_rows)
    differentiate_kernel = staticmethod(differentiate_rows)

    def initial_state(self, generator: np.random.Generator) -> FloatArray:
        return generator.uniform(-1.0, 1.0, 3)

    def draw(self, state: FloatArray) -> Drawing:
        raise NotImplementedError("nothing to see")
