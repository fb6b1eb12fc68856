"""Where episodes end."""

from math import inf, nan

import numpy as np
import pytest

from physics.environment import BoolArray
from physics.robots.end import FOREVER, End, Health


def ended(end: End, *states: list[float]) -> list[bool]:
    terminated: BoolArray = np.ones(len(states), np.bool_)
    end.mark(np.array(states), terminated)
    result: list[bool] = terminated.tolist()
    return result


def test_health_is_an_open_box() -> None:
    health = Health({1: (0.7, inf), 2: (-0.2, 0.2)})
    assert ended(health, [9.0, 0.71, 0.19], [9.0, 0.7, 0.0], [9.0, 1.0, 0.2], [9.0, 1.0, -0.3]) == [
        False,
        True,
        True,
        True,
    ]


def test_what_is_no_number_is_not_healthy() -> None:
    assert ended(Health({0: (-1.0, 1.0)}), [nan]) == [True]


def test_forever() -> None:
    assert ended(FOREVER, [1e9, -1e9]) == [False]


@pytest.mark.parametrize("bounds", [(1.0, 1.0), (2.0, 1.0), (nan, 1.0)])
def test_an_empty_box_is_refused(bounds: tuple[float, float]) -> None:
    with pytest.raises(ValueError, match=r"coordinate 3 must lie in \(low, high\), low < high"):
        Health({3: bounds})
