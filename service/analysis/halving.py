"""Successive halving: how far the entries of a search have climbed, and which go on.

A pure function of the search and of what its runs have measured. Each rung is ranked by the
measurements up to its own timesteps, so that its ranking does not change when the best go on.

    score of an entry on a rung = mean over seeds of the normalised score up to T_k

A run that diverged before T_k counts as acting at random (0), because divergence is what the
algorithm does. An entry with a run that failed or was cancelled before T_k is left out. Among
equals, the first of the request goes on.
"""

from collections import Counter
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Literal

import numpy as np

from service.analysis.comparison import grouped, scale
from service.analysis.statistics.score import SCORES
from service.model.inquiry.search import Rung, Search
from service.model.request.entry import Entries
from service.model.run import RunStatus
from service.model.run_curve import RunCurve
from workers.messages.random_return import RandomReturn

Cell = tuple[str, str]
"""A task, and an entry's label."""
Unit = tuple[float, float]
"""Where the normalised scale starts, and how long its unit is."""


@dataclass(frozen=True)
class Standing:
    """An entry on a rung.

    score     NaN while a run of it is on the way, and where it is left out
    climbing  how many of its runs are on the way
    diverged  before they got there
    failed    or were cancelled before
    goes_on   whether it is among the best
    """

    label: str
    score: float
    climbing: int
    diverged: int
    failed: int
    goes_on: bool = False


@dataclass(frozen=True)
class Climb:
    """The entries on one rung of a task; the best first where it is over."""

    rung: Rung
    standings: tuple[Standing, ...]

    @property
    def is_over(self) -> bool:
        """Whether no run is on the way."""
        return not any(each.climbing for each in self.standings)

    @property
    def best(self) -> list[Standing]:
        """Those that go on."""
        return [each for each in self.standings if each.goes_on]


@dataclass(frozen=True)
class Ladder:
    """The rungs of a task, and the climbs of those that were reached."""

    environment: str
    rungs: tuple[Rung, ...]
    climbs: tuple[Climb, ...]

    @property
    def winner(self) -> Standing | None:
        """The best entry; None while it is not known, and where every entry is left out."""
        is_whole = len(self.climbs) == len(self.rungs)
        return next(iter(self.climbs[-1].best), None) if is_whole else None


def ladders(
    run_curves: Sequence[RunCurve],
    entries: Entries,
    search: Search,
    random_returns: Mapping[tuple[str, int], RandomReturn],
    best_return: Callable[[str], float],
) -> list[Ladder]:
    """Return how far the entries have climbed in each task; the curves are of return_mean."""
    found = []
    for environment, runs in grouped(run_curves, lambda run: run.spec.environment).items():
        zero = random_returns.get((environment, runs[0].environment_version))
        unit = scale(zero, best_return(environment))
        climbs = _climbs(grouped(runs, entries.label), search, environment, unit)
        found.append(Ladder(environment, search.rungs[environment], climbs))
    return found


def wanted(climbed: Iterable[Ladder]) -> dict[Cell, int]:
    """Return the timesteps that cells shall have for the next rung; none if all is decided."""
    return {
        (ladder.environment, standing.label): ladder.climbs[-1].rung.timesteps
        for ladder in climbed
        if not ladder.climbs[-1].is_over
        for standing in ladder.climbs[-1].standings
    }


def _climbs(
    runs: Mapping[str, Sequence[RunCurve]], search: Search, environment: str, unit: Unit
) -> tuple[Climb, ...]:
    rungs = search.rungs[environment]
    climbs: list[Climb] = []
    left = dict(runs)
    for rung, going_on in zip(rungs, [*(above.entries for above in rungs[1:]), 1], strict=True):
        standings = [_standing(label, own, rung, search, unit) for label, own in left.items()]
        climbs.append(_ranked(Climb(rung, tuple(standings)), going_on))
        best = {each.label for each in climbs[-1].best}
        left = {label: own for label, own in left.items() if label in best}
        if not left:
            break
    return tuple(climbs)


def _ranked(climb: Climb, going_on: int) -> Climb:
    """Rank the entries of a rung that is over, of which so many go on at most."""
    if not climb.is_over:
        return climb
    best = sorted(climb.standings, key=lambda each: (np.isnan(each.score), -each.score))
    placed = [
        replace(each, goes_on=place < going_on and not np.isnan(each.score))
        for place, each in enumerate(best)
    ]
    return replace(climb, standings=tuple(placed))


def _standing(
    label: str, runs: Sequence[RunCurve], rung: Rung, search: Search, unit: Unit
) -> Standing:
    stands = [_stand(run, rung.timesteps) for run in runs]
    counts = Counter(stands)
    scores = [
        _score(run, rung, search, unit) if stand == "there" else 0.0
        for run, stand in zip(runs, stands, strict=True)
    ]
    is_known = not counts["climbing"] + counts["failed"]
    return Standing(
        label=label,
        score=float(np.mean(scores)) if is_known else np.nan,
        climbing=counts["climbing"],
        diverged=counts["diverged"],
        failed=counts["failed"],
    )


def _stand(run: RunCurve, timesteps: int) -> Literal["there", "diverged", "failed", "climbing"]:
    """Return the state of a run on the way to so many timesteps; it may end earlier by itself."""
    has_ended = run.status is RunStatus.SUCCEEDED and run.spec.timesteps >= timesteps
    if len(run.x) and (has_ended or run.x[-1] >= timesteps):
        return "there"
    if run.status is RunStatus.DIVERGED:
        return "diverged"
    is_cut = run.status in (RunStatus.FAILED, RunStatus.CANCELLED)
    return "failed" if is_cut else "climbing"


def _score(run: RunCurve, rung: Rung, search: Search, unit: Unit) -> float:
    """Return the normalised score up to the rung; 0 where a return is not finite."""
    until = run.x <= rung.timesteps
    start, length = unit
    score = SCORES[search.score].of(run.x[until], run.values[until], rung.timesteps)
    normalised = (score - start) / length
    return float(normalised) if np.isfinite(score) else 0.0
