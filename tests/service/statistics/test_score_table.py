"""Table 1: entries in their places, and which of them are best."""

import math

from service.statistics.score_table import score_table
from tests.service.scored import cell

NAN = math.nan


def bests(*means: float) -> list[bool]:
    scores = [cell(f"algorithm {k}", "Pendulum", [mean]) for k, mean in enumerate(means)]
    rows = score_table(scores, "return_history", normalized=True).rows
    return [row.entries[0] is not None and row.entries[0].is_best for row in rows]


def test_the_largest_mean_is_best() -> None:
    assert bests(0.5, 0.7, 0.6) == [False, True, False]


def test_equal_as_printed_is_equal() -> None:
    assert bests(0.7004, 0.6996, 0.6994) == [True, True, False]


def test_without_a_finite_mean_there_is_no_best() -> None:
    assert bests(NAN, NAN) == [False, False]
    assert bests(NAN, -3.0) == [False, True]


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
    assert [entry and entry.sample.n for entry in ddpg.entries] == [2, 1]
    assert gd.entries[0] is None
    assert gd.entries[1] is not None
    assert gd.entries[1].sample.n == 0


def test_the_definition_says_what_is_shown() -> None:
    normalised = score_table([cell("ddpg", "Pendulum", [1])], "return_history", normalized=True)
    assert "return_history (mean of the latest 100 return_mean)" in normalised.definition
    assert "0 is the mean return of uniform random actions" in normalised.definition
    assert "rounded to 3 decimals" in normalised.definition
    assert "have not ended" not in normalised.definition
    raw = score_table([cell("ddpg", "Pendulum", [1])], "return_mean", normalized=False)
    assert "Raw returns." in raw.definition
    assert "rounded to 2 decimals" in raw.definition
