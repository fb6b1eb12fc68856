"""Row checks: whether arrays are what kernels take, and whether they are finite."""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from physics.kernels.compiled import compiled

FloatArray = NDArray[np.float64]

FLOAT64 = np.dtype(np.float64)


def float64_rows(array: Any, width: int, what: str) -> FloatArray:
    """`array` as float64 [batch, width], contiguous and writeable, as kernels require.

    Nearly every call returns in the first line: a learner calls this for each step.

    Raises:
        ValueError: for a wrong type, dtype or shape.
    """
    if (
        type(array) is np.ndarray
        and array.dtype is FLOAT64
        and array.ndim == 2
        and array.shape[1] == width
        and array.flags.carray
    ):
        return array
    if not isinstance(array, np.ndarray):
        raise ValueError(
            f"{what} must be a numpy array, float64 [batch, {width}], not {type(array).__name__}"
        )
    if array.dtype != FLOAT64 or array.ndim != 2 or array.shape[1] != width:
        raise ValueError(
            f"{what} must be float64 [batch, {width}], not {array.dtype} {list(array.shape)}"
        )
    # Another layout, or a read-only array, would compile the kernels a second time.
    return np.array(array, FLOAT64, order="C")


def float64_vector(array: Any, width: int, what: str) -> FloatArray:
    """`array`, if it is float64 [width].

    Raises:
        ValueError: if it is not.
    """
    if not isinstance(array, np.ndarray):
        raise ValueError(
            f"{what} must be a numpy array, float64 [{width}], not {type(array).__name__}"
        )
    if array.dtype != FLOAT64 or array.shape != (width,):
        raise ValueError(f"{what} must be float64 [{width}], not {array.dtype} {list(array.shape)}")
    return array


@compiled
def are_inside(
    states: FloatArray, actions: FloatArray, lowest: FloatArray, highest: FloatArray
) -> bool:
    """Whether states [batch, n] lie between two states [n] and all actions are finite.

    The two states must be finite: then NaN and infinity lie outside.
    """
    inside = 0
    for row in range(states.shape[0]):
        for i in range(states.shape[1]):
            inside += (states[row, i] >= lowest[i]) & (states[row, i] <= highest[i])
    return inside == states.size and is_finite(actions)


@compiled
def is_finite(array: FloatArray) -> bool:
    """Whether there is no NaN and no infinity in a contiguous array of any shape.

    It counts instead of stopping at the first, so that the compiler can vectorise it.
    """
    finite, numbers = 0, array.reshape(-1)
    for i in range(numbers.size):
        finite += np.isfinite(numbers[i])
    return finite == numbers.size


@compiled
def are_finite(one: FloatArray, other: FloatArray) -> bool:
    """Whether both arrays are finite."""
    return is_finite(one) and is_finite(other)


@compiled
def is_finite_linearization(
    next_states: FloatArray,
    rewards: FloatArray,
    state_jacobians: FloatArray,
    action_jacobians: FloatArray,
    reward_state_gradients: FloatArray,
    reward_action_gradients: FloatArray,
    reward_next_state_gradients: FloatArray,
) -> bool:
    """Whether all numbers of a linearization are finite, in one call."""
    return (
        are_finite(next_states, rewards)
        and are_finite(state_jacobians, action_jacobians)
        and are_finite(reward_state_gradients, reward_action_gradients)
        and is_finite(reward_next_state_gradients)
    )
