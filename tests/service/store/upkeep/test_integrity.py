"""What a whole database satisfies, and that each way of breaking one is seen."""

import pytest
from sqlalchemy import text

from service.store.connection import connect
from service.store.store import Store
from service.store.upkeep.integrity import INVARIANTS, check
from tests.service.store.conftest import Submit, measured
from workers.messages.progress import Progress

LEASE = 60.0


def broken(url: str) -> set[str]:
    engine = connect(url, "reader")
    with engine.connect() as connection:
        found = {each.claim for each in check(connection) if each.faults}
    engine.dispose()
    return found


def damage(url: str, statement: str) -> None:
    engine = connect(url, "writer")
    with engine.begin() as connection:
        connection.execute(text(statement))
    engine.dispose()


@pytest.fixture
def used(store: Store, submit: Submit, url: str) -> str:
    """A database in which runs stand everywhere, closed."""
    sweep = submit(seeds=8)
    claim = store.claim_cohort("w", LEASE, 5)
    assert claim is not None
    store.record(claim, Progress(800, measurements=(measured(0, 800),), finished=(0,)))
    store.fail(claim.only({f"{sweep.id}-1"}), "ValueError: no")
    store.lose(claim.only({f"{sweep.id}-2"}), "its worker was lost")
    store.move_run(f"{sweep.id}-3", "cancel")
    store.move_run(f"{sweep.id}-6", "pause")
    store.close()
    return url


def test_a_database_in_use_is_whole(used: str) -> None:
    assert broken(used) == set()


@pytest.mark.parametrize(
    ("statement", "claim"),
    [
        ("UPDATE runs SET finished_at = 1.0 WHERE status = 'queued'", "a run waits"),
        ("UPDATE runs SET finished_at = NULL WHERE status = 'failed'", "a run waits"),
        ("UPDATE runs SET status = 'lost' WHERE status = 'queued'", "a run waits"),
        ("UPDATE runs SET is_cancelling = true WHERE status = 'failed'", "only a running run"),
        ("UPDATE runs SET attempt = 7 WHERE status = 'failed'", "a run has as many attempts"),
        ("DELETE FROM attempts WHERE outcome = 'failed'", "a run has as many attempts"),
        ("UPDATE attempts SET ended_at = NULL WHERE outcome = 'failed'", "the current attempt"),
        ("UPDATE attempts SET ended_at = 1.0 WHERE outcome = 'running'", "the current attempt"),
        ("UPDATE runs SET ordinal = 99 WHERE ordinal = 7", "the runs of a sweep"),
        ("UPDATE measurements SET run_number = 99", "a measurement is a run's"),
        ("UPDATE measurements SET diagnostic_set = 99", "a measurement is a run's"),
        ("UPDATE events SET sweep_number = 99", "an event is a sweep's"),
        ("UPDATE measurements SET packed = substr(packed, 2)", "a measurement's floats are whole"),
        ("UPDATE measurements SET packed = substr(packed, 1, 24)", "a measurement's floats"),
    ],
)
def test_damage_is_seen(used: str, statement: str, claim: str) -> None:
    damage(used, statement)
    assert any(each.startswith(claim) for each in broken(used))


def test_every_invariant_is_a_query(used: str) -> None:
    engine = connect(used, "reader")
    with engine.connect() as connection:
        assert {each.claim for each in check(connection)} >= set(INVARIANTS)
    engine.dispose()
