"""Start states given by `reset(options={"state": ...})`, checked before anything changes."""

from collections.abc import Collection, Mapping
from typing import Any

import numpy as np

from physics.environment import Environment, FloatArray, UnsolvedStepError


def checked_options(options: Mapping[str, Any] | None, known: Collection[str]) -> dict[str, Any]:
    """The options of a reset.

    Raises:
        ValueError: for options that `known` does not name.
    """
    given = dict(options or {})
    unknown = [repr(name) for name in given if name not in known]
    if unknown:
        raise ValueError(
            f"unknown reset options: {', '.join(unknown)} (known: {', '.join(sorted(known))})"
        )
    return given


def checked_states(task: Environment, asked: Any, rows: int | None = None) -> FloatArray:
    """The start states in `options["state"]`.

    Args:
        task: the task of the states.
        asked: a state [n]; where `rows` are given, also one for each of them [rows, n].
        rows: the number of environments that run side by side; None for a single one.

    Returns:
        States [rows, n], or [1, n].

    Raises:
        ValueError: for another shape, for values that are not numbers, for NaN and infinity, and
            for a state outside the task's domain.
    """
    states = _as_numbers(task, asked)
    shapes = [(task.state_size,)] + ([] if rows is None else [(rows, task.state_size)])
    if states.shape not in shapes:
        raise ValueError(
            f"options['state'] must have shape {' or '.join(map(str, shapes))}, not {states.shape}"
        )
    return np.array(np.broadcast_to(states, (rows or 1, task.state_size)))


def refuse_impossible(task: Environment, states: FloatArray) -> None:
    """Refuse states [batch, n] from which the task has no step, or beyond its bounds.

    Raises:
        ValueError: naming the state, and the coordinates that are out of bounds.
    """
    broken = states[~np.isfinite(states).all(axis=1)]
    if len(broken):
        raise ValueError(f"options['state'] must be finite, not {broken[0].tolist()}")
    mistakes = [
        f"coordinate {i} must lie in [{low}, {high}], not be {outside[0]}"
        for i, (low, high) in task.bounds.items()
        if len(outside := states[(states[:, i] < low) | (states[:, i] > high), i])
    ]
    if mistakes:
        raise ValueError(f"options['state'] is no state of {task.name}: {'; '.join(mistakes)}")
    try:
        task.step(states, np.zeros((len(states), task.action_size)))
    except (ValueError, UnsolvedStepError) as refusal:
        raise ValueError(f"options['state'] is no state of {task.name}: {refusal}") from refusal


def _as_numbers(task: Environment, asked: Any) -> FloatArray:
    try:
        return np.array(asked, np.float64)
    except (TypeError, ValueError) as refusal:
        raise ValueError(
            f"options['state'] must be {task.state_size} numbers, not {asked!r}"
        ) from refusal
