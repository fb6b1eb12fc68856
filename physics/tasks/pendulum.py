"""Pendulum: swing a rod up with a weak motor and hold it upright (Gymnasium's Pendulum-v1).

    u       = u_max clip(a)
    r       = -(wrap(theta)^2 + 0.1 omega^2 + 0.001 u^2)
    omega'  = clip(omega + (3 g / (2 l) sin(theta) + 3 u / (m l^2)) dt, -8, 8)
    theta'  = theta + omega' dt

Glossary:
    theta   angle from upright (rad, stored unwrapped); wrap maps it to [-pi, pi)
    omega   its rate (rad/s)
    u       torque, at most u_max = 2 N m
    g, l, m gravity 10 m/s^2, length 1 m, mass 1 kg
    p       the parameters (g, l, m, u_max)

The reward is that of the state before the step, as in Gymnasium (Farama Foundation, 2024).
"""

import math
from types import MappingProxyType

import numpy as np

from physics.drawing import Capsule, Drawing, disc
from physics.environment import (
    BoolArray,
    Environment,
    FloatArray,
    Pieces,
    clip_sides,
)
from physics.kernels.compiled import compiled
from physics.parameter import Parameter, WithParameters

GRAVITY = 10.0
LENGTH = 1.0
MASS = 1.0
MAX_TORQUE = 2.0
MAX_SPEED = 8.0
DT = 0.05
TWO_PI = 2.0 * math.pi

Terms = tuple[float, float, float]


@compiled
def wrap(theta: float) -> float:
    """The same angle in [-pi, pi)."""
    return (theta + math.pi) % TWO_PI - math.pi


@compiled
def terms_of(p: FloatArray) -> Terms:
    """3 g / (2 l), 3 / (m l^2) and u_max."""
    g, length, m, max_torque = p
    return 3.0 * g / (2.0 * length), 3.0 / (m * length**2), max_torque


@compiled
def free_speed(terms: Terms, theta: float, omega: float, a: float) -> float:
    """The rate after the step, before it is clipped."""
    weight, torque, max_torque = terms
    u = max_torque * min(max(a, -1.0), 1.0)
    return omega + (weight * math.sin(theta) + torque * u) * DT


@compiled
def free_speeds(p: FloatArray, states: FloatArray, actions: FloatArray) -> FloatArray:
    """`free_speed` of every row [batch]."""
    speeds, terms = np.empty(states.shape[0]), terms_of(p)
    for row in range(states.shape[0]):
        speeds[row] = free_speed(terms, states[row, 0], states[row, 1], actions[row, 0])
    return speeds


@compiled
def step_row(
    terms: Terms,
    row: int,
    states: FloatArray,
    actions: FloatArray,
    next_states: FloatArray,
    rewards: FloatArray,
    terminated: BoolArray,
) -> float:
    """Step one row; return its rate before it is clipped."""
    theta, omega, a = states[row, 0], states[row, 1], actions[row, 0]
    u = terms[2] * min(max(a, -1.0), 1.0)
    speed = free_speed(terms, theta, omega, a)
    following = min(max(speed, -MAX_SPEED), MAX_SPEED)
    next_states[row, 0] = theta + following * DT
    next_states[row, 1] = following
    rewards[row] = -(wrap(theta) ** 2 + 0.1 * omega**2 + 0.001 * u**2)
    terminated[row] = False
    return speed


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
    terms = terms_of(p)
    for row in range(states.shape[0]):
        step_row(terms, row, states, actions, next_states, rewards, terminated)
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
    terms = terms_of(p)
    weight, torque, max_torque = terms
    for row in range(states.shape[0]):
        theta, omega, a = states[row, 0], states[row, 1], actions[row, 0]
        speed = step_row(terms, row, states, actions, next_states, rewards, terminated)
        torque_slope = max_torque if abs(a) <= 1.0 else 0.0
        speed_slope = 1.0 if abs(speed) <= MAX_SPEED else 0.0
        by_theta = speed_slope * weight * math.cos(theta) * DT
        by_a = speed_slope * torque * torque_slope * DT
        state_jacobians[row, 0, 0] = 1.0 + by_theta * DT
        state_jacobians[row, 0, 1] = speed_slope * DT
        state_jacobians[row, 1, 0] = by_theta
        state_jacobians[row, 1, 1] = speed_slope
        action_jacobians[row, 0, 0] = by_a * DT
        action_jacobians[row, 1, 0] = by_a
        reward_state_gradients[row, 0] = -2.0 * wrap(theta)
        reward_state_gradients[row, 1] = -0.2 * omega
        # u = torque_slope * a wherever the slope is not 0
        reward_action_gradients[row, 0] = -0.002 * torque_slope * torque_slope * a
        reward_next_state_gradients[row, 0] = 0.0
        reward_next_state_gradients[row, 1] = 0.0
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
    terms, length, m = terms_of(p), p[1], p[2]
    weight, torque, max_torque = terms
    for row in range(states.shape[0]):
        theta, omega, a = states[row, 0], states[row, 1], actions[row, 0]
        clipped, sin = min(max(a, -1.0), 1.0), math.sin(theta)
        u = max_torque * clipped
        if abs(free_speed(terms, theta, omega, a)) <= MAX_SPEED:
            speed = next_by_parameter[row, 1]
            speed[0] = 3.0 / (2.0 * length) * sin * DT
            speed[1] = -(weight * sin + 2.0 * torque * u) / length * DT
            speed[2] = -torque * u / m * DT
            speed[3] = torque * clipped * DT
            for j in range(4):
                next_by_parameter[row, 0, j] = speed[j] * DT
        reward_by_parameter[row, 3] = -0.002 * u * clipped


class Pendulum(Environment):
    """The pendulum, hanging or turning at the start."""

    name = "Pendulum"
    version = 1
    state_size = 2
    action_size = 1
    horizon = 200
    max_reward = 0.0
    step_seconds = DT
    angles = MappingProxyType({0: 1})
    bounds = MappingProxyType({1: (-MAX_SPEED, MAX_SPEED)})
    regimes = ("free", "clipped", "wrapped")
    gravity = Parameter(GRAVITY, "m/s^2", least=0.0, greatest=100.0, meaning="gravity")
    length = Parameter(LENGTH, "m", least=0.1, greatest=10.0, meaning="length of the rod")
    mass = Parameter(MASS, "kg", least=0.01, greatest=100.0, meaning="mass of the rod")
    max_torque = Parameter(
        MAX_TORQUE, "N m", least=0.0, greatest=100.0, meaning="the motor's torque"
    )
    step_kernel = WithParameters(step_rows)
    differentiate_kernel = WithParameters(differentiate_rows)
    parameter_kernel = WithParameters(differentiate_parameters)

    def initial_state(self, generator: np.random.Generator) -> FloatArray:
        """Any angle at a slow rate: theta ~ U(-pi, pi), omega ~ U(-1, 1)."""
        return generator.uniform([-math.pi, -1.0], [math.pi, 1.0])

    def pieces(self, states: FloatArray, actions: FloatArray) -> Pieces:
        """Torque inside or beyond its bounds, speed likewise, and the turn in the reward's wrap."""
        torque_side = clip_sides(actions)[:, 0]
        speed_side = clip_sides(free_speeds(self.parameter_values, states, actions) / MAX_SPEED)
        turn = np.floor((states[:, 0] + math.pi) / TWO_PI).astype(np.int64)
        clipped = (torque_side != 0) | (speed_side != 0)
        regime = np.where(clipped, 1, np.where(turn != 0, 2, 0))
        return Pieces(regime, np.stack([torque_side, speed_side, turn], axis=1))

    def sample(self, generator: np.random.Generator, count: int) -> tuple[FloatArray, FloatArray]:
        """Up to two turns either way, at every speed, with some torques beyond the bounds."""
        states = generator.uniform([-4 * math.pi, -8.0], [4 * math.pi, 8.0], (count, 2))
        return states, generator.uniform(-1.5, 1.5, (count, 1))

    def draw(self, state: FloatArray) -> Drawing:
        """The rod on its axle; upright is up, and a positive angle turns left."""
        tip = (-self.length * math.sin(state[0]), self.length * math.cos(state[0]))
        reach = 1.3 * self.length
        return Drawing(
            view=(-reach, -reach, reach, reach),
            shapes=(Capsule((0.0, 0.0), tip, 0.1, "link"), disc((0.0, 0.0), 0.05, "joint")),
        )
