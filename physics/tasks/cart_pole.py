"""CartPole: keep a pole upright on a cart (Gymnasium's CartPole-v1, with a smooth reward).

    (x, x., theta, omega)' = (x, x., theta, omega) + dt (x., x'', omega, alpha)    explicit Euler
    r = 1 - ((x' / 2.4)^2 + (theta' / theta_max)^2) / 2
    ends when |x'| > 2.4 or |theta'| > theta_max = 12 degrees

Glossary: as in `cart_and_pole`; `x.` is the cart's speed (m/s), F = 10 clip(a) N.

Gymnasium's own reward is the constant 1; this one has a gradient.
"""

import math
from types import MappingProxyType

import numpy as np

from physics.environment import BoolArray, FloatArray
from physics.kernels.compiled import compiled
from physics.parameter import WithParameters
from physics.tasks.cart_and_pole import (
    DT,
    TRACK,
    CartAndPole,
    acceleration_slopes,
    accelerations,
    force_of,
    force_slope,
    machine_of,
    parameter_slopes,
)

MAX_ANGLE = 12 * 2 * math.pi / 360


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
    machine = machine_of(p)
    for row in range(states.shape[0]):
        x, speed, theta, omega = states[row]
        push, alpha = accelerations(machine, theta, omega, force_of(p, actions[row, 0]))
        next_x, next_theta = x + DT * speed, theta + DT * omega
        next_states[row, 0] = next_x
        next_states[row, 1] = speed + DT * push
        next_states[row, 2] = next_theta
        next_states[row, 3] = omega + DT * alpha
        rewards[row] = 1.0 - ((next_x / TRACK) ** 2 + (next_theta / MAX_ANGLE) ** 2) / 2.0
        terminated[row] = abs(next_x) > TRACK or abs(next_theta) > MAX_ANGLE
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
    machine = machine_of(p)
    step_rows(p, states, actions, next_states, rewards, terminated)
    state_jacobians[:] = 0.0
    action_jacobians[:] = 0.0
    reward_state_gradients[:] = 0.0
    reward_action_gradients[:] = 0.0
    reward_next_state_gradients[:] = 0.0
    for row in range(states.shape[0]):
        theta, omega, a = states[row, 2], states[row, 3], actions[row, 0]
        push_theta, push_omega, push_force, alpha_theta, alpha_omega, alpha_force = (
            acceleration_slopes(machine, theta, omega, force_of(p, a))
        )
        jacobian = state_jacobians[row]
        jacobian[0, 0], jacobian[0, 1] = 1.0, DT
        jacobian[1, 1], jacobian[1, 2], jacobian[1, 3] = 1.0, DT * push_theta, DT * push_omega
        jacobian[2, 2], jacobian[2, 3] = 1.0, DT
        jacobian[3, 2], jacobian[3, 3] = DT * alpha_theta, 1.0 + DT * alpha_omega
        action_jacobians[row, 1, 0] = DT * push_force * force_slope(p, a)
        action_jacobians[row, 3, 0] = DT * alpha_force * force_slope(p, a)
        reward_next_state_gradients[row, 0] = -next_states[row, 0] / TRACK**2
        reward_next_state_gradients[row, 2] = -next_states[row, 2] / MAX_ANGLE**2
    return -1


@compiled
def differentiate_parameters(
    p: FloatArray,
    states: FloatArray,
    actions: FloatArray,
    next_by_parameter: FloatArray,
    reward_by_parameter: FloatArray,
) -> None:
    """Differentiate every row in p; see `Environment.parameter_kernel`."""
    reward_by_parameter[:] = 0.0
    slopes = np.empty((2, 5))
    for row in range(states.shape[0]):
        parameter_slopes(p, states[row, 2], states[row, 3], actions[row, 0], slopes)
        for j in range(5):
            next_by_parameter[row, 1, j] = DT * slopes[0, j]
            next_by_parameter[row, 3, j] = DT * slopes[1, j]


class CartPole(CartAndPole):
    """The pole, upright at the start."""

    name = "CartPole"
    version = 1
    state_size = 4
    action_size = 1
    horizon = 200
    max_reward = 1.0
    step_seconds = DT
    angles = MappingProxyType({2: 1})
    step_kernel = WithParameters(step_rows)
    differentiate_kernel = WithParameters(differentiate_rows)
    parameter_kernel = WithParameters(differentiate_parameters)

    def initial_state(self, generator: np.random.Generator) -> FloatArray:
        """Nearly at rest, upright, in the middle: U(-0.05, 0.05)^4."""
        return generator.uniform(-0.05, 0.05, 4)

    def sample(self, generator: np.random.Generator, count: int) -> tuple[FloatArray, FloatArray]:
        """All over the track and a little beyond, upright or falling."""
        bound = np.array([2.6, 4.0, 0.3, 4.0])
        return (
            generator.uniform(-bound, bound, (count, 4)),
            generator.uniform(-1.5, 1.5, (count, 1)),
        )
