"""Deleting sweeps: hidden at once, gone bit by bit, however often that is killed in between."""

from pathlib import Path

import pytest
from sqlalchemy import Connection, Table, func, select, update

from service.queue.checkpoint_removal import CheckpointRemoval
from service.queue.disposal import DAY, Disposal, Retention
from service.store.refusal import ImpossibleMoveError, NotFoundError
from service.store.store import Store
from service.store.tables import events, metadata, runs
from service.store.upkeep.integrity import check
from tests.service.store.conftest import Submit, measured
from workers.checkpoints.place import folder_in
from workers.messages.progress import Progress
from workers.messages.run_spec import RunSpec


def ended(store: Store, submit: Submit, seeds: int = 3) -> str:
    """A sweep whose runs have measured and ended."""
    sweep = submit(seeds=seeds)
    claim = store.claim_cohort("w", 60.0)
    assert claim is not None
    points = tuple(measured(seed, 800) for seed in range(seeds))
    store.record(claim, Progress(1600, measurements=points, finished=tuple(range(seeds))))
    return sweep.id


def rows(store: Store) -> dict[str, int]:
    """How many rows each table has that a sweep leaves some in."""
    names = ("sweeps", "runs", "attempts", "measurements", "events", "sweep_names")
    return {name: store.read(count, metadata.tables[name]) for name in names}


def count(connection: Connection, table: Table) -> int:
    return connection.scalar(select(func.count()).select_from(table)) or 0


def whole(store: Store) -> bool:
    """Whether what must hold between rows does."""
    return all(not each.faults for each in store.read(check))


@pytest.fixture
def disposal(store: Store, tmp_path: Path) -> Disposal:
    return Disposal(store, tmp_path, Retention())


def test_a_deleted_sweep_is_nowhere_any_more(store: Store, submit: Submit) -> None:
    sweep_id, kept = ended(store, submit), ended(store, submit)
    before = store.last_event_id()
    assert store.delete_sweep(sweep_id) == 3
    assert store.find_sweep(sweep_id) is None
    assert store.find_run(f"{sweep_id}-0") is None
    assert store.sweep_version(sweep_id) is None
    assert [sweep.id for sweep in store.list_sweeps()] == [kept]
    assert store.count_runs()["succeeded"] == 3
    [event] = store.events_after(before)
    assert event.payload == {"sweep_id": sweep_id, "change": "deleted"}
    with pytest.raises(NotFoundError):
        store.delete_sweep(sweep_id)
    with pytest.raises(NotFoundError):
        store.move_run(f"{sweep_id}-0", "cancel")


def test_what_has_not_ended_is_not_deleted(store: Store, submit: Submit) -> None:
    sweep = submit(seeds=2)
    store.claim_cohort("w", 60.0, limit=1)
    with pytest.raises(ImpossibleMoveError, match="has 2 runs that have not ended: cancel it"):
        store.delete_sweep(sweep.id)
    assert store.find_sweep(sweep.id) is not None


def test_rows_and_files_go_and_nothing_of_others(
    store: Store, submit: Submit, disposal: Disposal, tmp_path: Path
) -> None:
    kept = ended(store, submit)
    before = rows(store)
    sweep_id = ended(store, submit)
    for name in (f"{kept}-0", f"{sweep_id}-0", f"{sweep_id}-2"):
        folder_in(tmp_path, name).write("policy", b"learned")
        folder_in(tmp_path, name).append("1.journal", 0, b"lived")
    store.delete_sweep(sweep_id)
    while disposal.work():
        assert whole(store)
    assert rows(store) == before
    assert [path.name for path in tmp_path.iterdir() if path.is_dir()] == [f"{kept}-0"]
    assert len(store.measurements(f"{kept}-2")) == 1


def test_a_deletion_that_is_killed_goes_on(store: Store, submit: Submit, tmp_path: Path) -> None:
    """Between two transactions of it, the store is whole, and the sweep stays hidden."""
    sweep_id = ended(store, submit, seeds=3)
    store.delete_sweep(sweep_id)
    while gone := store.deleted_runs(1):
        assert whole(store)
        assert store.find_sweep(sweep_id) is None
        assert store.purge_runs(gone).runs == 1
    assert whole(store)
    disposal = Disposal(store, tmp_path, Retention())  # of the next service
    while disposal.work():
        pass
    assert set(rows(store).values()) == {0}


def test_a_place_that_cannot_be_had_forgets_nothing(
    store: Store, submit: Submit, tmp_path: Path
) -> None:
    sweep_id = ended(store, submit)
    store.delete_sweep(sweep_id)
    (tmp_path / "place").mkdir()
    blocked = tmp_path / "place" / f"{sweep_id}-0"
    blocked.write_text("no folder")
    with pytest.raises(OSError, match="Not a directory"):
        Disposal(store, tmp_path / "place", Retention()).work()
    assert rows(store)["runs"] == 3


def test_a_key_is_free_again(store: Store) -> None:
    first = submitted(store)
    store.move_sweep(first, "cancel")
    store.delete_sweep(first)
    assert submitted(store) != first


def submitted(store: Store) -> str:
    specs = [RunSpec("ddpg", "Pendulum", 0)]
    versions = {"Pendulum": 1}
    made = store.create_sweep(
        "x", 0, {}, specs, environment_versions=versions, submission_key="key"
    )
    return made.id


def aged(store: Store, days: float) -> None:
    """Make all that has happened so much older."""
    seconds = days * DAY
    store.write(lambda c: c.execute(update(runs).values(finished_at=runs.c.finished_at - seconds)))
    store.write(
        lambda c: c.execute(update(events).values(created_at=events.c.created_at - seconds))
    )


def test_old_policies_and_events_go_and_nothing_newer(
    store: Store, submit: Submit, tmp_path: Path
) -> None:
    old = ended(store, submit)
    aged(store, 10)
    new = ended(store, submit)
    for sweep_id in (old, new):
        folder_in(tmp_path, f"{sweep_id}-0").write("policy", b"learned")
    CheckpointRemoval(store, tmp_path).remove()
    before = store.last_event_id()
    unasked = Disposal(store, tmp_path, Retention())
    assert not unasked.work()
    disposal = Disposal(store, tmp_path, Retention(policy_days=7, event_days=7))
    while disposal.work():
        pass
    assert [path.name for path in tmp_path.iterdir() if path.is_dir()] == [f"{new}-0"]
    left = store.read(lambda c: c.execute(select(events.c.payload)).scalars().all())
    assert sum(payload["sweep_id"] == old for payload in left) == 1  # what answers are tagged with
    assert sum(payload["sweep_id"] == new for payload in left) > 1
    assert store.last_event_id() == before
    assert len(store.measurements(f"{old}-0")) == 1
    assert rows(store)["sweep_names"] > 0
