"""Task: a model and functions make a task, without a class."""

from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any, Literal

import numpy as np

from physics.environment import FloatArray
from physics.mujoco.model import coordinates_of, unlimited_hinges
from physics.mujoco.mujoco_task import MujocoTask
from physics.mujoco.numpy_functions import NumpyMujocoTask
from physics.mujoco.picture import Plane
from physics.mujoco.simulation import Measure
from physics.mujoco.torch_functions import TorchMujocoTask

Coordinate = int | str
"""A coordinate of a state, or the name of a joint for its position."""


def task(
    model: str | Path,
    reward: Callable[[Any, Any, Any], Any],
    *,
    name: str,
    horizon: int,
    max_reward: float,
    version: int = 1,
    substeps: int = 1,
    terminated: Callable[[Any], Any] | None = None,
    start: Callable[[np.random.Generator], FloatArray] | None = None,
    measure: Measure | None = None,
    written_in: Literal["torch", "numpy"] = "torch",
    reward_is_differentiable: bool = True,
    angles: Mapping[Coordinate, int] | None = None,
    hidden: Sequence[Coordinate] = (),
    centred: bool = True,
    difference: float = 1e-6,
    plane: Plane = "xz",
) -> type[MujocoTask]:
    """Make a task of a MuJoCo model.

    The task's state is (qpos, qvel, act, measures). The function returns a class like one that you
    would write yourself: call it to make the task, or name it as a package's entry point.

    Args:
        model: an MJCF file, or its text.
        reward: the reward of a step, as a function of state [n], action [m] within the box, and
            next state [n].
        name: the name of the task.
        horizon: steps after which an episode is truncated.
        max_reward: the `max(r)` of the normalised return.
        version: to be raised whenever the task's numbers change, including those of the model.
        substeps: steps of the model in a step of the task.
        terminated: whether the episode ends, as a function of the next state [n]. None: it never
            does.
        start: draws the start coordinates (qpos, qvel, act) from a generator. None: those of the
            model.
        measure: a function of MuJoCo's model and data that returns further numbers [k] of a state.
        written_in: the library of the arrays in `reward` and `terminated`. torch functions are
            differentiated exactly, numpy functions by differences.
        reward_is_differentiable: if False, the reward is piecewise constant.
        angles: coordinates of which networks see cosine and sine, and their multiplicity. None: the
            hinges without a range.
        hidden: coordinates that no network sees.
        centred: whether differences are centred or forward.
        difference: the width of differences.
        plane: the plane in which states are drawn.

    Raises:
        ValueError: for a model that does not compile, with file and line, and for mistakes in the
            arguments; making the task raises it for mistakes in the functions.
    """
    bases = {"torch": TorchMujocoTask, "numpy": NumpyMujocoTask}
    if written_in not in bases:
        raise ValueError(f"{name}: written_in must be 'torch' or 'numpy', not {written_in!r}")
    declared: dict[str, Any] = {
        "__doc__": f"The task {name} of {_shown(model)}.",
        "mjcf": model,
        "reward": staticmethod(reward),
        "name": name,
        "horizon": horizon,
        "max_reward": max_reward,
        "version": version,
        "substeps": substeps,
        "reward_is_differentiable": reward_is_differentiable,
        "centred": centred,
        "difference": difference,
        "plane": plane,
        "measure": None if measure is None else staticmethod(measure),
    }
    if terminated is not None:
        declared["terminated"] = staticmethod(terminated)
    if start is not None:
        declared["start"] = lambda self, generator: start(generator)  # noqa: ARG005
    made: type[MujocoTask] = type(str(name), (bases[written_in],), declared)
    made.hidden = tuple(_place(made, each) for each in hidden)
    made.angles = (
        dict.fromkeys(sorted(unlimited_hinges(made.model) - set(made.hidden)), 1)
        if angles is None
        else {_place(made, each): multiplicity for each, multiplicity in angles.items()}
    )
    return made


def _place(made: type[MujocoTask], coordinate: Coordinate) -> int:
    """The place of a coordinate in the state. Raises ValueError for an unknown joint."""
    if not isinstance(coordinate, str):
        return coordinate
    places = coordinates_of(made.model)
    if coordinate not in places:
        raise ValueError(
            f"{made.name}: no joint {coordinate!r} of one coordinate (there are: "
            f"{', '.join(places) or 'none with a name'})"
        )
    return places[coordinate]


def _shown(model: str | Path) -> str:
    return "an MJCF text" if str(model).lstrip().startswith("<") else str(model)
