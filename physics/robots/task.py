"""A robot's task: an environment made of a robot, its substeps, a reward and an end.

    s = (q, v),    q = (x, z, pitch, joint angles ...),    v their rates

with `x, z` the root's place relative to that in the description, and joints in the order of the
links. A step is `substeps` substeps under one action, each as in dynamics/substep.py.

A subclass declares `robot`, `substep_seconds`, `substeps`, `reward` and `end`, and defines where
its episodes start. Everything else is derived, including the physical parameters (parameters.py).
"""

import math
from collections.abc import Mapping
from types import MappingProxyType
from typing import Any, ClassVar, Self

import numpy as np

from physics.drawing import Drawing
from physics.environment import (
    BoolArray,
    Environment,
    FloatArray,
    IntArray,
    Pieces,
    clip_sides,
)
from physics.record import Records, dtype
from physics.robots.drawing import draw_robot
from physics.robots.dynamics.body import Body
from physics.robots.dynamics.motion import Modes, move_rows
from physics.robots.dynamics.pose import ROOT
from physics.robots.dynamics.smooth_dynamics import mass_matrices, smooth_forces
from physics.robots.dynamics.substep_derivative import Tangent
from physics.robots.end import FOREVER, End
from physics.robots.lcp.contact_mode import OPEN
from physics.robots.model import description_check
from physics.robots.model.description import Robot
from physics.robots.model.mechanism import build, sizes
from physics.robots.model.parameters import changed_mechanism, parameters_of
from physics.robots.model.spheres import end_spheres
from physics.robots.regime import REGIMES, regime_of
from physics.robots.report import (
    ContactReport,
    empty_report,
    find_sunk,
    report_rows,
    world_points,
)
from physics.robots.reward import Reward
from physics.robots.sampling import rollouts
from physics.row_checks import float64_rows

DEEPEST = 5e-3
"""How deep (m, rad) a sphere may be in the ground, or a joint in its stop; rollouts stay above."""
DECLARED = {
    "robot": Robot,
    "substep_seconds": float,
    "substeps": int,
    "reward": Reward,
    "end": End,
}
"""The declarations of a task, and their types."""


def _mistakes(task: "type[RobotTask]") -> list[str]:
    """The mistakes in a task's declaration."""
    declared = {name: getattr(task, name, None) for name in DECLARED}
    found = [
        f"{name} must be of type {DECLARED[name].__name__}, not {value!r}"
        for name, value in declared.items()
        if not isinstance(value, DECLARED[name])
    ]
    return found or description_check.mistakes(task.robot)


class RobotTask(Environment):
    """A robot with a task."""

    robot: ClassVar[Robot]
    substep_seconds: ClassVar[float]
    substeps: ClassVar[int]
    """Substeps of a step."""
    reward: ClassVar[Reward]
    end: ClassVar[End] = FOREVER

    angles = MappingProxyType({ROOT: 1})
    hidden = (0,)
    regimes = REGIMES

    mechanism: Records
    """The robot as kernels read it, [1]."""
    body_type: ClassVar[np.dtype[np.void]]
    _no_bodies: ClassVar[Records]
    _coordinates: ClassVar[int]
    _spheres: ClassVar[int]
    _motion: tuple[Records, Records, Records, float, int]
    """The first arguments of `move_rows`, up to the states."""
    _stops: ClassVar[tuple[FloatArray, FloatArray]]
    """The lower and the upper stops of the joints, in their order."""
    _no_jacobians: ClassVar[tuple[FloatArray, FloatArray]]
    _no_modes: ClassVar[Modes]
    """With room for a multiple of eight constraints, which `pieces` packs into integers."""

    def __init_subclass__(cls) -> None:
        """Derive what follows from the declaration.

        Raises:
            ValueError: with all mistakes in it.
        """
        super().__init_subclass__()
        if wrong := _mistakes(cls):
            raise ValueError("\n- ".join([f"{cls.__name__} is not a valid robot's task:", *wrong]))
        size = sizes(cls.robot)
        n, m = size["n"], size["m"]
        cls.state_size, cls.action_size = 2 * n, m
        cls.step_seconds = cls.substeps * cls.substep_seconds
        cls.noise_factors = dict.fromkeys(range(n), 0.0)  # a contact point would enter the ground
        for parameter in parameters_of(cls.robot):
            setattr(cls, parameter.name, parameter)
        cls.mechanism = build(cls.robot)
        cls.body_type = dtype(Body, **size)
        cls._no_bodies = np.empty(0, cls.body_type)
        cls._coordinates, cls._spheres = n, size["c"]
        cls._motion = (
            cls.mechanism,
            cls._no_bodies,
            np.empty(0, dtype(Tangent, **size)),
            cls.substep_seconds,
            cls.substeps,
        )
        joints = [link.joint for link in cls.robot.links if link.joint is not None]
        cls._stops = np.array([j.lower for j in joints]), np.array([j.upper for j in joints])
        cls._no_jacobians = np.empty((0, 2 * n, 2 * n)), np.empty((0, 2 * n, m))
        cls._no_modes = np.empty((0, cls.substeps, 8 * math.ceil(size["k"] / 8)), np.int8)

    def _changed(self, values: Mapping[str, Any]) -> Self:
        """A copy with these values, and a mechanism of its own."""
        other = super()._changed(values)
        other.mechanism = changed_mechanism(self.robot, other.parameters)
        other._motion = (other.mechanism, *self._motion[1:])
        return other

    def step_kernel(
        self,
        states: FloatArray,
        actions: FloatArray,
        next_states: FloatArray,
        rewards: FloatArray,
        terminated: BoolArray,
    ) -> int:
        """Step every row; see `Environment.step_kernel`."""
        unsolved = move_rows(
            *self._motion, states, actions, next_states, *self._no_jacobians, self._no_modes
        )
        if unsolved < 0:
            self.end.mark(next_states, terminated)
            self.reward.fill(self.step_seconds, states, actions, next_states, terminated, rewards)
        return unsolved

    def differentiate_kernel(
        self,
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
        jacobians = state_jacobians, action_jacobians
        gradients = reward_state_gradients, reward_action_gradients, reward_next_state_gradients
        unsolved = move_rows(
            *self._motion, states, actions, next_states, *jacobians, self._no_modes
        )
        if unsolved < 0:
            self.end.mark(next_states, terminated)
            self.reward.fill(self.step_seconds, states, actions, next_states, terminated, rewards)
            self.reward.fill_gradients(self.step_seconds, states, actions, next_states, *gradients)
        return unsolved

    def raised(self, state: FloatArray) -> FloatArray:
        """A state [2n], raised until no sphere is below the ground."""
        heights = self.sphere_centres(state[None])[0, :, 1] - self.mechanism["radius"][0]
        lowest = np.min(heights)
        state[1] += max(0.0, -lowest)
        return state

    def stopped(self, state: FloatArray) -> FloatArray:
        """A state [2n], with joints beyond their stops turned back to them."""
        joints = slice(ROOT + 1, self._coordinates)
        state[joints] = np.clip(state[joints], *self._stops)
        return state

    def outside(self, states: FloatArray) -> BoolArray:
        """Where a sphere is in the ground, or a joint beyond its stop, deeper than steps lead."""
        sunk = np.empty(len(states), np.bool_)
        find_sunk(self.mechanism, self._no_bodies, states, DEEPEST, sunk)
        return sunk | super().outside(states)

    def check_inside(self, states: FloatArray, actions: FloatArray) -> None:
        """Check that no sphere is in the ground, no joint beyond its stop, and all is finite."""
        super().check_inside(states, actions)
        sunk = np.empty(len(states), np.bool_)
        if find_sunk(self.mechanism, self._no_bodies, states, DEEPEST, sunk):
            raise self._domain.error(
                states,
                sunk,
                "nothing below the ground and no joint beyond its stop by 5 mm or mrad",
            )

    def contact_report(self, states: FloatArray, actions: FloatArray) -> ContactReport:
        """The contacts of one step, substep by substep.

        Raises:
            ValueError, UnsolvedStepError: as `step`.
        """
        states, actions = self._checked(states, actions)
        report = empty_report(self.mechanism, len(states), self.substeps)
        unsolved = report_rows(
            self.mechanism, self._body(), self.substep_seconds, states, actions, report
        )
        if unsolved >= 0:
            raise self.failure(states[unsolved], actions[unsolved])
        return report

    def contact_impulses(self, states: FloatArray, actions: FloatArray) -> list[FloatArray]:
        """One impulse for each sphere in contact, summed over the step.

        Its place is that of the sphere's lowest point after the step.

        Raises:
            ValueError, UnsolvedStepError: as `step`.
        """
        report = self.contact_report(states, actions)
        lowest = self.sphere_centres(self.step(states, actions).next_state)
        lowest[..., 1] -= self.mechanism["radius"][0]
        impulses = [report.tangential_impulse.sum(axis=1), report.normal_impulse.sum(axis=1)]
        arrows = np.concatenate([lowest, np.stack(impulses, axis=-1)], axis=-1)
        return [row[given] for row, given in zip(arrows, arrows[..., 3] > 0.0, strict=True)]

    def mass_matrix(self, q: FloatArray) -> FloatArray:
        """M(q) [b, n, n] for coordinates [b, n], armature included (kg, kg m, kg m^2).

        Raises:
            ValueError: for a wrong type, dtype or shape.
        """
        n = self._coordinates
        q = float64_rows(q, n, "q")
        states = np.concatenate([q, np.zeros_like(q)], axis=1)
        matrices = np.empty((len(q), n, n))
        mass_matrices(self.mechanism, self._body(), states, matrices)
        return matrices

    def smooth_forces(self, q: FloatArray, v: FloatArray, a: FloatArray) -> FloatArray:
        """All forces but contact and stops [b, n]: in free flight, `M qacc` equals them (N, N m).

        Raises:
            ValueError: for a wrong type, dtype or shape, NaN or infinity.
        """
        q, v = float64_rows(q, self._coordinates, "q"), float64_rows(v, self._coordinates, "v")
        if len(q) != len(v):
            raise ValueError(f"q and v must have equal numbers of rows, not {len(q)} and {len(v)}")
        states, actions = self._rows(np.concatenate([q, v], axis=1), a)
        self._domain.check(states, actions)  # any pose is allowed: ground and stops are ignored
        forces = np.empty_like(q)
        smooth_forces(self.mechanism, self._body(), states, actions, forces)
        return forces

    def pieces(self, states: FloatArray, actions: FloatArray) -> Pieces:
        """The mode of every constraint in every substep, which motors clip, whether it ends."""
        states, actions = self._checked(states, actions)
        modes = np.full((len(states), *self._no_modes.shape[1:]), OPEN, np.int8)
        next_states, ended = np.empty_like(states), np.empty(len(states), np.bool_)
        unsolved = move_rows(
            *self._motion, states, actions, next_states, *self._no_jacobians, modes
        )
        if unsolved >= 0:
            raise self.failure(states[unsolved], actions[unsolved])
        self.end.mark(next_states, ended)
        beyond = clip_sides(actions)
        spheres, stops = np.split(modes, [self._spheres], axis=2)
        packed = modes.reshape(len(modes), -1).view(np.int64)
        return Pieces(
            regime_of(states, spheres, stops, beyond),
            np.concatenate([packed, beyond, ended[:, None]], axis=1),
        )

    def sample(self, generator: np.random.Generator, count: int) -> tuple[FloatArray, FloatArray]:
        """States and actions from rollouts of several kinds."""
        return rollouts(self, generator, count)

    def set_down(self, generator: np.random.Generator, states: FloatArray) -> FloatArray:
        """States [batch, 2n], each robot bent a little, put on the ground and nearly stopped.

        It is for samples of robots that fall: lying robots have more contacts than are needed to
        hold them, and are at kinks.
        """
        n = self._coordinates
        states = np.concatenate([states[:, :n], np.zeros((len(states), n))], axis=1)
        lower, upper = np.clip(self._stops, -0.3, 0.3)
        states[:, ROOT + 1 : n] = generator.uniform(lower, upper, (len(states), len(lower)))
        heights = self.sphere_centres(states)[..., 1] - self.mechanism["radius"][0]
        states[:, 1] -= heights.min(axis=1)
        states[:, n:] += generator.uniform(-0.05, 0.05, (len(states), n))
        return states

    def draw(self, state: FloatArray) -> Drawing:
        """The capsules over the ground, which has a mark every metre; the view follows."""
        ends = end_spheres(self.robot)
        links = np.array([sphere.link for sphere in ends])
        points = np.array([sphere.centre for sphere in ends])
        states = np.array(state, np.float64).reshape(1, self.state_size)
        return draw_robot(self.robot, float(state[0]), self._world(states, links, points)[0])

    def sphere_centres(self, states: FloatArray) -> FloatArray:
        """Centres [batch, c, 2] of the spheres that can touch the ground."""
        return self._world(states, self.mechanism["sphere_link"][0], self.mechanism["sphere"][0])

    def _world(self, states: FloatArray, links: IntArray, points: FloatArray) -> FloatArray:
        """Places [batch, p, 2] of points [p, 2] of links [p]."""
        places = np.empty((len(states), len(links), 2))
        world_points(self.mechanism, self._body(), states, links, points, places)
        return places

    def _body(self) -> Records:
        """Scratch for a kernel, [1]."""
        return np.empty(1, self.body_type)
