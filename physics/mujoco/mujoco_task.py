"""MujocoTask: an environment made of a model, a reward and an end.

    s = (qpos, qvel, act, measures)    those of the model; measures as the task declares them
    s' = `substeps` steps of the model under one action,    r = r(s, a, s')

Actions are controls scaled to the box: -1 and 1 are the ends of the control's range; a control
without a range is the action itself. As in MuJoCo, the state holds a free joint's position and its
unit quaternion, and the network sees these numbers; Jacobians are in these coordinates
(tangent.py).

Measures are other quantities of the simulation, such as the place of a site, for networks and
rewards that need more than the coordinates. They follow from a state's coordinates, or from the
step that led there; no step depends on them, and their columns of the Jacobian are 0.

Derivatives of the dynamics are differences (derivatives.py), those of the reward are exact. A
subclass declares `mjcf` and defines the reward; everything else has a default or is derived.
"""

import threading
from abc import abstractmethod
from pathlib import Path
from typing import Any, ClassVar

import numpy as np
from numpy.typing import NDArray

from physics.drawing import Drawing
from physics.environment import (
    BoolArray,
    Environment,
    FloatArray,
    Pieces,
    clip_sides,
)
from physics.exploration import explore
from physics.mujoco import constraints
from physics.mujoco.declaration_check import refuse, refuse_measure
from physics.mujoco.derivatives import (
    Differencing,
    by_the_engine,
    by_whole_steps,
    has_transition_derivatives,
)
from physics.mujoco.engine import mujoco
from physics.mujoco.model import Model, can_be_limited, can_touch, compiled
from physics.mujoco.picture import AXES, Frame, Plane, drawing, frame_of, photograph
from physics.mujoco.remarks import remarks
from physics.mujoco.simulation import Simulation
from physics.row_checks import float64_vector

EXPLORED = 50
"""The horizon of the rollouts that an audit's states come from: a step of MuJoCo is expensive."""


class MujocoTask(Environment):
    """A model with a task."""

    mjcf: ClassVar[str | Path]
    """The model: a file, or its text."""
    substeps: ClassVar[int] = 1
    """Steps of the model in a step of the task."""
    measure: ClassVar[Any] = None
    """A static method of MuJoCo's model and data that returns the numbers [k] that a state holds
    beside its coordinates, or None."""
    measures_as_left: ClassVar[bool] = False
    """If True, measures are taken from the data as the last substep left it, with the positions of
    its last stage (as in Gymnasium's tasks); if False, after `mj_forward`, at the next state
    itself."""
    centred: ClassVar[bool] = True
    """Whether differences are centred: twice the cost of forward ones, but far more exact."""
    difference: ClassVar[float] = 1e-6
    """The width of differences, in the units of the state and of the action in the box."""
    plane: ClassVar[Plane] = "xz"
    """The plane in which states are drawn."""
    rounding: ClassVar[float] = 3e-13
    tolerance: ClassVar[float] = 1e-4

    model: ClassVar[Model]
    """The compiled model; it must not be changed."""
    _kinds: ClassVar[NDArray[np.int64]]
    """Index into `regimes` of: free, clipped, limit, contact."""
    _frame: ClassVar[Frame]
    _scratch: ClassVar[threading.local]

    def __init_subclass__(cls) -> None:
        """Compile the model and derive what follows from it.

        Raises:
            ValueError: for a model that does not compile, and for mistakes in the declaration.
        """
        super().__init_subclass__()
        if not hasattr(cls, "mjcf"):
            return
        if "mjcf" in vars(cls):
            cls.model = cls.compiled_model()
        refuse(cls)
        cls._scratch = threading.local()
        names = {
            "free": True,
            "clipped": True,
            "limit": can_be_limited(cls.model),
            "contact": can_touch(cls.model),
        }
        cls.regimes = tuple(name for name, is_there in names.items() if is_there)
        cls._kinds = np.cumsum(list(names.values())) - 1
        cls.action_size = int(cls.model.nu)
        cls.step_seconds = cls.substeps * float(cls.model.opt.timestep)
        simulation = cls._simulation_of_thread()
        simulation.load(cls._rest(), np.zeros(cls.action_size))
        mujoco.mj_forward(cls.model, simulation.data)
        refuse_measure(cls, simulation)
        cls.state_size = len(simulation.completed(cls._rest()))
        cls.noise_factors = {**cls._unmoved(), **cls.noise_factors}
        cls._frame = frame_of(cls.model, simulation.data, cls.plane)

    @classmethod
    def compiled_model(cls) -> Model:
        """Compile the model that `mjcf` is. Raises ValueError if it does not compile."""
        return compiled(cls.mjcf)

    @abstractmethod
    def rewards(
        self, states: FloatArray, actions: FloatArray, next_states: FloatArray
    ) -> FloatArray:
        """The rewards [batch] of steps, under actions within the box."""

    @abstractmethod
    def reward_gradients(
        self, states: FloatArray, actions: FloatArray, next_states: FloatArray
    ) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Their partial derivatives [batch, n], [batch, m] and [batch, n], in the arguments."""

    def ends(self, next_states: FloatArray) -> BoolArray:
        """Whether episodes end there [batch]; by default none does."""
        return np.zeros(len(next_states), np.bool_)

    def start(self, generator: np.random.Generator) -> FloatArray:
        """Draw the coordinates [nq + nv + na] of a start; by default the model's own."""
        del generator
        return self._rest()

    def initial_state(self, generator: np.random.Generator) -> FloatArray:
        """Draw one start state [n], with its measures."""
        start = self.start(generator)
        size = self.simulation.coordinates
        return self.simulation.completed(
            float64_vector(start, size, f"{self.name}: what start returns")
        )

    def step_kernel(
        self,
        states: FloatArray,
        actions: FloatArray,
        next_states: FloatArray,
        rewards: FloatArray,
        terminated: BoolArray,
    ) -> int:
        """Step every row; see `Environment.step_kernel`."""
        simulation, actions = self.simulation, np.minimum(np.maximum(actions, -1.0), 1.0)
        for row in range(len(states)):
            try:
                simulation.advance(states[row], actions[row], next_states[row])
            except mujoco.FatalError:
                return row
        rewards[:] = self.rewards(states, actions, next_states)
        terminated[:] = self.ends(next_states)
        return -1

    def differentiate_kernel(
        self,
        states: FloatArray,
        actions: FloatArray,
        next_states: FloatArray,
        rewards: FloatArray,
        terminated: BoolArray,
        *derivatives: FloatArray,
    ) -> int:
        """Step and differentiate every row; see `Environment.differentiate_kernel`."""
        unsolved = self.step_kernel(states, actions, next_states, rewards, terminated)
        if unsolved >= 0:
            return unsolved
        state_jacobians, action_jacobians, *gradients = derivatives
        within = np.abs(actions) <= 1.0
        actions = np.clip(actions, -1.0, 1.0)
        how = Differencing(self.difference, self.centred)
        for row in range(len(states)):
            state_jacobians[row], action_jacobians[row] = self.jacobians(
                states[row], actions[row], how
            )
        by_state, by_action, by_next = gradients
        by_state[:], by_action[:], by_next[:] = self.reward_gradients(states, actions, next_states)
        action_jacobians *= within[:, None]
        by_action *= within
        return -1

    def pieces(self, states: FloatArray, actions: FloatArray) -> Pieces:
        """Which contacts and limits act, substep by substep, and which actions are clipped."""
        beyond = clip_sides(actions)
        found = [
            constraints.acting(self.simulation, state, action)
            for state, action in zip(states, np.clip(actions, -1.0, 1.0), strict=True)
        ]
        kinds = np.any(beyond, axis=1).astype(np.int64)
        kinds[[each.limit for each in found]] = 2
        kinds[[each.contact for each in found]] = 3
        pieces = np.array([each.pieces for each in found], np.int64).reshape(-1, self.substeps)
        return Pieces(self._kinds[kinds], np.concatenate([pieces, beyond], axis=1))

    def sample(self, generator: np.random.Generator, count: int) -> tuple[FloatArray, FloatArray]:
        """See `Environment.sample`; the rollouts are shorter."""
        return explore(self, generator, count, min(self.horizon, EXPLORED))

    def contact_impulses(self, states: FloatArray, actions: FloatArray) -> list[FloatArray]:
        """See `Environment.contact_impulses`."""
        states, actions = self._checked(states, actions)
        axes = list(AXES[self.plane])
        return [
            np.array(
                [
                    [*place[axes], *impulse[axes]]
                    for place, impulse in constraints.impulses(self.simulation, state, action)
                ]
            ).reshape(-1, 4)
            for state, action in zip(states, np.clip(actions, -1.0, 1.0), strict=True)
        ]

    def draw(self, state: FloatArray) -> Drawing:
        """The model's geoms in its plane."""
        return drawing(self.model, self._posed(state), self.plane, self._frame)

    def photograph(
        self, state: FloatArray, width: int = 480, height: int = 320, camera: str | int = -1
    ) -> NDArray[np.uint8]:
        """A state [n] as MuJoCo's own renderer shows it, [height, width, 3].

        Args:
            state: float64 [n].
            width: in pixels.
            height: in pixels.
            camera: the name or the number of a camera of the model; -1 is MuJoCo's own view.

        Raises:
            RuntimeError: where there is no OpenGL to render with; it says what to do.
            ValueError: for a camera that the model does not have.
        """
        return photograph(self.model, self._posed(state), width, height, camera)

    def remarks(self, states: FloatArray, actions: FloatArray) -> list[str]:
        """Notes on the cost of differences and on soft contacts."""
        return remarks(self, states, actions)

    def jacobians(
        self, state: FloatArray, action: FloatArray, how: Differencing
    ) -> tuple[FloatArray, FloatArray]:
        """The Jacobians [n, n] and [n, m] of a state [n] and an action [m] within the box."""
        engines = self.measure is None and has_transition_derivatives(self.model)
        return (by_the_engine if engines else by_whole_steps)(self.simulation, state, action, how)

    @property
    def simulation(self) -> Simulation:
        """The simulation of this thread."""
        return self._simulation_of_thread()

    @classmethod
    def _simulation_of_thread(cls) -> Simulation:
        """The simulation of this thread: MuJoCo's data must not be shared."""
        found: Simulation | None = getattr(cls._scratch, "simulation", None)
        if found is None:
            found = Simulation(cls.model, cls.substeps, cls.measure, cls.measures_as_left)
            cls._scratch.simulation = found
        return found

    @classmethod
    def _rest(cls) -> FloatArray:
        """The model's own state, at rest [nq + nv + na]."""
        return np.concatenate([cls.model.qpos0, np.zeros(cls.model.nv + cls.model.na)])

    @classmethod
    def _unmoved(cls) -> dict[int, float]:
        """Noise factors of 0 but for speeds: positions hold quaternions, contacts and limits."""
        speeds = range(cls.model.nq, cls.model.nq + cls.model.nv)
        return {i: 0.0 for i in range(cls.state_size) if i not in speeds}

    def _posed(self, state: FloatArray) -> Any:
        """The data of a state, with its positions up to date."""
        simulation = self.simulation
        simulation.load(state, np.zeros(self.action_size))
        mujoco.mj_fwdPosition(self.model, simulation.data)
        return simulation.data
