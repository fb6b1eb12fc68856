"""RollingDie: a thrown die turns itself in flight to bounce to a target (Tan, section 4).

    s = (x, y, theta, vx, vy, omega),   alpha = 6 u_max clip(a)
    s'  by 0.02 s of impacts.die_motion
    r = -sqrt((x' - 5)^2 + (y' - 0.5)^2 + 1e-4)

Glossary:
    x, y       the die's centre (m), the ground at y = 0
    theta      its angle (rad, stored unwrapped)
    vx, vy     velocity of the centre (m/s)
    omega      angular velocity (rad/s)
    u_max      the greatest torque, 1 N m
    a          torque as a share of u_max: turns a flying die, but cannot tip or roll a lying one

The die is a square of side 1 m and mass 1 kg. The times of impacts depend on the state, and the
derivatives include this, so Jacobians are exact through any number of bounces; near glancing
touches they are large (entries reach about 1,300).

Corners that touch at the same moment strike one after the other, the smallest index first. So a
die that falls flat, straight down and without spin does not rise straight: with corners 2 and 3
below (theta = 0), falling at speed v, it leaves with vx = 0.245 v, vy = 0.506 v, omega = -0.235 v
(rad/s for m/s). Dropped from y = 1 m it comes to rest 0.112 m to the right; with corners 3 and 0
below (theta = -pi / 2), as far to the left. Thrown dice land flat with probability 0.
"""

import math
from types import MappingProxyType

import numpy as np

from physics.domain import ROUNDING
from physics.drawing import Drawing, box, disc
from physics.environment import (
    BoolArray,
    Environment,
    FloatArray,
    IntArray,
    Pieces,
    clip_sides,
)
from physics.impacts.die_motion import (
    FRICTION,
    GRAVITY,
    MAX_CONTACTS,
    QUARTER_TURN,
    REACH,
    RESTITUTION,
    Laws,
    lever,
    move,
)
from physics.impacts.flying_body import ALPHA, COLUMNS, ROWS, TIME, FlyingBody, start_tangent
from physics.impacts.impulse import SLIDE
from physics.impacts.trace import (
    FIELDS,
    IMPACT,
    KIND,
    LANDING,
    LYING,
    PATH,
    SETTLED,
    ImpactReport,
    Trace,
    branch_code,
    report_of,
)
from physics.kernels.compiled import compiled
from physics.parameter import Parameter, WithParameters

DT = 0.02
TORQUE_GAIN = 6.0  # 1 N m over the inertia, 1/6 kg m^2
MAX_TORQUE = 1.0
TARGET_X = 5.0
TARGET_Y = 0.5
SOFTNESS = 1e-4  # m^2, rounds the tip of the distance to the target

# Indices into RollingDie.regimes; impacts and settled contacts are further indexed by path.
FLIGHT, CLIPPED, ONE_IMPACT, SEVERAL_IMPACTS, SETTLED_ON, CUT_SHORT, STOPPING = 0, 1, 2, 5, 6, 8, 9

# Ranges of `sample`: tilt from flat, gap, rate and slip of the lowest corner, omega.
SITUATIONS = np.array(
    [
        [[-0.8, 0.8], [0.1, 3.0], [-5.0, 5.0], [-8.0, 8.0], [-8.0, 8.0]],  # in the air
        [[-0.8, 0.8], [0.0, 0.03], [-5.0, -0.2], [-8.0, 8.0], [-8.0, 8.0]],  # corner first
        [[-0.03, 0.03], [0.0, 0.03], [-4.0, -0.2], [-3.0, 3.0], [-2.0, 2.0]],  # nearly flat
        [[-0.8, 0.8], [0.0, 1e-4], [-0.02, 0.02], [-0.3, 0.3], [-4.0, 4.0]],  # settled
        [[-0.03, 0.03], [0.0, 1e-4], [-0.02, 0.02], [-2.0, 2.0], [-3.0, 3.0]],  # tipping over
        [[-5e-4, 5e-4], [0.0, 2e-4], [-0.05, 0.05], [-0.3, 0.3], [-0.15, 0.15]],  # lying
    ]
)

VIEW = (-1.0, -0.3, 8.0, 4.8)
CLEARANCE = 0.8  # m from the die's centre to the edge of the view, which moves to keep this


@compiled
def body_of(state: FloatArray) -> FlyingBody:
    """The die of a state [6], with a whole step of time left."""
    return FlyingBody(state[0], state[1], state[2], state[3], state[4], state[5], DT)


@compiled
def laws_of(p: FloatArray) -> tuple[Laws, float]:
    """The laws of a die with these parameters, and the greatest torque's acceleration (rad/s^2)."""
    return Laws(p[0], p[1], p[2]), TORQUE_GAIN * p[3]


@compiled
def angular_acceleration(gain: float, a: float) -> float:
    """The angular acceleration of an action's torque (rad/s^2)."""
    return gain * min(max(a, -1.0), 1.0)


@compiled
def arrive(body: FlyingBody, next_state: FloatArray) -> bool:
    """Write a moved die into a state [6]; return whether all of it is finite."""
    total = 0.0
    for i in range(TIME):
        next_state[i] = body[i]
        total += body[i]
    return bool(np.isfinite(total))


@compiled
def find_sunk(states: FloatArray, sunk: BoolArray) -> bool:
    """Mark the states [batch] with a corner below the ground beyond rounding; return if any has."""
    found = False
    for row in range(states.shape[0]):
        sunk[row] = False
        if states[row, 1] < REACH:
            for corner in range(4):
                height = states[row, 1] + lever(states[row, 2], corner)[1]
                sunk[row] |= height < -ROUNDING
        found |= sunk[row]
    return found


@compiled
def target_distance(x: float, y: float) -> float:
    """Distance from the target, rounded at its tip."""
    return math.sqrt((x - TARGET_X) ** 2 + (y - TARGET_Y) ** 2 + SOFTNESS)


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
    laws, gain = laws_of(p)
    for row in range(states.shape[0]):
        alpha = angular_acceleration(gain, actions[row, 0])
        body = move(body_of(states[row]), None, None, alpha, laws)
        if not arrive(body, next_states[row]):
            return row
        rewards[row] = -target_distance(body.x, body.y)
        terminated[row] = False
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
    tangent, (laws, gain) = np.empty((ROWS, COLUMNS)), laws_of(p)
    for row in range(states.shape[0]):
        start_tangent(tangent)
        alpha = angular_acceleration(gain, actions[row, 0])
        body = move(body_of(states[row]), tangent, None, alpha, laws)
        if not arrive(body, next_states[row]):
            return row
        distance = target_distance(body.x, body.y)
        rewards[row] = -distance
        terminated[row] = False
        slope = gain if abs(actions[row, 0]) <= 1.0 else 0.0
        for i in range(TIME):
            for j in range(TIME):
                state_jacobians[row, i, j] = tangent[i, j]
            action_jacobians[row, i, 0] = slope * tangent[i, ALPHA]
        reward_next_state_gradients[row, 0] = (TARGET_X - body.x) / distance
        reward_next_state_gradients[row, 1] = (TARGET_Y - body.y) / distance
    return -1


@compiled
def trace_rows(p: FloatArray, states: FloatArray, actions: FloatArray, traces: FloatArray) -> None:
    """Fill the trace [MAX_CONTACTS, FIELDS], all 0 at first, of every row's step."""
    laws, gain = laws_of(p)
    for row in range(states.shape[0]):
        alpha = angular_acceleration(gain, actions[row, 0])
        move(body_of(states[row]), None, traces[row], alpha, laws)


@compiled
def piece_rows(
    p: FloatArray, states: FloatArray, actions: FloatArray, regimes: IntArray, codes: IntArray
) -> None:
    """Fill the regime and the branch code of every row's step."""
    trace, (laws, gain) = np.empty((MAX_CONTACTS, FIELDS)), laws_of(p)
    for row in range(states.shape[0]):
        trace[:] = 0.0
        alpha = angular_acceleration(gain, actions[row, 0])
        move(body_of(states[row]), None, trace, alpha, laws)
        regimes[row] = regime_of(trace)
        codes[row] = branch_code(trace)


@compiled
def regime_of(trace: Trace) -> int:
    """Index into `RollingDie.regimes`; with several contacts, what ended the step decides."""
    regime, impacts, cut_short = FLIGHT, 0, False
    for row in range(trace.shape[0]):
        kind, path = trace[row, KIND], int(trace[row, PATH])
        if kind == LYING:
            return STOPPING + path
        if kind == IMPACT:
            impacts += 1
            regime = SEVERAL_IMPACTS if impacts > 1 else ONE_IMPACT + path // 2
        elif kind == SETTLED:
            cut_short |= trace[row, LANDING] >= 0.0
            regime = SETTLED_ON + path - SLIDE  # one that opens is cut short
        else:
            break
    return CUT_SHORT if cut_short else regime


class RollingDie(Environment):
    """A die that must be turned in flight so that it bounces to the target."""

    name = "RollingDie"
    version = 1
    state_size = 6
    action_size = 1
    horizon = 150
    max_reward = 0.0
    step_seconds = DT
    angles = MappingProxyType({2: 4})
    noise_factors = MappingProxyType({0: 0.0, 1: 0.0, 2: 0.0})  # a corner would enter the ground
    regimes = (
        "flight",
        "flight, clipped",
        "one impact, sliding",
        "one impact, sticking",
        "one impact, slip reversal",
        "several impacts",
        "settled, sliding",
        "settled, sticking",
        "settled, cut short",
        "lying, stopping",
        "lying, sliding",
    )
    gravity = Parameter(GRAVITY, "m/s^2", least=0.1, greatest=100.0, meaning="gravity")
    friction = Parameter(FRICTION, "1", least=0.01, greatest=2.0, meaning="of die and ground")
    restitution = Parameter(RESTITUTION, "1", least=0.0, greatest=1.0, meaning="of an impact")
    max_torque = Parameter(
        MAX_TORQUE, "N m", least=0.0, greatest=20.0, meaning="the greatest torque"
    )
    step_kernel = WithParameters(step_rows)
    differentiate_kernel = WithParameters(differentiate_rows)

    def initial_state(self, generator: np.random.Generator) -> FloatArray:
        """Thrown from 3 to 4 m above the ground, 5 m from the target, at any angle."""
        lowest = [0.0, 3.0, -math.pi, 1.5, -1.0, -2.0]
        return generator.uniform(lowest, [0.0, 4.0, math.pi, 2.5, 1.0, 2.0])

    def outside(self, states: FloatArray) -> BoolArray:
        """Where a corner is below the ground."""
        sunk = np.empty(len(states), np.bool_)
        find_sunk(states, sunk)
        return sunk | super().outside(states)

    def check_inside(self, states: FloatArray, actions: FloatArray) -> None:
        """Check that no corner is below the ground and that everything is finite."""
        super().check_inside(states, actions)
        sunk = np.empty(len(states), np.bool_)
        if find_sunk(states, sunk):
            raise self._domain.error(states, sunk, "no corner of the die below the ground")

    def pieces(self, states: FloatArray, actions: FloatArray) -> Pieces:
        """Every branch that every contact of the step took, and the clip of the torque."""
        states, actions = self._checked(states, actions)
        regime, code = np.empty(len(states), np.int64), np.empty(len(states), np.int64)
        piece_rows(self.parameter_values, states, actions, regime, code)
        clipped = clip_sides(actions)[:, 0]
        regime[(regime == FLIGHT) & (clipped != 0)] = CLIPPED
        return Pieces(regime, np.stack([code, clipped], axis=1))

    def contact_report(self, states: FloatArray, actions: FloatArray) -> ImpactReport:
        """The contacts of each row's step: where, when, and with what impulse.

        Raises:
            ValueError: as `step`.
        """
        states, actions = self._checked(states, actions)
        traces = np.zeros((len(states), MAX_CONTACTS, FIELDS))
        trace_rows(self.parameter_values, states, actions, traces)
        return report_of(traces, DT)

    def contact_impulses(self, states: FloatArray, actions: FloatArray) -> list[FloatArray]:
        """One impulse for each contact of the step; none for a lying die, whose weight is held.

        Raises:
            ValueError: as `step`.
        """
        report = self.contact_report(states, actions)
        arrows = np.concatenate([report.point, report.impulse], axis=-1)
        return [row[given] for row, given in zip(arrows, report.impulse[..., 1] > 0.0, strict=True)]

    def sample(self, generator: np.random.Generator, count: int) -> tuple[FloatArray, FloatArray]:
        """Dice in the air, about to land on a corner or flat, settled on one, and lying."""
        situations = SITUATIONS[np.arange(count) % len(SITUATIONS)]
        tilt, gap, rate, slip, omega = generator.uniform(situations[..., 0], situations[..., 1]).T
        theta = QUARTER_TURN * generator.integers(-4, 5, count) + tilt
        corner = REACH * np.exp(1j * (theta[:, None] + math.pi / 4 + QUARTER_TURN * np.arange(4)))
        lowest = corner[np.arange(count), corner.imag.argmin(axis=1)]
        x = generator.uniform(0.0, 8.0, count)
        y = gap - lowest.imag
        vx, vy = slip + omega * lowest.imag, rate - omega * lowest.real
        states = np.stack([x, y, theta, vx, vy, omega], axis=1)
        return states, generator.uniform(-1.2, 1.2, (count, 1))

    def draw(self, state: FloatArray) -> Drawing:
        """The die above the ground, with a pip in its corner 0, and its target."""
        x, y, theta = (float(number) for number in state[:3])
        left, bottom, right, top = VIEW
        shift = min(x - CLEARANCE - left, 0.0) + max(x + CLEARANCE - right, 0.0)
        left, right = left + shift, right + shift
        pip = 0.6 * REACH * np.exp(1j * (theta + math.pi / 4))
        return Drawing(
            (left, bottom, right, top),
            (
                box(((left + right) / 2, bottom / 2), right - left, -bottom, "ground"),
                box((TARGET_X, TARGET_Y), 1.0, 1.0, "target"),
                box((x, y), 1.0, 1.0, "body", theta),
                disc((x + float(pip.real), y + float(pip.imag)), 0.08, "joint"),
            ),
        )
