"""Measurements: exact, once each, and fast as columns."""

import math
import struct
from dataclasses import replace

from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from algorithms.early_end import Divergence
from algorithms.measurement import Measurement
from service.model.claim import Claim
from service.model.run import RunStatus
from service.store.store import Store
from tests.service.store.conftest import Submit, measured
from workers.messages.progress import Progress
from workers.messages.random_return import RandomReturn

LEASE = 60.0
FLOATS = st.floats(width=64)  # NaN and both infinities too


def claimed(store: Store, submit: Submit, seeds: int = 1) -> Claim:
    submit(seeds=seeds, timesteps=80_000)
    claim = store.claim_cohort("w", LEASE)
    assert claim is not None
    return claim


def bits(value: float) -> bytes:
    """The value's bits; all NaNs are one (NULL has no payload), and SQLite keeps one zero."""
    return b"NaN" if math.isnan(value) else struct.pack("<d", value + 0.0)


@settings(
    suppress_health_check=[HealthCheck.function_scoped_fixture], max_examples=25, deadline=None
)
@given(
    numbers=st.tuples(FLOATS, FLOATS, FLOATS, FLOATS),
    counts=st.tuples(st.integers(0, 2**63 - 1), st.integers(0, 2**63 - 1)),
    diagnostics=st.dictionaries(st.text(st.characters(codec="utf-8")), FLOATS, max_size=5),
)
def test_every_number_comes_back_as_it_was(
    store: Store,
    submit: Submit,
    numbers: tuple[float, float, float, float],
    counts: tuple[int, int],
    diagnostics: dict[str, float],
) -> None:
    claim = claimed(store, submit)
    put = Measurement(0, 800, numbers[0], numbers[1], *counts, numbers[2], diagnostics, numbers[3])
    store.record(claim, Progress(800, measurements=(put,)))
    [got] = store.measurements(claim.runs[0].run_id)
    assert (got.seed, got.timestep, got.updates, got.jacobians) == (0, 800, *counts)
    floats = (got.return_mean, got.return_history, got.seconds, got.compile_seconds)
    assert [bits(value) for value in floats] == [bits(value) for value in numbers]
    assert list(got.diagnostics) == list(diagnostics)
    assert [bits(value) for value in got.diagnostics.values()] == [
        bits(value) for value in diagnostics.values()
    ]
    sweep_id = claim.runs[0].run_id.partition("-")[0]
    [[curve]] = store.curves(sweep_id, ["return_mean"])
    assert bits(curve.values[0]) == bits(numbers[0])
    store.record(claim, Progress(800, finished=(0,)))


def test_a_measurement_is_stored_once(store: Store, submit: Submit) -> None:
    claim = claimed(store, submit)
    first = tuple(measured(0, timestep) for timestep in (800, 1600))
    replay = (*(replace(each, return_mean=9.0) for each in first), measured(0, 2400))
    store.record(claim, Progress(1600, measurements=first))
    store.record(claim, Progress(2400, measurements=replay))
    store.record(claim, Progress(2400, measurements=(measured(0, 2400), measured(0, 2400))))
    assert store.measurements(claim.runs[0].run_id) == [*first, measured(0, 2400)]
    told = [event.payload for event in store.events_after(0) if event.kind == "measurements"]
    assert [(entry["from"], entry["to"]) for entry in told] == [(800, 1600), (2400, 2400)]


def test_measurements_go_to_their_seeds_run(store: Store, submit: Submit) -> None:
    claim = claimed(store, submit, seeds=3)
    taken = tuple(measured(seed, 800, -float(seed)) for seed in (2, 0, 1))
    store.record(claim, Progress(800, measurements=taken))
    values = [store.measurements(run.run_id)[0].return_mean for run in claim.runs]
    assert values == [0.0, -1.0, -2.0]


def test_seeds_of_nobody_are_ignored(store: Store, submit: Submit) -> None:
    claim = claimed(store, submit)
    strange = Progress(
        800,
        measurements=(measured(5, 800),),
        finished=(6,),
        diverged=(Divergence(7, 800, 400, "critic loss"),),
        dropped=(8,),
    )
    assert store.record(claim, strange) == {claim.runs[0].run_id}
    assert store.measurements(claim.runs[0].run_id) == []


def test_a_diverged_run_ends_with_its_curve_and_a_sentence(store: Store, submit: Submit) -> None:
    claim = claimed(store, submit, seeds=2)
    lost = Divergence(1, 1234, 617, "critic loss")
    news = Progress(1300, measurements=(measured(1, 800),), diverged=(lost,))
    assert store.record(claim, news) == {claim.runs[0].run_id}
    run = store.find_run(claim.runs[1].run_id)
    assert run is not None
    assert (run.status, run.timestep) == (RunStatus.DIVERGED, 1234)
    assert run.reason == "critic loss stopped being finite at update 617, timestep 1234"
    assert store.measurements(run.id) == [measured(1, 800)]


def test_progress_shows_where_a_run_stands(store: Store, submit: Submit) -> None:
    claim = claimed(store, submit)
    store.record(claim, Progress(700, fingerprint={"numpy": "2"}))
    run = store.find_run(claim.runs[0].run_id)
    assert run is not None
    assert (run.timestep, run.fingerprint) == (700, {"numpy": "2"})
    assert store.attempts(run.id)[0].fingerprint == {"numpy": "2"}
    store.record(claim, Progress(79_900, finished=(0,)))
    ended = store.find_run(run.id)
    assert ended is not None
    assert (ended.timestep, ended.fingerprint) == (80_000, {"numpy": "2"})


def test_a_curve_is_of_one_fingerprint(store: Store, submit: Submit) -> None:
    """Another machine gives other bits: what an attempt there began with replaces the old curve."""
    claim = claimed(store, submit)
    run_id = claim.runs[0].run_id
    early = tuple(measured(0, timestep) for timestep in (800, 1600))
    store.record(claim, Progress(1600, measurements=early, fingerprint={"cpu": "a"}))
    store.lose(claim, "its worker was lost")
    same = store.claim_cohort("w", LEASE)
    assert same is not None
    store.record(same, Progress(0, fingerprint={"cpu": "a"}))
    assert store.measurements(run_id) == list(early)
    store.lose(same, "its worker was lost")
    other = store.claim_cohort("w", LEASE)
    assert other is not None
    store.record(other, Progress(0, fingerprint={"cpu": "b"}))
    assert store.measurements(run_id) == []


def test_random_returns_are_kept_per_version(store: Store, submit: Submit) -> None:
    first = RandomReturn("Pendulum", 1, -1232.6, -1250.3, -1214.9, 1000)
    second = replace(first, version=2, mean=-1200.0)
    store.record_random_return(first)
    store.record_random_return(first)
    store.record(claimed(store, submit), Progress(0, random_return=second))
    assert store.random_returns() == {("Pendulum", 1): first, ("Pendulum", 2): second}
