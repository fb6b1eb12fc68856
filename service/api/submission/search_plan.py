"""A sweep's search: its plan, or why it is refused, and notices for its author."""

from collections.abc import Iterator, Sequence
from dataclasses import replace

from algorithms import catalogue
from service.analysis.comparison import grouped
from service.api.refusals.problems import Fault, InvalidRequest
from service.api.schemas.requests.sweep_request import MAX_RUNS, SweepRequest
from service.api.schemas.search.search_request import SearchRequest
from service.model.inquiry.search import (
    FEWEST_SEEDS,
    Search,
    cost_of_a_seed,
    rungs_of,
    search_seeds,
)
from service.model.inquiry.tuning_seeds import PRESETS, SEARCHES, chooses, seeds_text
from service.model.request.entry import Entry
from workers.messages.run_spec import RunSpec

Cells = Sequence[tuple[Entry, RunSpec]]


def search_faults(request: SweepRequest, cells: Cells) -> Iterator[Fault]:
    """Refuse what cannot be searched; `planned_search` checks the budget."""
    if request.search is None:
        return
    if request.question is not None:
        yield Fault(
            "search",
            "a sweep has a search or a question, not both: ask in another sweep, on other seeds",
        )
    given = request.seeds
    is_own = isinstance(given, int) or all(map(chooses, given))
    if not is_own or _fewest(given) < FEWEST_SEEDS:
        message = (
            f"a search takes seeds of its own: give the least number of seeds of each entry, "
            f"{FEWEST_SEEDS} or more, or a list of {FEWEST_SEEDS} or more seeds that are reserved "
            f"for choosing settings ({seeds_text(PRESETS)}; {seeds_text(SEARCHES)})"
        )
        yield Fault("seeds", message, FEWEST_SEEDS)
    if isinstance(request.scale, list):
        yield Fault("scale", "all entries of a search have equal timesteps: give one share")
    for task, own in _by_task(cells).items():
        yield from _task_faults(task, own, request.search)


def planned_search(request: SweepRequest, cells: Cells) -> Search | None:
    """Return the search that a sweep asks for. Raises InvalidRequest if its budget is too small.

    The cells are as long as the sweep's runs can get.
    """
    asked = request.search
    if asked is None:
        return None
    rungs = {
        task: rungs_of(len(own), own[0].timesteps, asked.reduction)
        for task, own in _by_task(cells).items()
    }
    cost = cost_of_a_seed(rungs)
    fewest = _fewest(request.seeds)
    if asked.budget < (least := fewest * cost):
        message = (
            f"is too small: with {fewest} seeds the search takes {least:,} timesteps. Give "
            "as many, or fewer timesteps to the longest runs, or fewer entries"
        )
        raise InvalidRequest([Fault("search.budget", message, least)])
    if isinstance(request.seeds, int):
        seeds = search_seeds(min(asked.budget // cost, MAX_RUNS // len(cells), len(SEARCHES)))
    else:
        seeds = tuple(request.seeds)
    return Search(asked.budget, asked.reduction, asked.score, seeds, rungs)


def first_rung(cells: Cells, search: Search | None) -> Cells:
    """Return the cells of a sweep as they begin."""
    if search is None:
        return cells
    seed = search.seeds[0]
    return [
        (entry, replace(cell, seed=seed, timesteps=search.rungs[cell.environment][0].timesteps))
        for entry, cell in cells
    ]


def search_notices(search: Search | None) -> Iterator[str]:
    """Tell what will be trained, and on which seeds."""
    if search is None:
        return
    tasks = "; ".join(
        f"{task}: "
        + ", then ".join(f"{rung.entries} entries to {rung.timesteps:,}" for rung in rungs)
        for task, rungs in search.rungs.items()
    )
    yield (
        f"The search takes {search.timesteps:,} of its budget of {search.budget:,} timesteps, with "
        f"{len(search.seeds)} seeds. {tasks}."
    )
    yield (
        f"Its seeds are {seeds_text(search.seeds)}, which no question takes: ask with others "
        "whether the best entry is better."
    )


def _fewest(seeds: int | list[int]) -> int:
    """Return the least number of seeds of each entry."""
    return seeds if isinstance(seeds, int) else len(seeds)


def _by_task(cells: Cells) -> dict[str, list[RunSpec]]:
    return grouped([cell for _, cell in cells], lambda cell: cell.environment)


def _task_faults(task: str, cells: Sequence[RunSpec], search: SearchRequest) -> Iterator[Fault]:
    """Refuse a task whose entries cannot be compared, rung by rung."""
    if len(cells) < 2:
        message = f"there is only one entry in {task}: give more entries, or lists of values"
        yield Fault("search", message)
    lengths = {cell.timesteps: cell.algorithm for cell in cells}
    if len(lengths) > 1:
        told = ", ".join(f"{name} {steps:,}" for steps, name in lengths.items())
        message = f"the presets of its learners differ in {task} ({told}): give one number for all"
        yield Fault("timesteps", message)
    stuck = [name for name in dict.fromkeys(c.algorithm for c in cells) if not _can_go_on(name)]
    if stuck and len(cells) > search.reduction:
        message = (
            f"runs of {', '.join(stuck)} cannot go on from where they ended: give {len(cells)} or "
            f"more, which trains all entries in {task} to the end"
        )
        yield Fault("search.reduction", message, len(cells))


def _can_go_on(algorithm: str) -> bool:
    known = catalogue.known(algorithm)
    return known is None or known.can_go_on
