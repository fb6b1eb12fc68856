"""An update's bits do not depend on where its arrays lie in memory.

The compiler may reorder sums, and may choose between a vectorised loop and a plain one by how far
apart two arrays are as it runs.
"""

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from algorithms.actor_critic import ddpg_update, sac_update
from algorithms.actor_critic.sac_update import Networks, Shapes
from algorithms.matching.losses import Matching, matching_of
from algorithms.networks.network import Shape
from algorithms.networks.optimizer import learned
from physics.randomness import generator
from tests.algorithms.plain import GAMMA, STORED, TAU, Setting, not_small, setting

UPDATES, ROWS = 3, 24
Place = Callable[[NDArray[Any]], NDArray[Any]]
UNITS = (8, 12)  # few: as near to one another as arrays of a real network can come


def placed(parts: Any, place: Place) -> Any:
    """A named tuple, or a tuple of them, with every array moved."""
    if isinstance(parts, np.ndarray):
        return place(parts)
    if isinstance(parts, tuple) and parts and hasattr(parts, "_make"):
        return parts._make(placed(part, place) for part in parts)
    return tuple(placed(part, place) for part in parts) if isinstance(parts, tuple) else parts


def scattered(seed: int) -> Place:
    """Arrays in one arena, in the order they come, with small gaps that are drawn."""
    random = np.random.default_rng(seed)
    arena, used = np.zeros(4_000_000, np.uint8), 0

    def place(array: NDArray[Any]) -> NDArray[Any]:
        nonlocal used
        start = used + int(random.integers(0, 16)) * array.itemsize
        start += -start % array.itemsize
        used = start + array.nbytes
        moved = arena[start:used].view(array.dtype).reshape(array.shape)
        moved[:] = array
        return moved

    return place


def ddpg(where: Setting, matching: Matching, place: Place) -> list[NDArray[Any]]:
    inputs, m = where.task.feature_size, where.task.action_size
    shapes = Shape(inputs, UNITS, m), Shape(inputs + m, UNITS, 1)
    random = generator(5, "placement")
    actor, critic = (placed(learned(not_small(shape, random)), place) for shape in shapes)
    rates = ddpg_update.Rates(np.float32(GAMMA), np.float32(TAU), 1e-3, 1e-3, np.float32(1e-2))
    report = placed(ddpg_update.empty_report(UPDATES), place)
    ddpg_update.update(
        actor, critic, 0, placed(where.memory, place), rows(), placed(where.coordinates, place),
        placed(where.scaling, place), rates, matching, shapes, report,
    )  # fmt: skip
    return [array.copy() for each in (actor, critic, report) for array in each]


def sac(where: Setting, matching: Matching, place: Place) -> list[NDArray[Any]]:
    inputs, m = where.task.feature_size, where.task.action_size
    shapes = Shapes(
        Shape(inputs, UNITS, 2 * m), Shape(inputs, UNITS, 1), Shape(inputs + m, UNITS, 1)
    )
    random = generator(5, "placement")
    policy, value, first, second = (
        learned(not_small(shape, random)) for shape in (*shapes, shapes.critic)
    )
    networks = placed(Networks(policy, value, (first, second)), place)
    rates = sac_update.Rates(np.float32(GAMMA), np.float32(TAU), np.float32(5), 1e-3)
    report = placed(sac_update.empty_report(UPDATES), place)
    noise = random.standard_normal((UPDATES, ROWS, m), np.float32)
    sac_update.update(
        networks, 0, placed(where.memory, place), rows(), place(noise),
        placed(where.coordinates, place), placed(where.scaling, place), rates, matching, shapes,
        report,
    )  # fmt: skip
    pieces = (networks.policy, networks.value, *networks.critics, report)
    return [array.copy() for each in pieces for array in each]


def rows() -> NDArray[np.int64]:
    return generator(5, "rows").integers(STORED, size=(UPDATES, ROWS))


@pytest.mark.parametrize("weights", [(0.0, 0.0), (0.7, 0.3)])
@pytest.mark.parametrize("by_cosine", [False, True])
@pytest.mark.parametrize("run", [ddpg, sac])
def test_bits_do_not_depend_on_where_arrays_lie(
    run: Callable[[Setting, Matching, Place], list[NDArray[Any]]],
    by_cosine: bool,
    weights: tuple[float, float],
) -> None:
    where, matching = setting("Acrobot"), matching_of(weights, by_cosine=by_cosine)
    apart = run(where, matching, np.copy)
    for seed in range(40):
        for own, other in zip(run(where, matching, scattered(seed)), apart, strict=True):
            np.testing.assert_array_equal(own, other, strict=True)
