"""Figure 7: the learners of today and the hybrids, in the paper's tasks and three more.

A share of the timesteps is of those that ddpg's runs have in the task; a share of the time is of
the mean processor time of ddpg's runs there, on the same processor (service.paper.speeds); a run
on a processor whose speed is not known has no time. Every learner counts with the seeds that all of
them have, and with its runs that reached their end.
"""

import csv
import math
from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path

import numpy as np

from service.analysis.comparison import grouped
from service.analysis.curves import Floats
from service.analysis.figures import today_figure
from service.analysis.figures.figure_form import Form
from service.analysis.overview import Learner, Line, SharedRun, Standing, standings
from service.analysis.statistics.score import final_score
from service.paper import markdown
from service.paper.evaluation import FEWER_SEEDS, MORE_TASKS, TASKS
from service.paper.measured import EARLY, ENDED, MeasuredRun, Scale
from service.paper.speeds import Slowness

FORMS: tuple[Form, ...] = ("svg", "png")
REFERENCE = "ddpg"
SHOWN = (*TASKS, *MORE_TASKS)
ROWS = (
    *("ddpg", "hybrid-ddpg-robust", "hybrid-ddpg", "hybrid-ddpg-cosine", "td3", "hybrid-td3"),
    *("sac", "hybrid-sac", "sac with learned temperature", "ppo", "shac", "gd", "mpc"),
)
"""The learners, in the order of the figure."""

OVER_TASKS = (
    *("tasks", "runs", "interquartile mean at ddpg's timesteps", "at ddpg's processor time"),
    *("mean rank", "processor time of a run, ddpg's is 1"),
)
COLUMNS = ("learner", "tasks", "runs", "early", "of", "x", "value", "low", "high")


def write_figure(
    folder: Path, runs: Sequence[MeasuredRun], scales: Mapping[str, Scale], slowness: Slowness
) -> None:
    """Write figure-7 as pictures and its numbers beside them; nothing before the first run ends."""
    found = standings(learners(runs, scales, slowness))
    if found:
        _write_numbers(folder / "figure-7.csv", found)
        for form in FORMS:
            (folder / f"figure-7.{form}").write_bytes(today_figure.draw(found, form))


def learners(
    runs: Sequence[MeasuredRun], scales: Mapping[str, Scale], slowness: Slowness
) -> list[Learner]:
    """Return the learners with runs at their end, in tasks where the reference has some too."""
    asked = [
        run
        for run in runs
        if run.seed < FEWER_SEEDS and run.environment in SHOWN and run.environment in scales
    ]
    ended = grouped(filter(_counts, asked), lambda run: (run.row, run.environment))
    early = Counter(run.row for run in asked if run.status in EARLY)
    tasks = {
        row: [task for task in SHOWN if {(row, task), (REFERENCE, task)} <= ended.keys()]
        for row in ROWS
    }
    return [
        Learner(
            row,
            ended[row, own[0]][0].algorithm,
            {t: _shared(ended[row, t], ended[REFERENCE, t], scales[t], slowness) for t in own},
            early[row],
        )
        for row, own in tasks.items()
        if own
    ]


def told(
    runs: Sequence[MeasuredRun], scales: Mapping[str, Scale], slowness: Slowness
) -> Iterator[str]:
    """Yield the lines of two tables in Markdown: over all tasks, and the returns in each."""
    asked = learners(runs, scales, slowness)
    yield "## The learners of today\n"
    yield from markdown.head("learner", *OVER_TASKS)
    for learner, standing in zip(asked, standings(asked), strict=True):
        yield markdown.line(_over_tasks(learner, standing))
    shown = [task for task in SHOWN if any(task in learner.runs for learner in asked)]
    yield "\nMean of the last tenth of each learner's timesteps, normalised:\n"
    yield from markdown.head("learner", *shown)
    for learner in asked:
        cells = (f"{_last_tenth(learner, t):.2f}" if t in learner.runs else "-" for t in shown)
        yield markdown.line([learner.label, *cells])


def _over_tasks(learner: Learner, standing: Standing) -> Iterator[str]:
    yield from (standing.label, str(standing.tasks), str(standing.runs))
    for line in (standing.by_timesteps, standing.by_time):
        yield _estimated(*(_at_one(line, y) for y in (line.mean, line.low, line.high)))
    yield _estimated(standing.rank.value, standing.rank.low, standing.rank.high, decimals=1)
    times = [np.mean([run.time[-1] for run in own]) for own in learner.runs.values()]
    median = float(np.median(times))
    yield f"{median:.2g}" if math.isfinite(median) else "-"


def _at_one(line: Line, values: Floats) -> float:
    """A line's value where ddpg's runs end; NaN where it starts later."""
    return float(np.interp(1.0, line.x, values, left=np.nan)) if line.x.size else math.nan


def _estimated(value: float, low: float, high: float, *, decimals: int = 2) -> str:
    if not math.isfinite(value):
        return "-"
    return f"{value:.{decimals}f} [{low:.{decimals}f}, {high:.{decimals}f}]"


def _last_tenth(learner: Learner, task: str) -> float:
    """The mean return of a learner's runs over the last tenth of their timesteps."""
    return float(
        np.mean(
            [
                final_score(run.timesteps, run.returns, run.timesteps[-1])
                for run in learner.runs[task]
            ]
        )
    )


def _counts(run: MeasuredRun) -> bool:
    return run.status == ENDED and bool(np.isfinite(run.columns["return_mean"]).all())


def _shared(
    runs: Sequence[MeasuredRun],
    reference: Sequence[MeasuredRun],
    scale: Scale,
    slowness: Slowness,
) -> list[SharedRun]:
    timesteps = reference[0].timesteps
    seconds = np.mean([run.columns["seconds"][-1] for run in reference])
    return [
        SharedRun(
            run.columns["timestep"] / timesteps,
            run.columns["seconds"] / (seconds * slowness(run, reference)),
            (run.columns["return_mean"] - scale.random) / scale.unit,
        )
        for run in runs
    ]


def _write_numbers(file: Path, found: Sequence[Standing]) -> None:
    with file.open("w", encoding="utf-8", newline="") as output:
        writer = csv.writer(output, lineterminator="\n")
        writer.writerow(COLUMNS)
        for one in found:
            place = (one.label, one.tasks, one.runs, one.early)
            writer.writerows((*place, *numbers) for numbers in _numbers(one))


def _numbers(one: Standing) -> Iterator[tuple[str, ...]]:
    yield ("mean rank", "", *_decimals(one.rank.value, one.rank.low, one.rank.high))
    for name, line in (("timesteps", one.by_timesteps), ("time", one.by_time)):
        yield from _points(f"interquartile mean by {name}", line)


def _points(of: str, line: Line) -> Iterator[tuple[str, ...]]:
    for x, *values in zip(line.x, line.mean, line.low, line.high, strict=True):
        yield (of, f"{x:.4g}", *_decimals(*values))


def _decimals(*values: float) -> tuple[str, ...]:
    return tuple(f"{value:.5f}" for value in values)
