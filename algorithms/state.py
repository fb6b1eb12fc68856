"""State: all values on which a run's next bits depend, as plain arrays by name.

All randomness is drawn from generators named by (seed, purpose, index), so the state holds counters
and no generator. A state of many parts puts each part's name before the names in it: "actor/theta".
"""

from collections.abc import Mapping
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

State = Mapping[str, NDArray[Any]]


class Saved(NamedTuple):
    """A saved run."""

    state: State
    """All values on which the next bits depend, except the journal."""
    journal: State
    """Arrays with a row for each timestep, `[t, ...]`; empty for learners without a journal."""


def within(name: str, state: State) -> dict[str, NDArray[Any]]:
    """A part's state, under the part's name."""
    return {f"{name}/{key}": array for key, array in state.items()}


def part(state: State, name: str) -> State:
    """The state of one part, the inverse of `within`."""
    prefix = f"{name}/"
    return {
        key.removeprefix(prefix): array for key, array in state.items() if key.startswith(prefix)
    }


def fill(target: NDArray[Any], array: NDArray[Any]) -> None:
    """Overwrite `target` with an array of its own shape and type.

    Raises:
        ValueError: if they differ, since the state is then of another learner.
    """
    if target.shape != array.shape or target.dtype != array.dtype:
        raise ValueError(
            f"a state of {target.dtype} {list(target.shape)} was expected, "
            f"not {array.dtype} {list(array.shape)}: it is of other settings or other code"
        )
    np.copyto(target, array)
