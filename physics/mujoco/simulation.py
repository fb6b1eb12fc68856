"""Simulation: the steps of a model, each from a state alone.

MuJoCo's solver starts from its last result (`qacc_warmstart`), which is not part of the state. Here
each step starts from 0, so that the next state is a function of state and action. Within the
solver's tolerance, the result differs by a few 1e-13 from that of the other start.
"""

from collections.abc import Callable
from typing import Any

import numpy as np

from physics.environment import FloatArray
from physics.mujoco.engine import mujoco
from physics.mujoco.model import STATE, actuators_of
from physics.mujoco.tangent import quaternions_of

Measure = Callable[..., FloatArray]
"""A function of MuJoCo's model and data: what a state holds beside its coordinates [k]."""


class Simulation:
    """A model, and the MjData in which its steps are computed.

    Attributes:
        model, data: MuJoCo's.
        coordinates: nq + nv + na, how many of a state's numbers a step depends on.
        substeps: steps of the model in a step.
    """

    def __init__(
        self, model: Any, substeps: int, measure: Measure | None, measures_as_left: bool
    ) -> None:
        """Allocate the data of a model."""
        self.model = model
        self.data = mujoco.MjData(model)
        self.coordinates = int(mujoco.mj_stateSize(model, STATE))
        self.substeps = substeps
        self._measure = measure
        self._measures_as_left = measures_as_left
        self._centre, self._half = actuators_of(model)
        self._has_quaternions = bool(quaternions_of(model))

    def load(self, state: FloatArray, action: FloatArray) -> None:
        """Set the data to a state [n] and an action [m] within the box."""
        mujoco.mj_setState(self.model, self.data, state[: self.coordinates], STATE)
        if self._has_quaternions:
            mujoco.mj_normalizeQuat(self.model, self.data.qpos)
        self.data.qacc_warmstart[:] = 0.0
        self.data.ctrl[:] = self._centre + self._half * action

    def advance(self, state: FloatArray, action: FloatArray, following: FloatArray) -> None:
        """Advance by one step, and fill the next state [n]."""
        self.load(state, action)
        mujoco.mj_step(self.model, self.data, nstep=self.substeps)
        self.read(following)

    def read(self, state: FloatArray) -> None:
        """Fill the state [n] that a step has led to."""
        mujoco.mj_getState(self.model, self.data, state[: self.coordinates], STATE)
        if self._measure is not None:
            if not self._measures_as_left:
                mujoco.mj_forward(self.model, self.data)
            state[self.coordinates :] = self._measure(self.model, self.data)

    def completed(self, coordinates: FloatArray) -> FloatArray:
        """The state [n] of coordinates [nq + nv + na], under no action."""
        self.load(coordinates, np.zeros(self.model.nu))
        mujoco.mj_forward(self.model, self.data)
        if self._measure is None:
            return coordinates
        return np.concatenate([coordinates, np.asarray(self._measure(self.model, self.data))])

    def moved(self, state: FloatArray, direction: int, by: float) -> FloatArray:
        """A state [n] moved along one of the 2 nv + na directions of the tangent space."""
        nq, nv = self.model.nq, self.model.nv
        result = state.copy()
        if direction >= nv:
            result[nq + direction - nv] += by
            return result
        along = np.zeros(nv)
        along[direction] = 1.0
        mujoco.mj_integratePos(self.model, result[:nq], along, by)
        return result
