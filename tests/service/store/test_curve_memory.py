"""The memory of curves: what is kept of ended runs, for how long, and in how many bytes."""

import numpy as np
from sqlalchemy import text

from service.store.curve_memory import OBJECTS, CurveMemory, Line
from service.store.store import Store
from tests.service.store.conftest import Submit, measured
from workers.messages.progress import Progress

LEASE = 60.0


def line(points: int) -> Line:
    return Line(np.arange(points, dtype=np.float64), np.zeros(points))


def test_the_lines_used_last_stay_within_their_bytes() -> None:
    memory = CurveMemory(3 * line(10).bytes)
    for key in "abc":
        memory.keep(key, line(10))
    memory.get("a")
    memory.keep("d", line(10))
    assert [key for key in "abcd" if memory.get(key)] == ["a", "c", "d"]
    memory.keep("larger than all", line(100))
    assert memory.get("larger than all") is None
    assert [key for key in "abcd" if memory.get(key)] == ["a", "c", "d"]
    assert line(10).bytes == 160 + OBJECTS


def returns(store: Store, sweep_id: str) -> list[list[float]]:
    [curves] = store.curves(sweep_id, ["return_mean"])
    return [curve.values.tolist() for curve in curves]


def train(store: Store, seed: int, *returns: float, finished: bool = True) -> None:
    claim = store.claim_cohort("w", LEASE, 1)
    assert claim is not None
    points = tuple(measured(seed, 800 * k, value) for k, value in enumerate(returns, start=1))
    ended = (seed,) if finished else ()
    store.record(claim, Progress(800 * len(returns), measurements=points, finished=ended))


def lose_measurements(store: Store) -> None:
    store.write(lambda connection: connection.execute(text("DELETE FROM measurements")))


def test_curves_of_ended_runs_are_read_once(store: Store, submit: Submit) -> None:
    sweep = submit(seeds=2, timesteps=1600)
    train(store, 0, -2.0, -1.0)
    train(store, 1, -3.0, finished=False)
    assert returns(store, sweep.id) == [[-2.0, -1.0], [-3.0]]
    lose_measurements(store)
    assert returns(store, sweep.id) == [[-2.0, -1.0], []]
    assert [len(c.values) for c in store.curves(sweep.id, ["return_history"])[0]] == [0, 0]


def test_a_run_that_ended_again_is_read_again(store: Store, submit: Submit) -> None:
    sweep = submit(seeds=1, timesteps=1600)
    train(store, 0, -2.0, -1.0)
    assert returns(store, sweep.id) == [[-2.0, -1.0]]
    store.extend_sweep(sweep.id, store.sweep_request(sweep.id), 3200, lambda _: 1)
    lose_measurements(store)
    assert returns(store, sweep.id) == [[]]
    train(store, 0, -2.0, -1.0, -0.5, -0.25)
    assert returns(store, sweep.id) == [[-2.0, -1.0, -0.5, -0.25]]


def test_nobody_writes_into_what_is_kept(store: Store, submit: Submit) -> None:
    sweep = submit(seeds=1, timesteps=800)
    train(store, 0, -2.0)
    [[curve]] = store.curves(sweep.id, ["return_mean"])
    assert not curve.x.flags.writeable
    assert not curve.values.flags.writeable
