"""MountainCar: rock a weak car out of a valley (MountainCarContinuous-v0, with a smooth reward).

    v' = clip(v + P clip(a) - G cos 3x, -0.07, 0.07)
    x' = clip(x + v', -1.2, 0.6);    at the left wall a leftward v' becomes 0
    r  = sin 3x' - 1
    ends when x' >= 0.45 and v' >= 0

Glossary:
    x   position (the valley's floor is at -pi/6, the hilltop at pi/6)
    v   velocity (per step)
    P   power of the motor, 0.0015 a step; G pull of the slope, 0.0025 a step; p = (P, G)

Gymnasium's own reward is 100 at the goal minus the squared action; this one is the height above the
valley, 0 on the hilltop. The dynamics are those of Moore (1990), as in Gymnasium.
"""

import math
from types import MappingProxyType

import numpy as np

from physics.drawing import Capsule, Drawing, Polygon, disc
from physics.environment import BoolArray, Environment, FloatArray, IntArray, Pieces, clip_sides
from physics.kernels.compiled import compiled
from physics.parameter import Parameter, WithParameters

POWER = 0.0015
SLOPE = 0.0025
MAX_SPEED = 0.07
LEFT_WALL = -1.2
RIGHT_WALL = 0.6
GOAL = 0.45

# Of the drawing (the unit of x).
HILL = 0.45
CAR_RADIUS = 0.05
MARGIN = 0.15


@compiled
def free_speed(power: float, slope: float, x: float, v: float, a: float) -> float:
    """The velocity after the step, before it is clipped."""
    return v + (min(max(a, -1.0), 1.0) * power - slope * math.cos(3.0 * x))


@compiled
def step_row(
    power: float,
    slope: float,
    row: int,
    states: FloatArray,
    actions: FloatArray,
    next_states: FloatArray,
    rewards: FloatArray,
    terminated: BoolArray,
) -> float:
    """Step one row; return its velocity before it is clipped."""
    speed = free_speed(power, slope, states[row, 0], states[row, 1], actions[row, 0])
    v = min(max(speed, -MAX_SPEED), MAX_SPEED)
    x = min(max(states[row, 0] + v, LEFT_WALL), RIGHT_WALL)
    if x == LEFT_WALL and v < 0.0:
        v = 0.0
    next_states[row, 0] = x
    next_states[row, 1] = v
    rewards[row] = math.sin(3.0 * x) - 1.0
    terminated[row] = x >= GOAL and v >= 0.0
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
    power, slope = p
    for row in range(states.shape[0]):
        step_row(power, slope, row, states, actions, next_states, rewards, terminated)
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
    power, slope = p
    for row in range(states.shape[0]):
        x, a = states[row, 0], actions[row, 0]
        speed = step_row(power, slope, row, states, actions, next_states, rewards, terminated)
        v = min(max(speed, -MAX_SPEED), MAX_SPEED)
        moves = 1.0 if abs(speed) <= MAX_SPEED else 0.0
        by_x = moves * 3.0 * slope * math.sin(3.0 * x)
        by_a = moves * power if abs(a) <= 1.0 else 0.0
        # A wall fixes the position whatever the state was; the left one also fixes the velocity.
        runs = 1.0 if LEFT_WALL <= x + v <= RIGHT_WALL else 0.0
        rolls = 0.0 if next_states[row, 0] == LEFT_WALL and v < 0.0 else 1.0
        state_jacobians[row, 0, 0] = runs * (1.0 + by_x)
        state_jacobians[row, 0, 1] = runs * moves
        state_jacobians[row, 1, 0] = rolls * by_x
        state_jacobians[row, 1, 1] = rolls * moves
        action_jacobians[row, 0, 0] = runs * by_a
        action_jacobians[row, 1, 0] = rolls * by_a
        reward_next_state_gradients[row, 0] = 3.0 * math.cos(3.0 * next_states[row, 0])
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
    power, slope = p
    for row in range(states.shape[0]):
        x, a = states[row, 0], actions[row, 0]
        speed = free_speed(power, slope, x, states[row, 1], a)
        v = min(max(speed, -MAX_SPEED), MAX_SPEED)
        moves = 1.0 if abs(speed) <= MAX_SPEED else 0.0
        runs = 1.0 if LEFT_WALL <= x + v <= RIGHT_WALL else 0.0
        rolls = 0.0 if x + v <= LEFT_WALL and v < 0.0 else 1.0
        by_power, by_slope = moves * min(max(a, -1.0), 1.0), -moves * math.cos(3.0 * x)
        next_by_parameter[row, 0, 0] = runs * by_power
        next_by_parameter[row, 0, 1] = runs * by_slope
        next_by_parameter[row, 1, 0] = rolls * by_power
        next_by_parameter[row, 1, 1] = rolls * by_slope


@compiled
def piece_rows(
    p: FloatArray,
    states: FloatArray,
    actions: FloatArray,
    speed_sides: IntArray,
    wall_sides: IntArray,
) -> None:
    """Fill both [batch] with -1, 0 or 1: the side of the speed's clip, and the wall hit."""
    power, slope = p
    for row in range(states.shape[0]):
        x = states[row, 0]
        speed = free_speed(power, slope, x, states[row, 1], actions[row, 0])
        v = min(max(speed, -MAX_SPEED), MAX_SPEED)
        speed_sides[row] = (speed > MAX_SPEED) - (speed < -MAX_SPEED)
        wall_sides[row] = (x + v > RIGHT_WALL) - (x + v < LEFT_WALL)


class MountainCar(Environment):
    """The car, at rest in the valley at the start."""

    name = "MountainCar"
    version = 1
    state_size = 2
    action_size = 1
    horizon = 200
    max_reward = 0.0
    bounds = MappingProxyType({0: (LEFT_WALL, RIGHT_WALL), 1: (-MAX_SPEED, MAX_SPEED)})
    regimes = ("free", "clipped", "wall")
    power = Parameter(POWER, "1", least=0.0, greatest=0.01, meaning="of the motor, a step")
    slope = Parameter(SLOPE, "1", least=0.0, greatest=0.01, meaning="pull of the slope, a step")
    step_kernel = WithParameters(step_rows)
    differentiate_kernel = WithParameters(differentiate_rows)
    parameter_kernel = WithParameters(differentiate_parameters)

    def initial_state(self, generator: np.random.Generator) -> FloatArray:
        """At rest: x ~ U(-0.6, -0.4)."""
        return np.array([generator.uniform(-0.6, -0.4), 0.0])

    def pieces(self, states: FloatArray, actions: FloatArray) -> Pieces:
        """Motor inside or beyond its bounds, speed likewise, and the walls."""
        motor = clip_sides(actions)[:, 0]
        speed, wall = np.empty(len(states), np.int64), np.empty(len(states), np.int64)
        piece_rows(self.parameter_values, states, actions, speed, wall)
        regime = np.where(wall != 0, 2, np.where((motor != 0) | (speed != 0), 1, 0))
        return Pieces(regime, np.stack([motor, speed, wall], axis=1))

    def sample(self, generator: np.random.Generator, count: int) -> tuple[FloatArray, FloatArray]:
        """Between the walls at every speed; every third car is next to a wall."""
        v = generator.uniform(-MAX_SPEED, MAX_SPEED, count)
        x = generator.uniform(LEFT_WALL, RIGHT_WALL, count)
        near = np.where(v < 0.0, LEFT_WALL, RIGHT_WALL) - generator.uniform(0.0, 1.5, count) * v
        x[::3] = np.clip(near, LEFT_WALL, RIGHT_WALL)[::3]
        return np.stack([x, v], axis=1), generator.uniform(-1.5, 1.5, (count, 1))

    def draw(self, state: FloatArray) -> Drawing:
        """The car on its hill, and the goal's flag."""
        left, right = LEFT_WALL - MARGIN, RIGHT_WALL + MARGIN
        hill = [_hill(float(x)) for x in np.linspace(left, right, 60)]
        foot, (x, y) = _hill(GOAL), _hill(float(state[0]))
        slope = 3.0 * HILL * math.cos(3.0 * x)
        lift = CAR_RADIUS / math.hypot(1.0, slope)  # the car stands across the slope
        return Drawing(
            view=(left, -0.1, right, 1.3),
            shapes=(
                Polygon(((left, -0.1), *hill, (right, -0.1)), "ground"),
                Capsule(foot, (foot[0], foot[1] + 0.2), 0.01, "target"),
                disc((x - lift * slope, y + lift), CAR_RADIUS, "body"),
            ),
        )


def _hill(x: float) -> tuple[float, float]:
    """The point of the hill at x, as drawn."""
    return x, HILL * math.sin(3.0 * x) + 0.55
