"""Noise: it disturbs a task's steps and observations; its two parameters exist in every task.

    s~ = clip(s + process_noise c eps, bounds)    the state from which a step is taken
    o  = s + observation_noise eta                the coordinates from which features are computed

with eps and eta normal [n], of mean 0 and standard deviation 1, and c the task's `noise_factors`.

Both are drawn by seed and step. The seed is that of the episode's stream of noise. So a state holds
its place in the noise, two whole numbers (stream, step): with noise, too, a step is a pure function
of state and action, and a row's noise does not depend on its neighbours.
"""

from collections.abc import Mapping
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from physics.parameter import Parameter
from physics.randomness import generator

FloatArray = NDArray[np.float64]

PROCESS, OBSERVATION = "process_noise", "observation_noise"
PARAMETERS = (
    Parameter(
        0.0,
        "1",
        least=0.0,
        greatest=1e3,
        meaning="deviation of what moves each coordinate before a step, in its unit",
        name=PROCESS,
        of_every_task=True,
    ),
    Parameter(
        0.0,
        "1",
        least=0.0,
        greatest=1e3,
        meaning="deviation of each coordinate as it is observed, in its unit",
        name=OBSERVATION,
        of_every_task=True,
    ),
)

PLACE = 2
"""Coordinates of a place in the noise."""
STREAMS = 2**24
"""A float32 holds every number up to this one."""
_BLOCK = 64


def is_noisy(values: Mapping[str, float]) -> bool:
    """Whether a task with these values of parameters has noise."""
    return any(values.get(parameter.name, parameter.default) for parameter in PARAMETERS)


def first_place(generator: np.random.Generator) -> FloatArray:
    """Draw the place in the noise where an episode begins [2]: a stream, at its first step."""
    return np.array([generator.integers(STREAMS), 0], np.float64)


def next_places(places: FloatArray) -> FloatArray:
    """The places [batch, 2] after a step: whole numbers, whose derivative is 0."""
    following: FloatArray = np.rint(places)
    following[:, 1] += 1.0
    return following


def normal(purpose: str, places: FloatArray, size: int) -> FloatArray:
    """Normal numbers [..., size] of mean 0 and deviation 1, a row for each place [..., 2].

    Raises:
        ValueError: for places below 0.
    """
    numbers = np.empty((*places.shape[:-1], size))
    rows = numbers.reshape(-1, size)
    whole = np.rint(places).astype(np.int64).reshape(-1, PLACE)
    for row, (stream, step) in enumerate(whole.tolist()):
        rows[row] = _block(purpose, stream, step // _BLOCK, size)[step % _BLOCK]
    return numbers


@lru_cache(maxsize=1024)
def _block(purpose: str, stream: int, block: int, size: int) -> FloatArray:
    """The numbers [steps, size] of some steps of a stream, drawn together for speed."""
    numbers = generator(stream, purpose, block).standard_normal((_BLOCK, size))
    numbers.flags.writeable = False
    return numbers
