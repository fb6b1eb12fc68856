"""`d3pg verify`: a stored curve against the run trained anew."""

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

import algorithms
from algorithms.early_end import DivergedError, Divergence, FailedRunsError, Failure
from algorithms.measurement import Measurement
from physics.task_file import TaskFile
from service.client import Client
from service.store.store import Store
from tests.service.cli.conftest import Command, as_json
from tests.service.training import measured, rising, train
from workers.messages.progress import Progress
from workers.messages.run_spec import RunSpec

SWEEP = {
    "algorithms": [{"name": "ddpg"}],
    "environments": ["Pendulum"],
    "seeds": 1,
    "timesteps": 1600,
}
POINT = measured(RunSpec("ddpg", "Pendulum", 0), 800, -900.0)
DIVERGED = Divergence(0, 1000, 400, "critic loss")
FAILED = Failure(0, 1000, "Traceback\nValueError: it broke\n")


@pytest.fixture
def diverged(service: Client, store: Store) -> str:
    """A run that was measured once and diverged."""
    sweep = service.submit(SWEEP).id
    claim = store.claim_cohort("worker", 60.0)
    assert claim is not None
    store.record(claim, Progress(800, measurements=(POINT,), diverged=(DIVERGED,)))
    [run] = service.runs(sweep)
    return run.id


def training(
    monkeypatch: pytest.MonkeyPatch, *points: Measurement, end: Exception | None = None
) -> None:
    """Have runs trained again come out so."""

    def train(*arguments: Any, **settings: Any) -> Iterator[Measurement]:
        del arguments, settings
        yield from points
        if end is not None:
            raise end

    monkeypatch.setattr(algorithms, "train", train)


def test_the_same_bits_are_said_to_be_the_same(
    d3pg: Command, service: Client, store: Store
) -> None:
    sweep = service.submit(SWEEP).id
    claim = store.claim_cohort("worker", 60.0)
    assert claim is not None
    spec = claim.specs[0]
    curve = tuple(
        algorithms.train("ddpg", "Pendulum", seeds=[0], timesteps=1600, config=dict(spec.config))
    )
    store.record(claim, Progress(1600, measurements=curve, finished=(0,)))
    [run] = service.runs(sweep)
    assert "all 2 measurements are the same" in d3pg("verify", run.id).stdout


def test_a_run_of_a_task_file_needs_that_file(
    d3pg: Command, service: Client, store: Store, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    file, another = tmp_path / "my_tasks.py", tmp_path / "others.py"
    file.write_text("x = 1\n")
    another.write_text("x = 2\n")
    sweep = service.submit(SWEEP).id
    claim = store.claim_cohort("worker", 60.0)
    assert claim is not None
    digest = TaskFile.read(file).digest
    store.record(
        claim,
        Progress(800, measurements=(POINT,), finished=(0,), fingerprint={"task": digest}),
    )
    [run] = service.runs(sweep)

    def refusal(*options: str) -> str:
        return str(d3pg("verify", run.id, *options, code=1).exception)

    assert "needs its task file: name it with --task" in refusal()
    told = refusal("--task", str(another))
    assert f"others.py has the hash {TaskFile.read(another).digest}, but" in told
    assert digest in told
    assert "cannot be read" in refusal("--task", "nothing.py")
    assert "defines no task" in refusal("--task", str(file))
    asked: list[str] = []

    def train(algorithm: str, environment: str, **settings: Any) -> Iterator[Measurement]:
        del algorithm, settings
        asked.append(environment)
        yield POINT

    monkeypatch.setattr(algorithms, "train", train)
    assert "all 1 measurements are the same" in d3pg("verify", run.id, "--task", str(file)).stdout
    assert asked == [f"{file}:Pendulum"]


def test_another_curve_is_told_by_its_first_difference(
    d3pg: Command, service: Client, store: Store
) -> None:
    sweep = service.submit(SWEEP).id
    train(store, 2, rising)
    [run] = service.runs(sweep)
    assert "measurement 1 of 2 and what follows differ" in d3pg("verify", run.id, code=1).stdout


def test_a_run_that_diverged_diverges_again(
    d3pg: Command, diverged: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    training(monkeypatch, POINT, end=DivergedError([DIVERGED]))
    said = d3pg("verify", diverged).stdout
    assert f"{diverged}: all 1 measurements are the same, bit for bit." in said
    assert "it ended as before: diverged: critic loss not finite at update 400" in said


@pytest.mark.parametrize(
    ("end", "said"),
    [
        (None, "it trains beyond its divergence, at timestep 1,000"),
        (
            DivergedError([Divergence(0, 900, 350, "critic loss")]),
            "trained again, it diverged: critic loss not finite at update 350, timestep 900; "
            "as stored, it is diverged, at timestep 1,000",
        ),
        (
            FailedRunsError([FAILED], []),
            "trained again, it failed at timestep 1,000: ValueError: it broke; "
            "as stored, it is diverged, at timestep 1,000",
        ),
    ],
)
def test_another_end_is_told(
    d3pg: Command,
    diverged: str,
    monkeypatch: pytest.MonkeyPatch,
    end: Exception | None,
    said: str,
) -> None:
    more = [measured(RunSpec("ddpg", "Pendulum", 0), 1600, -800.0)] if end is None else []
    training(monkeypatch, POINT, *more, end=end)
    output = d3pg("verify", diverged, code=1).stdout
    assert "all 1 measurements are the same" in output
    assert said in output


def test_a_run_that_reached_its_end_and_diverges_now_differs(
    d3pg: Command, service: Client, store: Store, monkeypatch: pytest.MonkeyPatch
) -> None:
    sweep = service.submit(SWEEP).id
    train(store, 2, lambda _spec, timestep: -900.0 if timestep == 800 else 0.0)
    [run] = service.runs(sweep)
    training(monkeypatch, POINT, end=DivergedError([DIVERGED]))
    output = d3pg("verify", run.id, code=1).stdout
    assert "measurement 2 of 2 and what follows differ" in output
    assert "trained again, it diverged" in output
    assert "as stored, it is succeeded, at timestep 1,600" in output


def test_what_cannot_be_compared_is_a_sentence(
    d3pg: Command, service: Client, store: Store, monkeypatch: pytest.MonkeyPatch
) -> None:
    sweep = service.submit(SWEEP).id
    [run] = service.runs(sweep)
    error = d3pg("verify", run.id, code=1).exception
    assert str(error) == f"{run.id} is queued and has measured nothing to compare with."
    train(store, 1, rising)
    training(monkeypatch, end=ValueError("there is no algorithm 'ddpg'"))
    error = d3pg("verify", run.id, code=1).exception
    assert str(error) == f"{run.id} cannot be trained here: there is no algorithm 'ddpg'"


def test_a_verdict_for_programs(
    d3pg: Command, diverged: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    training(monkeypatch, POINT, end=DivergedError([DIVERGED]))
    verdict = as_json(d3pg("verify", diverged, "--json"))
    assert (verdict["run"], verdict["is_same"], verdict["measurements"]) == (diverged, True, 1)
    other = measured(RunSpec("ddpg", "Pendulum", 0), 800, -901.0)
    training(monkeypatch, other, end=DivergedError([DIVERGED]))
    verdict = as_json(d3pg("verify", diverged, "--json", code=1))
    assert (verdict["is_same"], verdict["first_mismatch"]) == (False, 0)
