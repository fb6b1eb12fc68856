"""Curves: a metric of every run, as arrays, in pieces of any size."""

import math
from dataclasses import replace

import numpy as np
import pytest

from service.analysis.statistics.score import SCORES
from service.store.reading import curves as module
from service.store.store import Store
from tests.service.store.conftest import Submit, measured
from workers.messages.progress import Progress
from workers.messages.run_spec import RunSpec

LEASE = 60.0


def test_curves_are_columns_of_every_run(store: Store, submit: Submit) -> None:
    sweep = submit(seeds=3, timesteps=80_000)
    claim = store.claim_cohort("w", LEASE, 2)
    assert claim is not None
    taken = tuple(measured(1, timestep, -timestep / 7) for timestep in (800, 1600, 2400))
    store.record(claim, Progress(2400, measurements=taken[1:]))
    store.record(claim, Progress(2400, measurements=taken[:1]))
    submit(seeds=1)
    for metric, expected in (
        ("return_mean", [m.return_mean for m in taken]),
        ("return_history", [m.return_history for m in taken]),
        ("critic_loss", [m.diagnostics["critic_loss"] for m in taken]),
    ):
        [curves] = store.curves(sweep.id, [metric])
        assert [curve.values.tolist() for curve in curves] == [[], expected, []]
    assert [curve.spec.seed for curve in curves] == [0, 1, 2]
    assert [curve.status for curve in curves] == ["running", "running", "queued"]
    abscissae: tuple[tuple[str, list[float]], ...] = (
        ("timesteps", [800, 1600, 2400]),
        ("updates", [400, 800, 1200]),
        ("jacobians", [2400, 4800, 7200]),
        ("seconds", [0.8, 1.6, 2.4]),
    )
    for x, places in abscissae:
        assert store.curves(sweep.id, ["return_mean"], x)[0][1].x.tolist() == places
    assert store.curves(sweep.id, ["no such metric"])[0][1].values.tolist() == []
    assert store.curves("no sweep", ["return_mean"]) == [[]]
    with pytest.raises(ValueError, match="timesteps, updates, jacobians, seconds"):
        store.curves(sweep.id, ["return_mean"], "days")


def test_curves_have_the_processor_of_their_run(store: Store, submit: Submit) -> None:
    sweep = submit(seeds=2)
    claim = store.claim_cohort("w", LEASE, 1)
    assert claim is not None
    store.record(claim, Progress(0, fingerprint={"processor": "znver5"}))
    [curves] = store.curves(sweep.id, ["return_mean"], "seconds")
    assert [curve.processor for curve in curves] == ["znver5", ""]


def test_runs_may_measure_different_diagnostics(store: Store, submit: Submit) -> None:
    sweep = submit(seeds=2)
    claim = store.claim_cohort("w", LEASE)
    assert claim is not None
    store.record(
        claim,
        Progress(
            800,
            measurements=(
                replace(measured(0, 800), diagnostics={"a": 1.0, "b": math.inf}),
                replace(measured(1, 800), diagnostics={"b": 2.0, "c": math.nan}),
                replace(measured(1, 1600), diagnostics={}),
            ),
        ),
    )
    assert store.diagnostic_names(sweep.id) == ["a", "b", "c"]
    assert [c.values.tolist() for c in store.curves(sweep.id, ["b"])[0]] == [[math.inf], [2.0]]
    assert [c.x.tolist() for c in store.curves(sweep.id, ["b"])[0]] == [[800.0], [800.0]]
    [[_, third]] = store.curves(sweep.id, ["c"])
    assert np.isnan(third.values).tolist() == [True]
    together = store.curves(sweep.id, ["return_mean", "b", "return_history"], "seconds")
    assert [[len(curve.values) for curve in of_metric] for of_metric in together] == [
        [1, 2],
        [1, 1],
        [1, 2],
    ]
    assert [curve.x.tolist() for curve in together[1]] == [[0.8], [0.8]]


def test_every_point_of_a_sweep_is_read(store: Store) -> None:
    """How long that takes for a large one is measured by benchmarks/store."""
    specs = [
        RunSpec(f"learner {learner}", f"task {task}", seed)
        for task in range(2)
        for learner in range(3)
        for seed in range(16)
    ]
    versions = {spec.environment: 1 for spec in specs}
    sweep = store.create_sweep("large", 0, {}, specs, environment_versions=versions)
    points = tuple(measured(seed, 800 * (i + 1)) for i in range(62) for seed in range(16))
    while (claim := store.claim_cohort("w", LEASE)) is not None:
        store.record(claim, Progress(49_600, measurements=points, finished=tuple(range(16))))
    for metric in ("return_mean", "critic_loss"):
        [curves] = store.curves(sweep.id, [metric])
        assert sum(len(curve.values) for curve in curves) == 62 * len(specs)


@pytest.fixture
def uneven(store: Store, submit: Submit) -> str:
    """A sweep whose runs were measured at different places: off the grid, not to the end, never."""
    sweep = submit(seeds=5, timesteps=8_100)
    claim = store.claim_cohort("w", LEASE, 4)
    assert claim is not None
    places = {0: range(800, 8001, 800), 1: range(800, 8001, 800), 2: [800, 8100], 3: [800, 4000]}
    taken = tuple(
        measured(seed, timestep, math.nan if timestep == 4000 else -timestep / 7)
        for seed, own in places.items()
        for timestep in own
    )
    store.record(claim, Progress(8100, measurements=taken))
    return sweep.id


@pytest.mark.parametrize("x", ["timesteps", "seconds"])
@pytest.mark.parametrize("metric", ["return_mean", "critic_loss"])
def test_curves_do_not_depend_on_how_many_points_are_read_at_once(
    store: Store, uneven: str, monkeypatch: pytest.MonkeyPatch, metric: str, x: str
) -> None:
    [whole] = store.curves(uneven, [metric], x)
    assert [len(curve.values) for curve in whole] == [10, 10, 2, 2, 0]
    for points in (1, 12, 25):
        monkeypatch.setattr(module, "POINTS_AT_ONCE", points)
        for one, other in zip(store.curves(uneven, [metric], x)[0], whole, strict=True):
            assert one.run_id == other.run_id
            np.testing.assert_array_equal(one.x, other.x)
            np.testing.assert_array_equal(one.values, other.values)


def test_runs_that_were_measured_at_the_same_places_share_them(store: Store, uneven: str) -> None:
    first, second, third, *_ = store.curves(uneven, ["return_mean"])[0]
    assert first.x is second.x
    assert first.x is not third.x


@pytest.mark.parametrize("score", ["final", "return_history"])
def test_a_score_of_the_end_has_the_same_bits_with_the_ends_alone(
    store: Store, uneven: str, score: str
) -> None:
    kind = SCORES[score]  # type: ignore[index]
    assert kind.of_end
    [whole] = store.curves(uneven, [kind.metric])
    [ends] = store.curves(uneven, [kind.metric], only_ends=True)
    assert [len(curve.values) for curve in ends] == [1, 1, 1, 1, 0]
    for run, end in list(zip(whole, ends, strict=True))[:4]:
        own = kind.of(run.x, run.values, run.spec.timesteps)
        np.testing.assert_array_equal(kind.of(end.x, end.values, end.spec.timesteps), own)


def test_a_sweep_has_the_timesteps_that_its_runs_have_trained(store: Store, uneven: str) -> None:
    assert store.get_sweep(uneven).timesteps == 4 * 8100
