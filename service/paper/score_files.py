"""The result of every run, and the scale of its task, as files.

    scores.csv          a line a run: what it was, whether it reached its end, the processor that it
                        was trained on (LLVM's name for it), its three scores, raw
    random-returns.csv  a line a task: random with its 95 % interval, the task's best return

    normalised = (score - random) / (best - random)

All tables and statistics of scores follow from these two files.
"""

import csv
import json
from collections.abc import Iterable, Iterator, Mapping, Sequence
from pathlib import Path

import numpy as np

from service.analysis.statistics.score import SCORES
from service.api.schemas.curves_answer import RandomReturnAnswer
from service.api.schemas.run_answer import RunAnswer
from service.model.environment import best_return
from service.model.processor import processor_of

Row = Mapping[str, str]

SPEC = (
    *("environment", "version", "algorithm", "w1", "w2", "config", "seed", "timesteps", "status"),
    "processor",
)


def write_scores(
    file: Path, measured: Iterable[tuple[RunAnswer, Sequence[Row]]], former: Iterable[Row] = ()
) -> None:
    """Write scores.csv, of runs and their measurements; a run without any has no scores.

    The lines of `former` runs are written first, unchanged.
    """
    header = (*SPEC, *SCORES)
    lines = ((*_spec(run), *_scores(run, rows)) for run, rows in measured)
    _write(file, header, [*([line[name] for name in header] for line in former), *lines])


def write_random_returns(
    file: Path, zeros: Mapping[str, RandomReturnAnswer | None], former: Iterable[Row] = ()
) -> None:
    """Write random-returns.csv for tasks whose random return is known, now or in `former`."""
    lines: dict[str, Sequence[object]] = {
        line["environment"]: list(line.values()) for line in former
    } | {
        environment: (environment, *_random(zero), best_return(environment))
        for environment, zero in zeros.items()
        if zero is not None
    }
    header = ("environment", "random", "low", "high", "episodes", "best")
    _write(file, header, [lines[environment] for environment in sorted(lines)])


def _random(zero: RandomReturnAnswer) -> tuple[float, ...]:
    return zero.mean, zero.low, zero.high, zero.episodes


def _write(file: Path, header: Sequence[str], lines: Iterable[Sequence[object]]) -> None:
    with file.open("w", encoding="utf-8", newline="") as output:
        writer = csv.writer(output, lineterminator="\n")
        writer.writerow(header)
        writer.writerows(lines)


def _spec(run: RunAnswer) -> tuple[object, ...]:
    config = json.dumps(run.config, sort_keys=True)
    learner = (run.algorithm, *run.weights.pair, config)
    asked = (run.seed, run.timesteps, run.status, processor_of(run.fingerprint))
    return run.environment, run.environment_version, *learner, *asked


def _scores(run: RunAnswer, rows: Sequence[Row]) -> Iterator[float | str]:
    timesteps = np.array([float(row["timestep"]) for row in rows])
    for kind in SCORES.values():
        values = np.array([float(row[kind.metric]) for row in rows])
        yield kind.of(timesteps, values, run.timesteps) if rows else ""
