"""How many runs of a cell train together, given all that waits and the free cores.

    the least size, up to 16, at which the cohorts are no more than the free cores

So the last cohort ends as early as it can: one cell is split evenly over the free cores, and where
more waits than they can take at once, cohorts are full. A split costs no throughput: kernels take
one seed after the other, and a run's bits do not depend on its cohort. What a cohort costs beside
its runs (0.02 to 0.3 s, of which the claim holds up the others for milliseconds) is paid by cores
that would be idle, at the same time; so no size is too small while there is one for each cohort.
"""

from collections.abc import Iterable

from workers.messages.run_spec import COHORT_LIMIT


def cohort_size(cells: Iterable[int], free_cores: int) -> int:
    """Return how many runs a cohort should have, where so many of each cell wait."""
    waiting = list(cells)
    sizes = range(1, COHORT_LIMIT)
    return next((n for n in sizes if cohorts(waiting, n) <= free_cores), COHORT_LIMIT)


def cohorts(cells: Iterable[int], size: int) -> int:
    """Return into how many cohorts of at most that size the cells are split."""
    return sum(-(-runs // size) for runs in cells)
