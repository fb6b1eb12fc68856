"""Acrobot: swing two links up with a motor at the joint between them (Gymnasium's Acrobot-v1).

    s'     = one Runge-Kutta step of the double pendulum under the torque u_max clip(a)
    theta' = wrapped to [-pi, pi],  omega' = clipped to 4 pi and 9 pi
    r      = -1, but 0 on the step that ends the episode
    ends when the free end is one link above the axle: -cos theta1' - cos(theta1' + theta2') > 1

Glossary: as in `double_pendulum`; `a` is the action, u_max the greatest torque, 1 N m, which is the
last of the parameters in p.

Unlike in Gymnasium, the torque is continuous. The reward is piecewise constant: methods that need
its gradient cannot use this task.
"""

import math
from types import MappingProxyType

import numpy as np

from physics.drawing import Capsule, Drawing, disc
from physics.environment import BoolArray, Environment, FloatArray, IntArray, Pieces, clip_sides
from physics.kernels.compiled import compiled
from physics.parameter import Parameter, WithParameters
from physics.tasks.double_pendulum import (
    DT,
    GRAVITY,
    INERTIA,
    LENGTH,
    MASS,
    Links,
    State,
    advance,
    advance_slopes,
    links_of,
)

MAX_TORQUE = 1.0
MAX_SPEEDS = (4.0 * math.pi, 9.0 * math.pi)
TWO_PI = 2.0 * math.pi


@compiled
def turns(theta: float) -> float:
    """The number of turns to subtract from an angle to bring it to [-pi, pi]."""
    if theta > math.pi:
        return math.ceil((theta - math.pi) / TWO_PI)
    if theta < -math.pi:
        return -math.ceil((-math.pi - theta) / TWO_PI)
    return 0.0


@compiled
def free_step(
    links: Links, max_torque: float, states: FloatArray, actions: FloatArray, row: int
) -> State:
    """The row's state after the step, before wrapping and clipping."""
    s = (states[row, 0], states[row, 1], states[row, 2], states[row, 3])
    return advance(s, max_torque * min(max(actions[row, 0], -1.0), 1.0), links)


@compiled
def end_step(
    free: State,
    row: int,
    next_states: FloatArray,
    rewards: FloatArray,
    terminated: BoolArray,
) -> None:
    """Wrap and clip a state into its row, and set its reward and whether it ends the episode."""
    theta1 = free[0] - TWO_PI * turns(free[0])
    theta2 = free[1] - TWO_PI * turns(free[1])
    next_states[row, 0] = theta1
    next_states[row, 1] = theta2
    next_states[row, 2] = min(max(free[2], -MAX_SPEEDS[0]), MAX_SPEEDS[0])
    next_states[row, 3] = min(max(free[3], -MAX_SPEEDS[1]), MAX_SPEEDS[1])
    terminated[row] = -math.cos(theta1) - math.cos(theta1 + theta2) > 1.0
    rewards[row] = 0.0 if terminated[row] else -1.0


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
    links, max_torque = links_of(p[0], p[1], p[2], p[3]), p[4]
    for row in range(states.shape[0]):
        free = free_step(links, max_torque, states, actions, row)
        end_step(free, row, next_states, rewards, terminated)
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
    reward_state_gradients[:] = 0.0
    reward_action_gradients[:] = 0.0
    reward_next_state_gradients[:] = 0.0
    links, max_torque = links_of(p[0], p[1], p[2], p[3]), p[4]
    slopes, stage, jacobian = np.empty((2, 5)), np.empty((4, 5)), np.empty((4, 5))
    for row in range(states.shape[0]):
        s = (states[row, 0], states[row, 1], states[row, 2], states[row, 3])
        torque = max_torque * min(max(actions[row, 0], -1.0), 1.0)
        free = advance_slopes(s, torque, slopes, stage, jacobian, links)
        end_step(free, row, next_states, rewards, terminated)
        torque_slope = max_torque if abs(actions[row, 0]) <= 1.0 else 0.0
        for i in range(4):
            moves = 1.0 if i < 2 or abs(free[i]) <= MAX_SPEEDS[i - 2] else 0.0
            for j in range(4):
                state_jacobians[row, i, j] = moves * jacobian[i, j]
            action_jacobians[row, i, 0] = moves * torque_slope * jacobian[i, 4]
    return -1


@compiled
def piece_rows(p: FloatArray, states: FloatArray, actions: FloatArray, pieces: IntArray) -> None:
    """Fill `pieces [batch, 4]`: each angle's turns subtracted, and each rate's side of its clip."""
    links, max_torque = links_of(p[0], p[1], p[2], p[3]), p[4]
    for row in range(states.shape[0]):
        free = free_step(links, max_torque, states, actions, row)
        for i in range(2):
            pieces[row, i] = int(turns(free[i]))
            speed, bound = free[2 + i], MAX_SPEEDS[i]
            pieces[row, 2 + i] = (speed > bound) - (speed < -bound)


class Acrobot(Environment):
    """The two links, hanging at the start."""

    name = "Acrobot"
    version = 1
    state_size = 4
    action_size = 1
    horizon = 500
    max_reward = 0.0
    step_seconds = DT
    reward_is_differentiable = False
    angles = MappingProxyType({0: 1, 1: 1})
    bounds = MappingProxyType({2 + i: (-speed, speed) for i, speed in enumerate(MAX_SPEEDS)})
    regimes = ("free", "clipped", "wrapped")
    gravity = Parameter(GRAVITY, "m/s^2", least=0.0, greatest=100.0, meaning="gravity")
    length = Parameter(LENGTH, "m", least=0.1, greatest=10.0, meaning="length of each link")
    mass = Parameter(MASS, "kg", least=0.01, greatest=100.0, meaning="mass of each link")
    inertia = Parameter(
        INERTIA, "kg m^2", least=0.01, greatest=100.0, meaning="of each link about its middle"
    )
    max_torque = Parameter(
        MAX_TORQUE, "N m", least=0.0, greatest=100.0, meaning="the motor's torque"
    )
    step_kernel = WithParameters(step_rows)
    differentiate_kernel = WithParameters(differentiate_rows)

    def initial_state(self, generator: np.random.Generator) -> FloatArray:
        """Nearly at rest, hanging: U(-0.1, 0.1)^4."""
        return generator.uniform(-0.1, 0.1, 4)

    def pieces(self, states: FloatArray, actions: FloatArray) -> Pieces:
        """Torque inside or beyond its bounds, rates likewise, turns subtracted, and the end."""
        torque, motion = clip_sides(actions), np.empty((len(states), 4), np.int64)
        piece_rows(self.parameter_values, states, actions, motion)
        ended = self.step(states, actions).terminated[:, None].astype(np.int64)
        clipped = torque.any(axis=1) | motion[:, 2:].any(axis=1)
        regime = np.where(clipped, 1, np.where(motion[:, :2].any(axis=1), 2, 0))
        return Pieces(regime, np.concatenate([torque, motion, ended], axis=1))

    def sample(self, generator: np.random.Generator, count: int) -> tuple[FloatArray, FloatArray]:
        """Every pose at every rate; half of the rates are slow, as under a policy."""
        bound = np.array([math.pi, math.pi, *MAX_SPEEDS])
        states = generator.uniform(-bound, bound, (count, 4))
        states[::2, 2:] /= 5.0
        return states, generator.uniform(-1.2, 1.2, (count, 1))

    def draw(self, state: FloatArray) -> Drawing:
        """The two links under their axle, and the height to reach."""
        theta1, theta2 = float(state[0]), float(state[0] + state[1])
        length, reach = self.length, 2.3 * self.length
        elbow = (length * math.sin(theta1), -length * math.cos(theta1))
        tip = (elbow[0] + length * math.sin(theta2), elbow[1] - length * math.cos(theta2))
        return Drawing(
            view=(-reach, -reach, reach, reach),
            shapes=(
                Capsule((-2.2 * length, length), (2.2 * length, length), 0.015, "target"),
                Capsule((0.0, 0.0), elbow, 0.1, "link"),
                Capsule(elbow, tip, 0.1, "body"),
                disc((0.0, 0.0), 0.06, "joint"),
                disc(elbow, 0.06, "joint"),
            ),
        )
