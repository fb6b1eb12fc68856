"""The diagnoser: what waits is made in its order, and each failure is a sentence."""

import threading
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from service.api.diagnoser import Diagnoser
from service.api.load.side_process import SideProcess, TooSlowError
from service.model.diagnosis import Diagnosis
from service.model.run import Run
from service.store.store import Store
from service.task_shelf import TaskShelf
from tests.service.found import findings
from tests.service.training import rising, train
from workers.checkpoints.folder import UnavailableError
from workers.checkpoints.sealed_file import DamagedError
from workers.messages.run_spec import RunSpec

Answer = Callable[[RunSpec], Any]


class FakeSide:
    """Answers as a test says, and signals each call and that it was closed."""

    def __init__(self, answer: Answer) -> None:
        self.answer = answer
        self.asked: list[int] = []
        self.closed = threading.Event()

    def call(self, function: str, *arguments: Any) -> Any:
        assert function == "workers.policies.diagnosis:diagnosis"
        _, _, spec, _ = arguments
        self.asked.append(spec.seed)
        return self.answer(spec)

    def close(self) -> None:
        self.closed.set()


def ended(store: Store, version: int = 1) -> list[Run]:
    """Two runs that have ended."""
    specs = [RunSpec("ddpg", "Pendulum", seed, timesteps=800) for seed in (0, 1)]
    request = {"algorithms": [{"name": "ddpg"}], "environments": ["Pendulum"], "seeds": 2}
    sweep = store.create_sweep("s", 0, request, specs, environment_versions={"Pendulum": version})
    train(store, 1, rising)
    return store.list_runs(sweep.id)


def test_what_waits_is_made_in_its_order(store: Store, tmp_path: Path) -> None:
    runs = ended(store)
    side = FakeSide(lambda spec: findings(spec.seed))
    diagnoser = Diagnoser(store, tmp_path, side, TaskShelf(tmp_path))
    diagnoser.ask(runs)
    diagnoser.work()
    assert side.asked == [0, 1]
    for run in runs:
        assert store.find_diagnosis(run.id) == Diagnosis(run, False, tuple(findings(run.spec.seed)))


@pytest.mark.parametrize(
    ("error", "sentence"),
    [
        (
            TooSlowError("it took longer than 300 s"),
            "is not available now: it took longer than 300 s.",
        ),
        (EOFError(), "cannot be used now: the process that used it died."),
        (DamagedError("its digest differs"), "What run RUN learned cannot be read: its digest"),
        (UnavailableError(5, "the disk is gone"), "cannot be read now: the disk is gone."),
        (ArithmeticError("no step at [0, 1]"), "failed: no step at [0, 1]"),
        (None, "Run RUN (succeeded) has no policy"),
    ],
)
def test_each_failure_is_a_sentence_and_keeps_no_other_from_being_made(
    store: Store, tmp_path: Path, error: Exception | None, sentence: str
) -> None:
    first, second = ended(store)

    def answer(spec: RunSpec) -> Any:
        if spec.seed == 1:
            return findings()
        if error is None:
            return None
        raise error

    diagnoser = Diagnoser(store, tmp_path, FakeSide(answer), TaskShelf(tmp_path))
    diagnoser.ask([first, second])
    diagnoser.work()
    assert sentence.replace("RUN", first.id) in store.find_diagnosis(first.id).problem
    assert store.find_diagnosis(second.id).findings


def test_of_another_version_of_the_task_nothing_is_made(store: Store, tmp_path: Path) -> None:
    run, _ = ended(store, version=999)
    side = FakeSide(lambda _: findings())
    diagnoser = Diagnoser(store, tmp_path, side, TaskShelf(tmp_path))
    diagnoser.ask([run])
    diagnoser.work()
    assert "learned in version 999 of Pendulum" in store.find_diagnosis(run.id).problem
    assert side.asked == []


def test_its_thread_makes_what_an_earlier_service_left_and_what_is_asked(
    store: Store, tmp_path: Path
) -> None:
    first, second = ended(store)
    made = {run.spec.seed: threading.Event() for run in (first, second)}

    def answer(spec: RunSpec) -> Any:
        made[spec.seed].set()
        return findings()

    Diagnoser(store, tmp_path, FakeSide(answer), TaskShelf(tmp_path)).ask([first])
    diagnoser = Diagnoser(store, tmp_path, FakeSide(answer), TaskShelf(tmp_path))
    diagnoser.start()
    assert made[0].wait(60)
    diagnoser.ask([second])
    assert made[1].wait(60)
    diagnoser.stop()


def test_one_that_is_stopped_leaves_what_is_under_way_waiting(store: Store, tmp_path: Path) -> None:
    run, _ = ended(store)
    begun = threading.Event()

    def answer(_: RunSpec) -> Any:
        begun.set()
        assert side.closed.wait(60)
        raise EOFError

    side = FakeSide(answer)
    diagnoser = Diagnoser(store, tmp_path, side, TaskShelf(tmp_path))
    diagnoser.ask([run])
    diagnoser.start()
    assert begun.wait(60)
    diagnoser.stop()
    assert store.find_diagnosis(run.id) == Diagnosis(run, is_waiting=True)


def test_one_that_never_started_stops_too(store: Store, tmp_path: Path) -> None:
    Diagnoser(store, tmp_path, SideProcess(), TaskShelf(tmp_path)).stop()
