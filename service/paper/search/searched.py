"""Results of the search, as tables in Markdown: the best areas, and hybrids at every setting.

A hybrid with bounded losses and what it extends were searched over the same settings with the same
seeds, so that their areas can be compared setting by setting. That shows what matching gradients
does for a learner with untuned settings.
"""

from collections.abc import Iterator, Sequence

from algorithms import catalogue
from service.paper import markdown
from service.paper.search.tuning import (
    EVERY_SECOND,
    PAIRS,
    SEEDS,
    SPACES,
    TIMESTEPS,
    Outcome,
    all_searches,
    best,
    is_whole,
    searched_cells,
)

HYBRIDS = ("hybrid-ddpg-robust", "hybrid-td3")


def searched(rows: Sequence[Outcome]) -> Iterator[str]:
    """Yield the lines of both tables; a cell is empty if a search has not ended."""
    tasks = list(TIMESTEPS)
    yield f"## The search, {len(SEEDS)} seeds a cell\n"
    yield "Area of the best cell:\n"
    yield from markdown.head("learner", *tasks)
    searches = set(all_searches())
    for name in (*SPACES, *PAIRS):
        known = ((name, task) in searches and is_whole(rows, task, name) for task in tasks)
        areas = [
            f"{best(rows, task, name).area:.2f}" if there else ""
            for task, there in zip(tasks, known, strict=True)
        ]
        yield markdown.line([name, *areas])
    yield "\nHybrid minus baseline at the same setting, mean over the settings (lowest, highest):\n"
    yield from markdown.head("hybrid", *tasks)
    for hybrid in HYBRIDS:
        yield markdown.line([hybrid, *(_gain(rows, hybrid, task) for task in tasks)])


def _gain(rows: Sequence[Outcome], hybrid: str, task: str) -> str:
    baseline = catalogue.baseline(hybrid)
    if not (is_whole(rows, task, hybrid) and is_whole(rows, task, baseline)):
        return ""
    gains = [
        _area(rows, task, hybrid, {**setting, **EVERY_SECOND})
        - _area(rows, task, baseline, setting)
        for setting in SPACES[baseline].on(task)
    ]
    mean = sum(gains) / len(gains)
    return f"{mean:+.2f} ({min(gains):+.2f}, {max(gains):+.2f})"


def _area(rows: Sequence[Outcome], task: str, algorithm: str, setting: dict[str, object]) -> float:
    [area] = [
        row.area
        for row in searched_cells(rows, task, algorithm)
        if row.config == setting and row.weights == SPACES[algorithm].weights
    ]
    return area
