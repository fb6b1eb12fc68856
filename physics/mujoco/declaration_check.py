"""Declaration check: checks what a task of a model declares."""

from collections.abc import Iterator
from typing import TYPE_CHECKING, Any

import numpy as np

from physics.mujoco.picture import AXES
from physics.mujoco.simulation import Simulation
from physics.task_check import is_number, is_whole

if TYPE_CHECKING:
    from physics.mujoco.mujoco_task import MujocoTask


def refuse(task: "type[MujocoTask]") -> None:
    """Raise ValueError with all mistakes in a task's constants."""
    mistakes = list(_mistakes(task))
    if mistakes:
        raise ValueError(f"{name_of(task)}: {'; '.join(mistakes)}")


def refuse_measure(task: "type[MujocoTask]", simulation: Simulation) -> None:
    """Raise ValueError unless `measure` returns a valid array for the model at rest."""
    if task.measure is None:
        return
    try:
        found = task.measure(simulation.model, simulation.data)
    except Exception as error:
        raise ValueError(
            f"{name_of(task)}: measure raised {type(error).__name__}: {error}"
        ) from error
    if not isinstance(found, np.ndarray) or found.dtype != np.float64 or found.ndim != 1:
        raise ValueError(
            f"{name_of(task)}: measure must return float64 [k], not {described(found)}"
        )


def name_of(task: "type[MujocoTask]") -> str:
    """The name of a task in error messages."""
    return str(getattr(task, "name", task.__name__))


def described(found: Any) -> str:
    """A description of a wrong result of a function."""
    if isinstance(found, np.ndarray):
        return f"an array {list(found.shape)} of {found.dtype}"
    return f"{type(found).__name__} {found!r}"


def _mistakes(task: "type[MujocoTask]") -> Iterator[str]:
    if not is_whole(task.substeps):
        yield f"substeps must be an integer from 1 on, not {task.substeps!r}"
    if task.plane not in AXES:
        yield f"plane must be one of {', '.join(map(repr, AXES))}, not {task.plane!r}"
    if not is_number(task.difference) or task.difference <= 0:
        yield f"difference must be a number above 0, not {task.difference!r}"
