"""Executing a cohort: what is said, when, and how it ends."""

import errno
import math
import os
import threading
import time
from collections.abc import Callable, Collection, Sequence
from contextlib import suppress
from functools import partial
from pathlib import Path

import numpy as np
import pytest

from algorithms.networks.policy import deterministic
from algorithms.snapshot import Inside, Snapshot
from physics.task_file import TaskFile
from tests.object_store import ObjectStore
from tests.physics.test_task_file import ARM
from tests.workers.fake_learner import CYCLE, FakeLearner, measurement_of
from workers.checkpoints import bucket, sealed_file
from workers.checkpoints.checkpoint import find_snapshot
from workers.checkpoints.disk_folder import DiskFolder
from workers.checkpoints.folder import UnreachableError
from workers.checkpoints.place import Place
from workers.messages.assignment import Assignment
from workers.messages.progress import Activity, Progress, Resumption
from workers.messages.run_spec import RunSpec
from workers.messages.work import REPORT_SECONDS
from workers.training import cadence, cohort_thread
from workers.training.execute import execute
from workers.training.random_play import measure_random_return

TIMESTEPS = 10 * CYCLE
SPECS = [RunSpec("fake", "Pendulum", seed, timesteps=TIMESTEPS) for seed in (3, 5, 8)]
NOWHERE = Path("/nowhere")
"""For runs too short for a checkpoint."""
Before = Callable[[int], Collection[int]]


def pause(timestep: int) -> Collection[int]:
    """Keep an endless run from filling the memory."""
    del timestep
    time.sleep(0.001)
    return ()


def assigned(specs: Sequence[RunSpec]) -> list[Assignment]:
    return [Assignment(f"run-{spec.seed}", 1, spec, 1) for spec in specs]


RUNS = assigned(SPECS)


def never() -> None:
    raise AssertionError("it was not abandoned")


def run(
    before_cycle: Before = lambda _: (),
    dropped: Callable[[], Collection[int]] = tuple,
    specs: Sequence[RunSpec] = SPECS,
) -> list[Progress]:
    """All progress of a cohort of fake runs."""
    return list(
        execute(
            assigned(specs),
            NOWHERE,
            dropped,
            never,
            build_learner=lambda specs: FakeLearner(specs, before_cycle),
        )
    )


def points(said: Sequence[Progress], seed: int) -> list[int]:
    """The timesteps at which a seed was measured, each with the value it has there."""
    found = [m for progress in said for m in progress.measurements if m.seed == seed]
    assert found == [measurement_of(seed, m.timestep) for m in found]
    return [m.timestep for m in found]


def test_every_measurement_is_said_once() -> None:
    said = run()
    for spec in SPECS:
        assert points(said, spec.seed) == list(range(CYCLE, TIMESTEPS + 1, CYCLE))
    assert [seed for progress in said for seed in progress.finished] == [3, 5, 8]
    assert said[-1].timestep == TIMESTEPS


def test_one_has_the_fingerprint_and_where_all_began() -> None:
    said = run()
    assert (said[0].timestep, said[0].activity) == (0, Activity.COMPILING)
    [begun] = [progress for progress in said if progress.fingerprint]
    assert begun.fingerprint["code"]
    assert begun.resumed == tuple(Resumption(seed, 0) for seed in (3, 5, 8))


def test_the_end_is_said_at_once() -> None:
    begun = time.monotonic()
    run()
    assert time.monotonic() - begun < REPORT_SECONDS / 2


def test_what_was_dropped_is_said_at_once() -> None:
    said = threading.Event()

    def wait_for_the_word(timestep: int) -> Collection[int]:
        assert timestep < 2 * CYCLE or said.wait(10)
        return ()

    for progress in execute(
        assigned(SPECS),
        NOWHERE,
        lambda: {5},
        never,
        report_seconds=60.0,
        build_learner=lambda specs: FakeLearner(specs, wait_for_the_word),
    ):
        if progress.dropped:
            said.set()
    assert said.is_set()


def test_is_heard_while_a_kernel_compiles() -> None:
    compiled = threading.Event()

    def compile_first(timestep: int) -> Collection[int]:
        if timestep == 0:
            assert compiled.wait(10)
        return ()

    heard = []
    for progress in execute(
        assigned(SPECS),
        NOWHERE,
        tuple,
        never,
        report_seconds=0.01,
        build_learner=lambda specs: FakeLearner(specs, compile_first),
    ):
        heard.append(progress)
        if len(heard) == 5:
            compiled.set()
    assert {progress.activity for progress in heard[:5]} == {Activity.COMPILING}
    assert not any(progress.measurements for progress in heard[:5])
    assert heard[-1].activity is Activity.TRAINING


def test_dropped_seeds_leave_and_the_others_do_not_feel_it() -> None:
    to_drop: set[int] = set()

    def drop_later(timestep: int) -> Collection[int]:
        if timestep == 3 * CYCLE:
            to_drop.add(5)
        return ()

    said = run(drop_later, lambda: to_drop)
    assert points(said, 5) == [CYCLE, 2 * CYCLE, 3 * CYCLE, 4 * CYCLE]
    assert [seed for progress in said for seed in progress.dropped] == [5]
    assert [seed for progress in said for seed in progress.finished] == [3, 8]
    assert points(said, 8) == points(run(), 8)


def test_ends_when_all_were_dropped() -> None:
    said = run(dropped=lambda: {3, 5, 8, 13})
    assert [seed for progress in said for seed in progress.dropped] == [3, 5, 8]
    assert not any(progress.measurements or progress.finished for progress in said)


def test_diverged_seeds_leave() -> None:
    said = run(lambda timestep: {8} if timestep == 2 * CYCLE else ())
    [divergence] = [entry for progress in said for entry in progress.diverged]
    assert (divergence.seed, divergence.timestep) == (8, 3 * CYCLE)
    assert points(said, 8) == [CYCLE, 2 * CYCLE]
    assert [seed for progress in said for seed in progress.finished] == [3, 5]


def test_an_error_comes_after_what_was_measured_before_it() -> None:
    def fail(timestep: int) -> Collection[int]:
        if timestep == 2 * CYCLE:
            raise ZeroDivisionError("in the learner")
        return ()

    said: list[Progress] = []
    stream = execute(
        RUNS, NOWHERE, tuple, never, build_learner=lambda specs: FakeLearner(specs, fail)
    )
    with pytest.raises(ZeroDivisionError, match="in the learner"):
        said.extend(stream)
    assert points(said, 3) == [CYCLE, 2 * CYCLE]


def test_runs_train_on_where_the_random_return_cannot_be_measured(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    def refuse(environment: str, **file: None) -> None:
        raise RuntimeError(f"no start in {environment}")

    monkeypatch.setattr("workers.training.execute.measure", refuse)
    said = list(
        execute(RUNS, NOWHERE, tuple, never, measure_random_return=True, build_learner=FakeLearner)
    )
    assert {p.random_return for p in said} == {None}
    assert [seed for p in said for seed in p.finished] == [3, 5, 8]
    notes = [each.note for p in said for each in p.resumed]
    assert len(notes) == 3
    assert all("not normalised: RuntimeError: no start in Pendulum" in note for note in notes)


def test_measures_the_random_return_where_asked() -> None:
    said = list(
        execute(
            assigned(SPECS),
            NOWHERE,
            tuple,
            never,
            measure_random_return=True,
            build_learner=FakeLearner,
        )
    )
    measured = [p.random_return for p in said if p.random_return is not None]
    assert measured == [measure_random_return("Pendulum")]


def test_refuses_what_is_no_cohort() -> None:
    with pytest.raises(ValueError, match="distinct"):
        run(specs=[SPECS[0], SPECS[0]])


def test_stops_training_when_its_stream_is_closed() -> None:
    learners: list[FakeLearner] = []

    def build(specs: Sequence[RunSpec]) -> FakeLearner:
        learners.append(FakeLearner(specs, pause))
        return learners[0]

    endless = [RunSpec("fake", "Pendulum", 0, timesteps=10**9)]
    stream = execute(assigned(endless), NOWHERE, tuple, never, build_learner=build)
    next(stream)
    next(stream)
    stream.close()
    assert not learners[0].thread.is_alive()


def test_stops_itself_when_nobody_listens(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(cohort_thread, "UNCOLLECTED_SECONDS", 0.2)
    abandoned = threading.Event()
    endless = [RunSpec("fake", "Pendulum", 0, timesteps=10**9)]
    stream = execute(
        assigned(endless),
        NOWHERE,
        tuple,
        abandoned.set,
        build_learner=lambda specs: FakeLearner(specs, pause),
    )
    next(stream)
    next(stream)
    assert abandoned.wait(10)
    with pytest.raises(cohort_thread.AbandonedError, match="the news was not collected"):
        for _ in stream:
            pass


class CutError(Exception):
    """The end of a worker."""


def cut_at(cycle: int) -> Before:
    def cut(timestep: int) -> Collection[int]:
        if timestep == cycle * CYCLE:
            raise CutError
        return ()

    return cut


def attempts_of(
    root: Place, cuts: Sequence[int], specs: Sequence[RunSpec] = SPECS, *, is_last: bool = True
) -> list[list[Progress]]:
    """What is said in one attempt after the other, each cut before a cycle, the last one not."""
    befores = [*map(cut_at, cuts), *([lambda _: ()] if is_last else [])]
    said: list[list[Progress]] = []
    for attempt, before in enumerate(befores, start=1):
        runs = [Assignment(f"run-{spec.seed}", attempt, spec, 1) for spec in specs]
        build = partial(FakeLearner, before_cycle=before)
        said.append([])
        with suppress(CutError):
            said[-1].extend(execute(runs, root, tuple, never, build_learner=build))
    return said


@pytest.fixture
def hasty(monkeypatch: pytest.MonkeyPatch) -> None:
    """A checkpoint after every cycle."""
    monkeypatch.setattr(cadence, "SHORTEST_SECONDS", 0.0)
    monkeypatch.setattr(cadence, "SHARE", math.inf)


@pytest.mark.usefixtures("hasty")
def test_a_run_is_taken_up_at_its_checkpoint_with_all_it_had_measured(place: Place) -> None:
    first, second, third = attempts_of(place, [4, 7])
    assert [r.timestep for p in first for r in p.resumed] == [0, 0, 0]
    assert {c.timestep for p in first for c in p.checkpoints} == {100, 200, 300, 400}
    for said, timestep in ((second, 400), (third, 700)):
        [begun] = [p for p in said if p.resumed]
        assert begun.resumed == tuple(Resumption(seed, timestep) for seed in (3, 5, 8))
        assert begun.fingerprint["code"]
        assert points([begun], 5)[: timestep // CYCLE] == list(range(CYCLE, timestep + 1, CYCLE))
    assert points(third, 8) == list(range(CYCLE, TIMESTEPS + 1, CYCLE))


@pytest.mark.usefixtures("hasty")
def test_runs_left_at_other_timesteps_are_trained_group_by_group(tmp_path: Path) -> None:
    attempts_of(tmp_path, [4], SPECS[:1], is_last=False)
    attempts_of(tmp_path, [7], SPECS[1:2], is_last=False)
    [said] = attempts_of(tmp_path, [])
    [begun] = [p for p in said if p.resumed]
    assert [(r.seed, r.timestep) for r in begun.resumed] == [(3, 400), (5, 700), (8, 0)]
    for spec in SPECS:
        assert points(said, spec.seed) == list(range(CYCLE, TIMESTEPS + 1, CYCLE))
    assert [seed for p in said for seed in p.finished] == [5, 3, 8]
    assert all(len(p.training) == 1 for p in said if p.activity is Activity.TRAINING)


@pytest.mark.usefixtures("hasty")
def test_a_run_that_waits_for_its_group_can_be_dropped(tmp_path: Path) -> None:
    attempts_of(tmp_path, [4], SPECS[:1], is_last=False)
    said = list(execute(RUNS, tmp_path, lambda: {8}, never, build_learner=FakeLearner))
    assert [seed for p in said for seed in p.dropped] == [8]
    assert [seed for p in said for seed in p.finished] == [3, 5]


@pytest.mark.usefixtures("hasty")
def test_a_checkpoint_that_does_not_fit_is_told_and_training_goes_on(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def full(*_: object) -> None:
        raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))

    monkeypatch.setattr(sealed_file, "write", full)
    [said] = attempts_of(tmp_path, [])
    assert [seed for p in said for seed in p.finished] == [3, 5, 8]
    problems = {c.problem for p in said for c in p.checkpoints if c.timestep == 300}
    assert problems == {"its checkpoint of step 300 could not be written: No space left on device"}


def test_what_was_learned_by_the_end_is_left_where_its_place_answers_late(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(cohort_thread, "AGAIN_SECONDS", 0.001)
    unit = np.ones(3, np.float32)
    learned = Snapshot(TIMESTEPS, 1, Inside((8, 8), "tanh"), deterministic(unit, unit, unit, 1))
    monkeypatch.setattr(FakeLearner, "snapshot", lambda self, seed: learned)
    silences, write = [8], DiskFolder.write

    def write_late(folder: DiskFolder, name: str, content: bytes) -> None:
        if silences[0] == 0:
            return write(folder, name, content)
        silences[0] -= 1
        raise UnreachableError(errno.EHOSTUNREACH, "the store does not answer")

    monkeypatch.setattr(DiskFolder, "write", write_late)
    [said] = attempts_of(tmp_path, [])
    assert not any(c.problem for p in said for c in p.checkpoints)
    assert all(find_snapshot(tmp_path, f"run-{spec.seed}") for spec in SPECS)
    monkeypatch.setattr(cohort_thread, "NO_ANSWER_SECONDS", 0.0)
    silences[0] = 10**9
    [said] = attempts_of(tmp_path, [])
    assert {c.problem for p in said for c in p.checkpoints} == {
        "what it has learned could not be written: the store does not answer"
    }


@pytest.mark.usefixtures("hasty", "fresh_clients")
def test_a_bucket_that_is_gone_for_a_while_is_told_and_costs_its_checkpoints_alone(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    store = ObjectStore()
    store.start()
    for name, value in store.environment.items():
        monkeypatch.setenv(name, value)
    monkeypatch.setattr(bucket, "SILENCE_SECONDS", 0.0)
    url = store.new_bucket()

    def stop_and_start(timestep: int) -> Collection[int]:
        if timestep == 2 * CYCLE:
            store.stop()
        if timestep == 3 * CYCLE:
            store.start()
        return cut_at(5)(timestep)

    said: list[Progress] = []
    build = partial(FakeLearner, before_cycle=stop_and_start)
    with suppress(CutError):
        said.extend(execute(RUNS, url, tuple, never, build_learner=build))
    problems = {(c.timestep, c.problem) for p in said for c in p.checkpoints}
    assert {(timestep, problem.partition(":")[0]) for timestep, problem in problems} == {
        *((timestep, "") for timestep in (100, 200, 400, 500)),
        (300, "its checkpoint of step 300 could not be written"),
    }
    assert all("AWS_ENDPOINT_URL" in problem for _, problem in problems if problem)
    second = [Assignment(f"run-{spec.seed}", 2, spec, 1) for spec in SPECS]
    said = list(execute(second, url, tuple, never, build_learner=FakeLearner))
    assert {r.timestep for p in said for r in p.resumed} == {500}
    for spec in SPECS:
        assert points(said, spec.seed) == list(range(CYCLE, TIMESTEPS + 1, CYCLE))
    store.stop()


def test_a_task_of_a_file_is_trained_from_the_text_that_comes_with_it(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    file = TaskFile("my_tasks.py", ARM)
    specs = [RunSpec("mpc", "Arm(stiffness=2)", 0, timesteps=1)]
    said = list(
        execute(assigned(specs), NOWHERE, tuple, never, file=file, measure_random_return=True)
    )
    assert [seed for p in said for seed in p.finished] == [0]
    assert {p.fingerprint["task"] for p in said if p.fingerprint} == {file.digest}
    (measured,) = [p.random_return for p in said if p.random_return]
    assert (measured.environment, measured.version) == ("Arm(stiffness=2)", file.version)
    (tmp_path / "d3pg" / "tasks" / file.digest / "my_tasks.py").write_text(ARM + "\n")
    with pytest.raises(ValueError, match=rf"has the hash \w+, but the service's .*{file.digest}"):
        list(execute(assigned(specs), NOWHERE, tuple, never, file=file))
