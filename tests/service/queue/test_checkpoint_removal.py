"""Removing checkpoints: of runs that have ended, and nothing that they learned."""

from collections.abc import Iterator
from pathlib import Path

import pytest

from service.queue.checkpoint_removal import CheckpointRemoval
from service.store.store import Store
from workers.checkpoints.folder import UnavailableError
from workers.checkpoints.place import Place, folder_in
from workers.messages.progress import CheckpointAttempt, Progress
from workers.messages.run_spec import RunSpec


@pytest.fixture
def store(tmp_path: Path) -> Iterator[Store]:
    opened = Store.open(f"sqlite:///{tmp_path / 'd3pg.sqlite'}")
    yield opened
    opened.close()


def test_an_ended_run_keeps_its_policy_alone(store: Store, place: Place) -> None:
    specs = [RunSpec("ddpg", "Pendulum", seed, timesteps=1600) for seed in range(2)]
    sweep = store.create_sweep("x", 0, {}, specs, environment_versions={"Pendulum": 1})
    claim = store.claim_cohort("w", 60.0)
    assert claim is not None
    for run in claim.runs:
        folder = folder_in(place, run.run_id)
        for name in ("1-800.checkpoint", "2.journal.unfinished", "policy"):
            folder.write(name, b"")
        folder.append("1.journal", 0, b"one")
        folder.append("1.journal", 3, b"two")
    written = tuple(CheckpointAttempt(seed, 800) for seed in range(2))
    store.record(claim, Progress(1600, finished=(0,), checkpoints=written))

    removal = CheckpointRemoval(store, place)
    assert removal.remove() == 1
    assert folder_in(place, f"{sweep.id}-0").names() == ["policy"]
    assert len(folder_in(place, f"{sweep.id}-1").names()) == 4
    assert removal.remove() == 0
    ended, running = store.list_runs(sweep.id)
    assert (ended.checkpoint_timestep, running.checkpoint_timestep) == (0, 800)


def test_runs_at_their_end_keep_the_newest_checkpoints_that_there_is_room_for(
    store: Store, place: Place
) -> None:
    specs = [RunSpec("ddpg", "Pendulum", seed, timesteps=1600) for seed in range(4)]
    request = {"seeds": 4}
    sweep = store.create_sweep("x", 0, request, specs, environment_versions={"Pendulum": 1})
    claim = store.claim_cohort("w", 60.0)
    assert claim is not None
    for run in claim.runs:
        folder_in(place, run.run_id).write("1-1600.checkpoint", bytes(10))
        folder_in(place, run.run_id).write("policy", bytes(99))
    ends = tuple(CheckpointAttempt(seed, 1600) for seed in (0, 1, 3))
    store.record(claim, Progress(1600, finished=(0,), checkpoints=ends))
    store.record(claim, Progress(1600, finished=(1, 2, 3)))
    removal = CheckpointRemoval(store, place, keep_bytes=20)
    while removal.remove():
        pass
    kept = [folder_in(place, run.run_id).names() for run in claim.runs]
    assert [("1-1600.checkpoint" in names) for names in kept] == [False, True, False, True]
    assert all("policy" in names for names in kept)
    store.extend_sweep(sweep.id, request, 3200, lambda _: 1)
    timesteps = [run.checkpoint_timestep for run in store.list_runs(sweep.id)]
    assert timesteps == [0, 1600, 0, 1600]
    assert removal.remove() == 0


def test_while_their_place_cannot_be_had_none_is_forgotten(store: Store, bucket: str) -> None:
    specs = [RunSpec("ddpg", "Pendulum", 0, timesteps=1600)]
    store.create_sweep("x", 0, {}, specs, environment_versions={"Pendulum": 1})
    claim = store.claim_cohort("w", 60.0)
    assert claim is not None
    store.record(claim, Progress(1600, finished=(0,)))
    missing = CheckpointRemoval(store, bucket.replace("d3pg", "no-such-bucket"))
    with pytest.raises(UnavailableError, match="no bucket"):
        missing.remove()
    assert CheckpointRemoval(store, bucket).remove() == 1
