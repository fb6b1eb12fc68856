"""Unsolved steps: what to do when one row of a batch has no solution, or none that is finite.

So it is for a state outside the task's domain, where a neighbour of a trajectory may lie.

A simulator refuses a whole batch for one such row, but a run must not feel its neighbours: the rows
to blame are found by halving the batch, and step from states known to be good instead.
"""

from collections.abc import Callable
from typing import TypeVar

import numpy as np

from physics.environment import (
    BoolArray,
    DomainError,
    FloatArray,
    NotFiniteError,
    UnsolvedStepError,
)

Result = TypeVar("Result")

REFUSALS = (UnsolvedStepError, DomainError, NotFiniteError)


def call_with_substitutes(
    call: Callable[[FloatArray, FloatArray], Result],
    states: FloatArray,
    actions: FloatArray,
    good: Callable[[], tuple[FloatArray, FloatArray]],
) -> tuple[Result, BoolArray]:
    """`call(states, actions)`, with rows of `good()` for refused ones, and which those are.

    Raises:
        UnsolvedStepError, DomainError, NotFiniteError: if the good rows are refused too.
    """
    try:
        return call(states, actions), np.zeros(len(states), np.bool_)
    except REFUSALS:
        is_unsolved = unsolved_rows(call, states, actions)
    chosen = is_unsolved[:, None]
    good_states, good_actions = good()
    result = call(np.where(chosen, good_states, states), np.where(chosen, good_actions, actions))
    return result, is_unsolved


def unsolved_rows(
    call: Callable[[FloatArray, FloatArray], object], states: FloatArray, actions: FloatArray
) -> BoolArray:
    """Which rows of a batch are refused."""
    try:
        call(states, actions)
    except REFUSALS:
        if len(states) == 1:
            return np.ones(1, np.bool_)
        half = len(states) // 2
        parts = (slice(None, half), slice(half, None))
        return np.concatenate([unsolved_rows(call, states[p], actions[p]) for p in parts])
    return np.zeros(len(states), np.bool_)
