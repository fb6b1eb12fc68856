"""Reports: each survives its trip as a line, every bit of it."""

import math
import struct
from dataclasses import asdict

import pytest
from hypothesis import given
from hypothesis import strategies as st

from algorithms.early_end import Divergence
from algorithms.measurement import Measurement
from physics.task_file import TaskFile
from workers.messages.assignment import Assignment
from workers.messages.progress import Activity, CheckpointAttempt, Progress, Resumption
from workers.messages.random_return import RandomReturn
from workers.messages.report import (
    Busy,
    Capacity,
    Ended,
    Failed,
    Lost,
    News,
    Ready,
    Report,
    Retired,
    from_line,
    heading,
    to_line,
)
from workers.messages.run_spec import RunSpec, Weights
from workers.messages.work import Work

COUNTS = st.integers(0, 2**53)
MEASUREMENTS = st.builds(
    Measurement,
    seed=COUNTS,
    timestep=COUNTS,
    return_mean=st.floats(),
    return_history=st.floats(),
    updates=COUNTS,
    jacobians=COUNTS,
    seconds=st.floats(),
    diagnostics=st.dictionaries(st.text(), st.floats()),
    compile_seconds=st.floats(),
)


RUNS = (
    Assignment("a-0", 1, RunSpec("ddpg", "Pendulum", 0), 1),
    Assignment("a-1", 2, RunSpec("sac", "Acrobot", 7, Weights(0.1, 0.0), 800, {"noise": 1.0}), 3),
)


@pytest.mark.parametrize(
    "report",
    [
        Ready("worker-1", 4711, "here"),
        News("worker-1", "a-0/1", Progress(800, log_tail="one\nzwei ü\n")),
        Busy("worker-1", Work("a-0/1", RUNS, measure_random_return=True, report_seconds=5.0)),
        Busy("worker-1", Work("a-0/1", RUNS, file=TaskFile("my_tasks.py", "x = 'ü'\n"))),
        Ended("worker-1", "a-0/1"),
        Failed("worker-1", "a-0/1", "Traceback\nValueError: 'ü'\n", "a\nb"),
        Lost("worker-1", "killed", ""),
        Retired("worker-1"),
        Capacity(3, slots=2),
        News(
            "worker-1",
            "a-0/1",
            Progress(
                1600,
                Activity.COMPILING,
                diverged=(Divergence(1, 1500, 750, "critic loss"),),
                training=(1, 2, 3, 4),
                finished=(2, 3),
                dropped=(4,),
                resumed=(Resumption(2, 800, ("numpy was 2.3, now 2.4",), "not comparable"),),
                checkpoints=(CheckpointAttempt(2, 1600, "the disk is full"),),
                bytes_per_run=1_000_000,
                fingerprint={"numpy": "2.4", "blas": ["openblas 1"]},
                random_return=RandomReturn("Pendulum", 1, -1.5, -2.0, -1.0, 1000),
            ),
        ),
    ],
)
def test_survives_as_a_line(report: Report) -> None:
    line = to_line(report)
    assert "\n" not in line
    assert from_line(line) == report
    assert from_line(line.encode()) == report
    assert heading(line).kind == type(report).__name__.lower()
    assert heading(line).worker == getattr(report, "worker", "-")


@given(st.lists(MEASUREMENTS, max_size=3))
def test_measurements_survive_bit_for_bit(measurements: list[Measurement]) -> None:
    report = from_line(to_line(News("w", "a-0/1", Progress(0, measurements=tuple(measurements)))))
    assert isinstance(report, News)
    assert [bits_of(m) for m in report.progress.measurements] == [bits_of(m) for m in measurements]


def bits_of(measurement: Measurement) -> list[object]:
    """All fields, floats as their bits (all NaNs alike)."""
    fields = asdict(measurement)
    numbers = {**fields.pop("diagnostics"), **{f"{k} ": v for k, v in fields.items()}}
    return [
        (name, "NaN" if math.isnan(value) else struct.pack("<d", value))
        for name, value in numbers.items()
    ]


def test_what_an_earlier_version_left_to_read_has_no_compile_seconds() -> None:
    """It may have trained on while the service was brought up to date."""
    point = Measurement(0, 800, -1.0, -1.0, 400, 0, 0.1, {}, 0.25)
    line = to_line(News("w", "a-0/1", Progress(800, measurements=(point,))))
    report = from_line(line.replace(', "compile_seconds": 0.25', ""))
    assert isinstance(report, News)
    [found] = report.progress.measurements
    assert math.isnan(found.compile_seconds)
    assert (found.timestep, found.seconds) == (800, 0.1)
