"""HalfCheetah: run forward on two legs of two links, with hard contact.

MuJoCo's half cheetah (Wawrzynski 2009; Todorov et al. 2012) with each foot welded to its shin. Five
substeps of 0.01 s under one action, each as time_stepping.py has it.

    s = (q, v),    q = (rootx, rootz, rooty, bthigh, bshin, fthigh, fshin)
    r = (x' - x) / 0.05 - 0.1 |clip(a)|^2

Glossary:
    rootx, rootz   place of the torso's middle (m), rootz as an offset from 0.7 m
    rooty          pitch (rad), positive with the nose down
    bthigh, ...    joint angles (rad), b the back leg, f the front leg
    a              motors of the four joints, gears 120, 90, 120, 60 N m

Contact points are the end spheres of all capsules, torso's first, then head, bthigh, bshin, bfoot,
fthigh, fshin, ffoot; of each the end along +axis first (of the torso the front one).
"""

from types import MappingProxyType

import numpy as np

from physics.drawing import Drawing
from physics.environment import (
    BoolArray,
    Environment,
    FloatArray,
    Pieces,
    clip_sides,
)
from physics.kernels.compiled import compiled
from physics.record import dtype
from physics.robots.body import Body, load_action, load_state, unload
from physics.robots.description import build, sizes
from physics.robots.drawing import draw_robot
from physics.robots.report import (
    ContactReport,
    empty_report,
    find_sunk,
    report_rows,
    signature_rows,
    sphere_centres,
)
from physics.robots.residual import BOUND, residual
from physics.robots.smooth_dynamics import mass_matrices, smooth_forces
from physics.robots.substep import advance, solve_substep
from physics.robots.substep_derivative import (
    Tangent,
    differentiate_substep,
    load_tangent,
    unload_tangent,
)
from physics.row_checks import float64_rows
from physics.tasks.half_cheetah_robot import ROBOT

DT = 0.01
SUBSTEPS = 5
CONTROL_COST = 0.1

CHEETAH = build(ROBOT)
BODY = dtype(Body, **sizes(ROBOT))
TANGENT = dtype(Tangent, **sizes(ROBOT))
COORDINATES = len(ROBOT.links) + 2
SPHERES = CHEETAH["radius"].shape[1]
DEEPEST = 5e-3
"""How deep (m, rad) a sphere may be in the ground, or a joint in its stop: rollouts stay above."""
ONE_OF_EACH_SPHERE = sum(1 << 2 * k for k in range(SPHERES))
"""The lower of the two bits that a signature has for each sphere."""
RESTING_SPEED = 0.1
"""Slower than this (m/s, rad/s) in all coordinates, a step in steady contact counts as resting."""


@compiled
def reward(x: float, next_x: float, actions: FloatArray, row: int) -> float:
    """Mean speed over the step, less the cost of the clipped action."""
    cost = 0.0
    for i in range(actions.shape[1]):
        cost += min(max(actions[row, i], -1.0), 1.0) ** 2
    return (next_x - x) / (SUBSTEPS * DT) - CONTROL_COST * cost


@compiled
def step_rows(
    states: FloatArray,
    actions: FloatArray,
    next_states: FloatArray,
    rewards: FloatArray,
    terminated: BoolArray,
) -> int:
    """Step every row; see `Environment.step_kernel`."""
    mechanism, bodies = CHEETAH[0], np.empty(1, BODY)
    for row in range(states.shape[0]):
        body = bodies[0]  # taken in the loop, which keeps `bodies` alive
        load_state(mechanism, states, row, body)
        load_action(mechanism, actions, row, body)
        for _ in range(SUBSTEPS):
            solve_substep(mechanism, DT, body)
            if not residual(mechanism, body) <= BOUND:
                return row
            advance(body, DT)
        unload(mechanism, body, next_states, row)
        rewards[row] = reward(states[row, 0], next_states[row, 0], actions, row)
        terminated[row] = False
    return -1


@compiled
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
    """Step and differentiate every row; see `Environment.differentiate_kernel`."""
    mechanism, bodies, tangents = CHEETAH[0], np.empty(1, BODY), np.empty(1, TANGENT)
    for row in range(states.shape[0]):
        body, tangent = bodies[0], tangents[0]
        load_state(mechanism, states, row, body)
        load_action(mechanism, actions, row, body)
        load_tangent(mechanism, actions, row, tangent)
        for _ in range(SUBSTEPS):
            solve_substep(mechanism, DT, body)
            if not residual(mechanism, body) <= BOUND:
                return row
            differentiate_substep(mechanism, DT, body, tangent)
            advance(body, DT)
        unload(mechanism, body, next_states, row)
        unload_tangent(mechanism, tangent, state_jacobians, action_jacobians, row)
        rewards[row] = reward(states[row, 0], next_states[row, 0], actions, row)
        terminated[row] = False
        for i in range(states.shape[1]):
            reward_state_gradients[row, i] = -1.0 / (SUBSTEPS * DT) if i == 0 else 0.0
            reward_next_state_gradients[row, i] = 1.0 / (SUBSTEPS * DT) if i == 0 else 0.0
        for i in range(actions.shape[1]):
            a = actions[row, i]
            reward_action_gradients[row, i] = -2.0 * CONTROL_COST * a if abs(a) <= 1.0 else 0.0
    return -1


class HalfCheetah(Environment):
    """The half cheetah, dropped on its feet at the start."""

    name = "HalfCheetah"
    version = 1
    state_size = 2 * COORDINATES
    action_size = 4
    horizon = 200
    max_reward = 10.0
    step_seconds = SUBSTEPS * DT
    angles = MappingProxyType({2: 1})
    hidden = (0,)
    regimes = ("free", "clipped", "sticking", "sliding", "resting", "opening", "joint limit")
    step_kernel = staticmethod(step_rows)
    differentiate_kernel = staticmethod(differentiate_rows)

    def initial_state(self, generator: np.random.Generator) -> FloatArray:
        """MuJoCo's start, raised until no sphere is below the ground."""
        q = generator.uniform(-0.1, 0.1, COORDINATES)
        v = 0.1 * generator.standard_normal(COORDINATES)
        state = np.concatenate([q, v])
        lowest = np.min(self._sphere_centres(state)[:, 1] - CHEETAH["radius"][0])
        state[1] += max(0.0, -lowest)
        return state

    def outside(self, states: FloatArray) -> BoolArray:
        """Where a sphere is in the ground, or a joint beyond its stop, deeper than a step leads."""
        sunk = np.empty(len(states), np.bool_)
        find_sunk(CHEETAH, np.empty(1, BODY), states, DEEPEST, sunk)
        return sunk | super().outside(states)

    def check_inside(self, states: FloatArray, actions: FloatArray) -> None:
        """No sphere in the ground, no joint beyond its stop, and everything finite."""
        super().check_inside(states, actions)
        sunk = np.empty(len(states), np.bool_)
        if find_sunk(CHEETAH, np.empty(1, BODY), states, DEEPEST, sunk):
            raise self._domain.error(
                states,
                sunk,
                "nothing below the ground and no joint beyond its stop by 5 mm or mrad",
            )

    def contact_report(self, states: FloatArray, actions: FloatArray) -> ContactReport:
        """What the contacts of one step do, substep by substep.

        Raises:
            ValueError, UnsolvedStepError: as `step`.
        """
        states, actions = self._checked(states, actions)
        report = empty_report(CHEETAH, len(states), SUBSTEPS)
        unsolved = report_rows(CHEETAH, np.empty(1, BODY), DT, states, actions, report)
        if unsolved >= 0:
            raise self.failure(states[unsolved], actions[unsolved])
        return report

    def contact_impulses(self, states: FloatArray, actions: FloatArray) -> list[FloatArray]:
        """One for each sphere in contact, summed over the step, where the sphere ends.

        Raises:
            ValueError, UnsolvedStepError: as `step`.
        """
        report = self.contact_report(states, actions)
        following = self.step(states, actions).next_state
        centres = np.empty((len(following), SPHERES, 2))
        sphere_centres(CHEETAH, np.empty(1, BODY), following, centres)
        lowest = centres - [0.0, 1.0] * CHEETAH["radius"][0][:, None]
        impulses = [report.tangential_impulse.sum(axis=1), report.normal_impulse.sum(axis=1)]
        arrows = np.concatenate([lowest, np.stack(impulses, axis=-1)], axis=-1)
        return [row[given] for row, given in zip(arrows, arrows[..., 3] > 0.0, strict=True)]

    def mass_matrix(self, q: FloatArray) -> FloatArray:
        """M(q) [b, 7, 7] for coordinates [b, 7], armature included (kg, kg m, kg m^2).

        Raises:
            ValueError: for a wrong type, dtype or shape.
        """
        q = float64_rows(q, COORDINATES, "q")
        states = np.concatenate([q, np.zeros_like(q)], axis=1)
        matrices = np.empty((len(q), COORDINATES, COORDINATES))
        mass_matrices(CHEETAH, np.empty(1, BODY), states, matrices)
        return matrices

    def smooth_forces(self, q: FloatArray, v: FloatArray, a: FloatArray) -> FloatArray:
        """All forces but contact and stops [b, 7]: in free flight, `M qacc` equals them (N, N m).

        Raises:
            ValueError: for a wrong type, dtype or shape, NaN or infinity.
        """
        q, v = float64_rows(q, COORDINATES, "q"), float64_rows(v, COORDINATES, "v")
        if len(q) != len(v):
            raise ValueError(f"q and v must have as many rows, not {len(q)} and {len(v)}")
        states, actions = self._rows(np.concatenate([q, v], axis=1), a)
        self._domain.check(states, actions)  # in any pose: the ground and the stops are left out
        forces = np.empty_like(q)
        smooth_forces(CHEETAH, np.empty(1, BODY), states, actions, forces)
        return forces

    def pieces(self, states: FloatArray, actions: FloatArray) -> Pieces:
        """Which spheres and stops are in contact in each substep, and how; which motors clip."""
        states, actions = self._checked(states, actions)
        signature = np.empty((len(states), SUBSTEPS), np.int64)
        unsolved = signature_rows(CHEETAH, np.empty(1, BODY), DT, states, actions, signature)
        if unsolved >= 0:
            raise self.failure(states[unsolved], actions[unsolved])
        closed = (signature | signature >> 1) & ONE_OF_EACH_SPHERE
        touches = closed.any(axis=1)
        opens = (closed[:, :-1] & ~closed[:, 1:]).any(axis=1)
        slides = (signature >> 1 & ONE_OF_EACH_SPHERE).any(axis=1)
        stops = (signature >> 2 * SPHERES).any(axis=1)
        slow = np.abs(states[:, COORDINATES:]).max(axis=1, initial=0.0) < RESTING_SPEED
        rests = touches & slow & (closed == closed[:, :1]).all(axis=1)
        beyond = clip_sides(actions)
        regime = np.select(
            [stops, opens, rests, slides, touches, beyond.any(axis=1)],
            [self.regimes.index(name) for name in self.regimes[:0:-1]],
            0,
        )
        return Pieces(regime, np.concatenate([signature, beyond], axis=1))

    def sample(self, generator: np.random.Generator, count: int) -> tuple[FloatArray, FloatArray]:
        """A quarter each: under way at random, under way bang-bang, coming to rest, in flight.

        Each state is the end of a rollout of its own, of up to 100 steps.
        """
        kind = np.arange(count) % 4
        states = self.initial_states(generator.integers(2**60, size=count))
        states[kind == 3, 1] += generator.uniform(0.3, 1.5, np.count_nonzero(kind == 3))
        longest = np.choose(kind, [100, 100, 100, 4])
        length = generator.integers(0, longest + 1)
        for step in range(100):
            going = np.flatnonzero(step < length)
            actions = generator.uniform(-1.0, 1.0, (count, self.action_size))
            actions[kind == 1] = np.sign(actions[kind == 1])
            actions[kind == 2] = 0.0
            states[going] = self.step(states[going], actions[going]).next_state
        actions = generator.uniform(-1.2, 1.2, (count, self.action_size))
        actions[kind == 2] *= generator.choice([0.05, 0.3], (np.count_nonzero(kind == 2), 1))
        return states, actions

    def draw(self, state: FloatArray) -> Drawing:
        """The capsules over the ground, which has a mark every metre; the view follows."""
        return draw_robot(ROBOT, float(state[0]), self._sphere_centres(state))

    def _sphere_centres(self, state: FloatArray) -> FloatArray:
        """Centres [16, 2] of the spheres of one state."""
        centres = np.empty((1, SPHERES, 2))
        states = np.array(state, np.float64).reshape(1, self.state_size)
        sphere_centres(CHEETAH, np.empty(1, BODY), states, centres)
        return centres.reshape(SPHERES, 2)
