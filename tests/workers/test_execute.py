"""Executing a cohort: what is said, when, and how it ends."""

import threading
import time
from collections.abc import Callable, Collection, Sequence

import pytest

from tests.workers.fake_learner import CYCLE, FakeLearner, measurement_of
from workers import cohort
from workers import execute as module
from workers.execute import execute
from workers.progress import Activity, Progress
from workers.random_play import measure_random_return
from workers.run_spec import RunSpec

TIMESTEPS = 10 * CYCLE
SPECS = [RunSpec("fake", "Pendulum", seed, timesteps=TIMESTEPS) for seed in (3, 5, 8)]
Before = Callable[[int], Collection[int]]


def pause(timestep: int) -> Collection[int]:
    """Keep an endless run from filling the memory."""
    del timestep
    time.sleep(0.001)
    return ()


def never() -> None:
    raise AssertionError("it was not abandoned")


def run(
    before_cycle: Before = lambda _: (),
    dropped: Callable[[], Collection[int]] = tuple,
    specs: Sequence[RunSpec] = SPECS,
) -> list[Progress]:
    """All progress of a cohort of fake runs."""
    return list(
        execute(specs, dropped, never, build_learner=lambda specs: FakeLearner(specs, before_cycle))
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


def test_the_first_has_the_fingerprint_and_no_other() -> None:
    first, *rest = run()
    assert (first.timestep, first.activity) == (0, Activity.COMPILING)
    assert first.fingerprint["code"]
    assert not any(progress.fingerprint for progress in rest)


def test_the_end_is_said_at_once() -> None:
    begun = time.monotonic()
    run()
    assert time.monotonic() - begun < module.REPORT_SECONDS / 2


def test_is_heard_while_a_kernel_compiles(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(module, "REPORT_SECONDS", 0.01)
    compiled = threading.Event()

    def compile_first(timestep: int) -> Collection[int]:
        if timestep == 0:
            assert compiled.wait(10)
        return ()

    heard = []
    for progress in execute(
        SPECS, tuple, never, build_learner=lambda specs: FakeLearner(specs, compile_first)
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
    stream = execute(SPECS, tuple, never, build_learner=lambda specs: FakeLearner(specs, fail))
    with pytest.raises(ZeroDivisionError, match="in the learner"):
        said.extend(stream)
    assert points(said, 3) == [CYCLE, 2 * CYCLE]


def test_measures_the_random_return_where_asked() -> None:
    said = list(execute(SPECS, tuple, never, measure_random_return=True, build_learner=FakeLearner))
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
    stream = execute(endless, tuple, never, build_learner=build)
    next(stream)
    next(stream)
    stream.close()
    assert not learners[0].thread.is_alive()


def test_stops_itself_when_nobody_listens(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(cohort, "PATIENCE_SECONDS", 0.2)
    abandoned = threading.Event()
    endless = [RunSpec("fake", "Pendulum", 0, timesteps=10**9)]
    stream = execute(
        endless,
        tuple,
        abandoned.set,
        build_learner=lambda specs: FakeLearner(specs, pause),
    )
    next(stream)
    next(stream)
    assert abandoned.wait(10)
    with pytest.raises(cohort.AbandonedError, match="nobody collected the news"):
        for _ in stream:
            pass
