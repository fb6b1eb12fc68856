"""CartPoleSwingUp: swing a hanging pole up on a cart, and keep it there.

    x.'    = x. + dt x'',         x'     = x + dt x.'          semi-implicit Euler
    omega' = omega + dt alpha,    theta' = theta + dt omega'
    r = (1 + cos theta') / 2 - 0.05 (x' / 2.4)^2
    ends when |x'| > 2.4

Glossary: as in `cart_and_pole`; `x.` is the cart's speed (m/s), F = 10 clip(a) N.

Explicit Euler, as in CartPole, would pump energy into a swinging pole.
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

OFF_CENTRE_COST = 0.05


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
        next_speed, next_omega = speed + DT * push, omega + DT * alpha
        next_x, next_theta = x + DT * next_speed, theta + DT * next_omega
        next_states[row, 0] = next_x
        next_states[row, 1] = next_speed
        next_states[row, 2] = next_theta
        next_states[row, 3] = next_omega
        rewards[row] = (1.0 + math.cos(next_theta)) / 2.0 - OFF_CENTRE_COST * (next_x / TRACK) ** 2
        terminated[row] = abs(next_x) > TRACK
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
    reward_state_gradients[:] = 0.0
    reward_action_gradients[:] = 0.0
    reward_next_state_gradients[:] = 0.0
    for row in range(states.shape[0]):
        theta, omega, a = states[row, 2], states[row, 3], actions[row, 0]
        push_theta, push_omega, push_force, alpha_theta, alpha_omega, alpha_force = (
            acceleration_slopes(machine, theta, omega, force_of(p, a))
        )
        jacobian = state_jacobians[row]
        jacobian[1, 1], jacobian[1, 2], jacobian[1, 3] = 1.0, DT * push_theta, DT * push_omega
        jacobian[3, 2], jacobian[3, 3] = DT * alpha_theta, 1.0 + DT * alpha_omega
        action_jacobians[row, 1, 0] = DT * push_force * force_slope(p, a)
        action_jacobians[row, 3, 0] = DT * alpha_force * force_slope(p, a)
        # A position moves by dt times its new speed.
        for position in (0, 2):
            for column in range(4):
                jacobian[position, column] = DT * jacobian[position + 1, column]
            jacobian[position, position] += 1.0
            action_jacobians[row, position, 0] = DT * action_jacobians[row, position + 1, 0]
        reward_next_state_gradients[row, 0] = (
            -2.0 * OFF_CENTRE_COST * next_states[row, 0] / TRACK**2
        )
        reward_next_state_gradients[row, 2] = -math.sin(next_states[row, 2]) / 2.0
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
            next_by_parameter[row, 0, j] = DT * next_by_parameter[row, 1, j]
            next_by_parameter[row, 2, j] = DT * next_by_parameter[row, 3, j]


class CartPoleSwingUp(CartAndPole):
    """The pole, hanging at the start."""

    name = "CartPoleSwingUp"
    version = 1
    state_size = 4
    action_size = 1
    horizon = 500
    max_reward = 1.0
    step_seconds = DT
    angles = MappingProxyType({2: 1})
    step_kernel = WithParameters(step_rows)
    differentiate_kernel = WithParameters(differentiate_rows)
    parameter_kernel = WithParameters(differentiate_parameters)

    def initial_state(self, generator: np.random.Generator) -> FloatArray:
        """Nearly at rest, hanging, in the middle: U(-0.05, 0.05)^4 from theta = pi."""
        state = generator.uniform(-0.05, 0.05, 4)
        state[2] += math.pi
        return state

    def sample(self, generator: np.random.Generator, count: int) -> tuple[FloatArray, FloatArray]:
        """All over the track and a little beyond, up to two turns of the pole either way."""
        bound = np.array([2.6, 4.0, 4 * math.pi, 8.0])
        return (
            generator.uniform(-bound, bound, (count, 4)),
            generator.uniform(-1.5, 1.5, (count, 1)),
        )
