"""Cadence: often enough, and not at too great a cost."""

import pytest

from workers.cadence import Cadence


class Clock:
    def __init__(self) -> None:
        self.now = 0.0

    def __call__(self) -> float:
        return self.now


@pytest.mark.parametrize(
    ("cost", "wait"), [(0.0, 5.0), (0.1, 5.0), (0.2, 10.0), (1.2, 60.0), (30.0, 60.0)]
)
def test_waits_by_what_the_last_one_took(cost: float, wait: float) -> None:
    clock = Clock()
    cadence = Cadence(clock)
    clock.now = 100.0
    cadence.took(cost)
    due = {}
    for seconds in (0.0, wait - 0.01, wait):
        clock.now = 100.0 + seconds
        due[seconds] = cadence.is_due
    assert due == {0.0: False, wait - 0.01: False, wait: True}
