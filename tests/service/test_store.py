"""A first walk through the store."""

from pathlib import Path

import pytest

from algorithms.measurement import Measurement
from service.run import RunStatus
from service.store.store import Store
from workers.progress import Progress
from workers.run_spec import RunSpec


def test_walk(tmp_path: Path) -> None:
    store = Store.open(f"sqlite:///{tmp_path / 'd3pg.sqlite'}")
    specs = [RunSpec("ddpg", "Pendulum", seed, timesteps=1600) for seed in range(4)]
    sweep = store.create_sweep(
        "first", 0, {"name": "first"}, specs, environment_versions={"Pendulum": 1}
    )
    assert store.list_sweeps() == [sweep]
    assert store.list_sweeps(after=sweep.id) == []
    claim = store.claim_cohort("w", 30.0)
    assert claim is not None
    assert [run.spec for run in claim.runs] == specs
    m = [Measurement(s, 800, -1.0 * s, float("nan"), 400, 0, 1.0, {"loss": 2.0}) for s in range(4)]
    assert len(store.record(claim, Progress(800, measurements=tuple(m)))) == 4
    assert store.record(claim, Progress(1600, finished=(0, 1, 2, 3))) == set()
    found = store.find_sweep(sweep.id)
    assert found is not None
    assert found.runs.succeeded == 4
    assert found.progress == 1.0
    curves = store.curve_points(sweep.id, "loss")
    assert [curve.values.tolist() for curve in curves] == [[2.0]] * 4
    assert store.measurements(curves[3].run_id)[0].return_mean == -3.0
    assert [e.kind for e in store.events_after(0)][:2] == ["sweep", "run"]
    assert store.list_runs(sweep.id, status=RunStatus.QUEUED) == []
    with pytest.raises(ValueError, match="finished"):
        store.cancel_sweep(sweep.id)
    store.close()
