"""A hybrid minus its baseline, seed by seed."""

import math

import pytest

from service.analysis.statistics.paired_difference import PairedDifference, paired_differences
from service.model.run import RunStatus
from service.model.run_curve import RunCurve
from tests.service.scored import ByAlgorithm, run_curve
from tests.service.training import random_return
from workers.messages.run_spec import Weights

ZERO = {("Pendulum", 1): random_return("Pendulum", -1000.0)}


def differences(*runs: RunCurve) -> list[PairedDifference]:
    return paired_differences(runs, ByAlgorithm(runs), ZERO, lambda _: 0.0)


def test_by_hand() -> None:
    """Areas 300, 100 over 200, 200: differences 0.1 and -0.1 of a unit of 1000."""
    (found,) = differences(
        run_curve("ddpg", "Pendulum", 0, [200, 200, 200]),
        run_curve("ddpg", "Pendulum", 1, [100, 200, 300]),
        run_curve("hybrid-ddpg", "Pendulum", 1, [100, 100, 100], weights=Weights(1.0, 0.0)),
        run_curve("hybrid-ddpg", "Pendulum", 0, [200, 300, 400], weights=Weights(1.0, 0.0)),
    )
    assert (found.environment, found.label, found.baseline) == ("Pendulum", "hybrid-ddpg", "ddpg")
    assert (found.difference.n, found.wins) == (2, 1)
    assert found.difference.mean == pytest.approx(0.0)
    assert found.difference.std == pytest.approx(0.2 / math.sqrt(2))


def test_both_up_to_where_both_are() -> None:
    (found,) = differences(
        run_curve("ddpg", "Pendulum", 0, [0, 0]),
        run_curve("hybrid-ddpg", "Pendulum", 0, [100, 100, 9000]),
    )
    assert found.difference.mean == pytest.approx(0.1)


def test_pairs_that_do_not_count() -> None:
    (found,) = differences(
        run_curve("ddpg", "Pendulum", 0, [0.0, math.nan]),
        run_curve("ddpg", "Pendulum", 1, []),
        run_curve("ddpg", "Pendulum", 2, [0.0]),
        run_curve("ddpg", "Pendulum", 4, [0.0]),
        *(run_curve("hybrid-ddpg", "Pendulum", seed, [100.0, 0.0]) for seed in (0, 1, 3, 4)),
    )
    assert (found.difference.n, found.difference.mean) == (1, 0.1)
    assert math.isnan(found.difference.low)


def test_only_against_the_algorithm_it_extends_in_the_same_task() -> None:
    assert not differences(
        run_curve("ddpg", "Pendulum", 0, [0]),
        run_curve("hybrid-sac", "Pendulum", 0, [1]),
        run_curve("hybrid-ddpg", "MassPoint", 0, [1]),
    )


def test_without_a_random_return_there_is_no_unit() -> None:
    (found,) = differences(
        run_curve("ddpg", "MassPoint", 0, [0]), run_curve("hybrid-ddpg", "MassPoint", 0, [1])
    )
    assert found.difference.n == 0


@pytest.mark.parametrize("status", sorted(set(RunStatus) - {RunStatus.SUCCEEDED}))
def test_only_pairs_at_their_end_count(status: RunStatus) -> None:
    """A hybrid that diverged after a good start has not gained anything."""
    (found,) = differences(
        run_curve("ddpg", "Pendulum", 0, [0, 0]),
        run_curve("ddpg", "Pendulum", 1, [0, 0], status=status),
        run_curve("ddpg", "Pendulum", 2, [0, 0]),
        run_curve("hybrid-ddpg", "Pendulum", 0, [900], status=status),
        run_curve("hybrid-ddpg", "Pendulum", 1, [900, 900]),
        run_curve("hybrid-ddpg", "Pendulum", 2, [100, 100]),
    )
    assert (found.pairs, found.difference.n, found.wins) == (3, 1, 1)
    assert found.difference.mean == pytest.approx(0.1)
