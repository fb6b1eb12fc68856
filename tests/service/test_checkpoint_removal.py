"""Removing checkpoints: of runs that have ended, and nothing that they learned."""

from collections.abc import Iterator
from pathlib import Path

import pytest

from service.checkpoint_removal import CheckpointRemoval
from service.store.store import Store
from workers.progress import CheckpointAttempt, Progress
from workers.run_spec import RunSpec


@pytest.fixture
def store(tmp_path: Path) -> Iterator[Store]:
    opened = Store.open(f"sqlite:///{tmp_path / 'd3pg.sqlite'}")
    yield opened
    opened.close()


def test_an_ended_run_keeps_its_policy_alone(store: Store, tmp_path: Path) -> None:
    specs = [RunSpec("ddpg", "Pendulum", seed, timesteps=1600) for seed in range(2)]
    sweep = store.create_sweep("x", 0, {}, specs, environment_versions={"Pendulum": 1})
    claim = store.claim_cohort("w", 60.0)
    assert claim is not None
    for run in claim.runs:
        (tmp_path / run.run_id).mkdir()
        for name in ("1-800.checkpoint", "1.journal", "2.journal.unfinished", "policy"):
            (tmp_path / run.run_id / name).touch()
    written = tuple(CheckpointAttempt(seed, 800) for seed in range(2))
    store.record(claim, Progress(1600, finished=(0,), checkpoints=written))

    removal = CheckpointRemoval(store, tmp_path)
    assert removal.remove() == 1
    assert [path.name for path in (tmp_path / f"{sweep.id}-0").iterdir()] == ["policy"]
    assert len(list((tmp_path / f"{sweep.id}-1").iterdir())) == 4
    assert removal.remove() == 0
    ended, running = store.list_runs(sweep.id)
    assert (ended.checkpoint_timestep, running.checkpoint_timestep) == (0, 800)
