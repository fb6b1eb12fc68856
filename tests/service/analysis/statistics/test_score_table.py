"""The score table: standings in their places, and which of them are best."""

import math

import pytest

from service.analysis.statistics.score_table import score_table
from service.model.run import RunStatus
from tests.service.scored import cell

NAN = math.nan


def bests(*means: float) -> list[bool]:
    scores = [cell(f"algorithm {k}", "Pendulum", [mean]) for k, mean in enumerate(means)]
    rows = score_table(scores, "return_history", normalized=True).rows
    return [row.standings[0] is not None and row.standings[0].is_best for row in rows]


def test_the_largest_mean_is_best() -> None:
    assert bests(0.5, 0.7, 0.6) == [False, True, False]


def test_equal_as_printed_is_equal() -> None:
    assert bests(0.7004, 0.6996, 0.6994) == [True, True, False]


def test_without_a_finite_mean_there_is_no_best() -> None:
    assert bests(NAN, NAN) == [False, False]
    assert bests(NAN, -3.0) == [False, True]


@pytest.mark.parametrize("status", sorted(set(RunStatus) - {RunStatus.SUCCEEDED}))
def test_a_cell_without_all_of_its_runs_wins_nothing(status: RunStatus) -> None:
    """Two of three seeds got far and one did not end: the mean of the two says too much."""
    ended = RunStatus.SUCCEEDED
    table = score_table(
        [
            cell("ddpg", "Pendulum", [0.5, 0.5, 0.5]),
            cell("sac", "Pendulum", [0.9, 0.9, NAN], statuses=[ended, ended, status]),
        ],
        "final",
        normalized=True,
    )
    ddpg, sac = (row.standings[0] for row in table.rows)
    assert ddpg is not None
    assert sac is not None
    assert (ddpg.is_best, sac.is_best) == (True, False)
    assert (sac.sample.n, sac.runs, sac.unfinished) == (2, 3, {status.value: 1})
    assert f"1 of 6 runs do not count (1 {status})" in table.definition


def test_where_no_cell_has_all_of_its_runs_nothing_is_best() -> None:
    statuses = [RunStatus.SUCCEEDED, RunStatus.DIVERGED]
    scores = [cell(name, "Pendulum", [0.9, NAN], statuses=statuses) for name in ("ddpg", "sac")]
    rows = score_table(scores, "final", normalized=True).rows
    assert [row.standings[0] and row.standings[0].is_best for row in rows] == [False, False]


def test_a_pair_that_was_not_run_has_no_entry() -> None:
    table = score_table(
        [
            cell("ddpg", "Acrobot", [1, 2]),
            cell("ddpg", "Pendulum", [3]),
            cell("gd", "Pendulum", []),
        ],
        "return_history",
        normalized=False,
    )
    assert table.environments == ("Acrobot", "Pendulum")
    ddpg, gd = table.rows
    assert [each and each.sample.n for each in ddpg.standings] == [2, 1]
    assert gd.standings[0] is None
    assert gd.standings[1] is not None
    assert gd.standings[1].sample.n == 0


def test_the_definition_says_what_is_shown() -> None:
    normalised = score_table([cell("ddpg", "Pendulum", [1])], "return_history", normalized=True)
    assert "return_history (mean of the latest 100 return_mean)" in normalised.definition
    assert "0 is the mean return of uniform random actions" in normalised.definition
    assert "rounded to 3 decimals" in normalised.definition
    assert "do not count" not in normalised.definition
    raw = score_table([cell("ddpg", "Pendulum", [1])], "final", normalized=False)
    assert "mean of return_mean over the last tenth of the run's timesteps" in raw.definition
    assert "Raw returns." in raw.definition
    assert "rounded to 2 decimals" in raw.definition
