"""Cohort sizes: full ones where much waits, and an even split where cores are free."""

import pytest

from service.queue.cohort_size import cohort_size, cohorts

FULL_CELL = 16


@pytest.mark.parametrize(
    ("cells", "free_cores", "size"),
    [
        ([FULL_CELL], 1, 16),
        ([FULL_CELL], 2, 8),
        ([FULL_CELL], 8, 2),
        ([FULL_CELL], 12, 2),  # one each would be 16 cohorts
        ([FULL_CELL], 16, 1),
        ([FULL_CELL], 100, 1),
        ([5], 2, 3),
        ([100], 8, 13),
        ([1000], 8, 16),
        (56 * [FULL_CELL], 2, 16),
        (56 * [FULL_CELL], 8, 16),
        (56 * [FULL_CELL], 112, 8),
        (3 * [FULL_CELL], 8, 8),  # six cohorts; of seven runs each they would be nine
        ([FULL_CELL, 1, 1], 4, 8),
        (200 * [1], 8, 16),
        ([], 8, 1),
    ],
)
def test_the_last_cohort_ends_as_early_as_it_can(
    cells: list[int], free_cores: int, size: int
) -> None:
    assert cohort_size(cells, free_cores) == size


def test_a_cell_is_split_into_cohorts_of_at_most_that_size() -> None:
    assert [cohorts([16, 5, 0], size) for size in (1, 4, 16)] == [21, 6, 2]
