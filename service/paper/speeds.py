"""What a second of one processor is worth on another: ddpg's time in the same task on both.

Parts of an evaluation may be trained on different machines. speeds.csv has, for a processor and a
task, the mean processor time of ddpg's first runs up to some timesteps; `d3pg paper time` measures
it. A processor is so many times slower in a task as ddpg takes longer there for the same timesteps
than the evaluation's runs of ddpg took.
"""

import csv
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from math import nan
from pathlib import Path

import numpy as np

import algorithms
from algorithms.measurement import MEASURE_EVERY
from algorithms.presets import preset
from service.model.processor import are_comparable
from service.paper.evaluation import FEWER_SEEDS
from service.paper.measured import MeasuredRun, lines
from workers.training.fingerprint import fingerprint

FILE = "speeds.csv"
REFERENCE = "ddpg"
COLUMNS = ("processor", "environment", "timesteps", "seconds")
SHARE = 0.05
"""Of a run's timesteps, which is enough: all updates of ddpg in a task cost the same."""


@dataclass(frozen=True)
class Speed:
    """The mean processor time of a run of ddpg in a task, up to some timesteps."""

    processor: str
    environment: str
    timesteps: int
    seconds: float


Slowness = Callable[[MeasuredRun, Sequence[MeasuredRun]], float]
"""How many times slower a run's processor is than that of ddpg's runs in the same task; NaN if it
is not known."""


def slowness(folder: Path) -> Slowness:
    """Return what speeds.csv says; without the file, processors of other names are not compared."""
    known = {(speed.processor, speed.environment): speed for speed in read(folder)}

    def of(run: MeasuredRun, reference: Sequence[MeasuredRun]) -> float:
        if all(are_comparable(each.processor, run.processor) for each in reference):
            return 1.0
        speed = known.get((run.processor, run.environment))
        return speed.seconds / _seconds(reference, speed.timesteps) if speed else nan

    return of


def measure(environments: Iterable[str]) -> Iterator[Speed]:
    """Yield the speed of this machine's processor in each task, trained on one core."""
    processor = fingerprint()["processor"]
    for environment in environments:
        timesteps = preset(REFERENCE, environment).timesteps * SHARE
        end = max(1, round(timesteps / MEASURE_EVERY)) * MEASURE_EVERY
        trained = algorithms.train(REFERENCE, environment, range(FEWER_SEEDS), timesteps=end)
        seconds = [each.seconds for each in trained if each.timestep == end]
        yield Speed(processor, environment, end, float(np.mean(seconds)))


def read(folder: Path) -> list[Speed]:
    """Read speeds.csv; nothing if it is missing."""
    file = folder / FILE
    return [_speed(line) for line in lines(file)] if file.exists() else []


def write(folder: Path, measured: Iterable[Speed]) -> None:
    """Add speeds to speeds.csv, in the place of those of the same processor and task."""
    known = {(each.processor, each.environment): each for each in (*read(folder), *measured)}
    folder.mkdir(parents=True, exist_ok=True)
    with (folder / FILE).open("w", encoding="utf-8", newline="") as output:
        writer = csv.writer(output, lineterminator="\n")
        writer.writerow(COLUMNS)
        for each in known.values():
            place = (each.processor, each.environment, each.timesteps)
            writer.writerow((*place, f"{each.seconds:.4g}"))


def _speed(line: Mapping[str, str]) -> Speed:
    place = line["processor"], line["environment"], int(line["timesteps"])
    return Speed(*place, float(line["seconds"]))


def _seconds(runs: Sequence[MeasuredRun], timesteps: int) -> float:
    """The mean processor time of runs up to some timesteps, on a line between measurements."""
    columns = [run.columns for run in runs]
    return float(np.mean([np.interp(timesteps, c["timestep"], c["seconds"]) for c in columns]))
