"""Cadence: often enough, and not at too great a cost."""

from collections.abc import Callable

import pytest
from hypothesis import given
from hypothesis import strategies as st

from workers.training import cadence
from workers.training.cadence import Cadence


class Clock:
    def __init__(self) -> None:
        self.now = 0.0

    def __call__(self) -> float:
        return self.now


def spacings(cost: Callable[[int], float], seconds: float) -> tuple[list[float], float]:
    """Work between the checkpoints of a worker that looks every quarter second, and their share."""
    clock = Clock()
    rhythm = Cadence(clock)
    waited, spent, last = [], 0.0, 0.0
    while clock.now < seconds:
        clock.now += 0.25
        if rhythm.is_due:
            waited.append(clock.now - last)
            spent += cost(len(waited))
            clock.now += cost(len(waited))
            rhythm.took(cost(len(waited)))
            last = clock.now
    return waited, spent / clock.now


@pytest.mark.parametrize(
    ("cost", "wait"), [(0.0, 5.0), (0.0625, 5.0), (0.25, 12.5), (1.0, 50.0), (30.0, 60.0)]
)
def test_waits_by_what_one_takes(cost: float, wait: float) -> None:
    waited, _ = spacings(lambda _: cost, 3600.0)
    assert waited[0] == cadence.SHORTEST_SECONDS
    assert sum(waited[2:]) / len(waited[2:]) == pytest.approx(wait, abs=0.75)


def test_a_first_one_that_was_slow_is_made_up_for() -> None:
    waited, share = spacings(lambda count: 1.0 if count == 1 else 0.05, 120.0)
    assert waited[1] == pytest.approx(cadence.LONGEST_SECONDS, abs=0.25)
    assert share <= cadence.SHARE


@given(st.lists(st.floats(0.0, 1.0), min_size=1, max_size=8))
def test_no_more_than_a_minute_apart_and_a_small_share(costs: list[float]) -> None:
    waited, share = spacings(lambda count: costs[count % len(costs)], 1200.0)
    assert min(waited) >= cadence.SHORTEST_SECONDS
    assert max(waited) <= cadence.LONGEST_SECONDS + 0.25
    a_surprise = max(costs) / 1200.0  # one that takes longer than any before
    assert share <= cadence.SHARE + a_surprise


def test_where_both_limits_cannot_hold_work_is_not_lost() -> None:
    waited, share = spacings(lambda _: 10.0, 3600.0)
    assert max(waited) <= cadence.LONGEST_SECONDS + 0.25
    assert share > cadence.SHARE
