"""Statistics of a sweep: over the tasks that all curves have in common."""

import math

import numpy as np

from service.analysis.statistics.score_table import score_table
from service.analysis.statistics.sweep_statistics import sweep_statistics
from service.model.run import RunStatus
from tests.service.scored import cell

NAN = math.nan


def test_only_common_tasks_count_and_it_says_which() -> None:
    found = sweep_statistics(
        [
            cell("ddpg", "Pendulum", [0.1, 0.2]),
            cell("ddpg", "Acrobot", [0.9, 0.9]),
            cell("mpc", "Pendulum", [0.3, 0.4]),
            cell("gd", "Pendulum", [NAN]),
        ]
    )
    assert found.tasks == ("Pendulum",)
    assert found.lacking == {"Acrobot": ["mpc"]}
    assert found.unscored == ("gd",)
    assert [(one.label, one.runs) for one in found.labels] == [("ddpg", 2), ("mpc", 2)]
    np.testing.assert_allclose([one.iqm.value for one in found.labels], [0.15, 0.35])
    (improvement,) = found.improvements
    assert (improvement.x, improvement.y, improvement.all_pairs.value) == ("ddpg", "mpc", 0.0)


def test_one_curve_does_not_move_with_its_company() -> None:
    ddpg = [cell("ddpg", "Pendulum", [0.1, 0.5, 0.3]), cell("ddpg", "Acrobot", [0.2, 0.7])]
    sac = [cell("sac", "Pendulum", [0.4, 0.1]), cell("sac", "Acrobot", [0.2, 0.9, 0.1])]
    alone, beside = sweep_statistics(ddpg), sweep_statistics([*sac, *ddpg])
    assert alone.labels[0].iqm == beside.labels[1].iqm


def test_seeds_pair_whatever_is_not_finite() -> None:
    found = sweep_statistics(
        [
            cell("ddpg", "Pendulum", [NAN, 0.2, 0.5], seeds=(0, 1, 2)),
            cell("sac", "Pendulum", [0.9, 0.1, NAN], seeds=(0, 1, 2)),
        ]
    )
    (improvement,) = found.improvements
    assert improvement.same_seeds is not None
    assert improvement.same_seeds.value == 1.0  # seed 1 alone
    assert improvement.all_pairs.value == 0.5


def test_cells_of_which_only_some_runs_count_are_named() -> None:
    ended = RunStatus.SUCCEEDED
    found = sweep_statistics(
        [
            cell("ddpg", "Pendulum", [0.1, 0.2]),
            cell("sac", "Pendulum", [0.9, NAN], statuses=[ended, RunStatus.DIVERGED]),
        ]
    )
    assert found.tasks == ("Pendulum",)
    (incomplete,) = found.incomplete
    assert (incomplete.label, incomplete.unfinished) == ("sac", {"diverged": 1})
    assert [one.runs for one in found.labels] == [2, 1]


def test_entries_stand_in_the_order_of_the_request() -> None:
    """The first one runs in the second task alone."""
    cells = [
        cell("mpc", "Acrobot", [0.1, 0.2], place=1),
        cell("gd", "Pendulum", [0.1, 0.2], place=0),
        cell("mpc", "Pendulum", [0.1, 0.2], place=1),
    ]
    assert [one.label for one in sweep_statistics(cells).labels] == ["gd", "mpc"]
    assert [row.label for row in score_table(cells, "final", normalized=True).rows] == ["gd", "mpc"]


def test_nothing_in_common_or_nothing_at_all() -> None:
    apart = sweep_statistics([cell("ddpg", "Pendulum", [1.0]), cell("sac", "Acrobot", [1.0])])
    assert (apart.tasks, apart.labels, apart.improvements) == ((), (), ())
    assert apart.lacking == {"Pendulum": ["sac"], "Acrobot": ["ddpg"]}
    nothing = sweep_statistics([cell("ddpg", "Pendulum", [NAN, NAN])])
    assert (nothing.tasks, nothing.unscored) == ((), ("ddpg",))


def test_thresholds_hold_all_scores_down_to_minus_one() -> None:
    found = sweep_statistics([cell("ddpg", "Pendulum", [-7.0, 0.4])])
    assert (found.thresholds[0], found.thresholds[-1]) == (-1.0, 1.0)
    found = sweep_statistics([cell("ddpg", "Pendulum", [0.2, 1.4])])
    assert (found.thresholds[0], found.thresholds[-1]) == (0.0, 1.4)
