"""From one database to another: everything, bit for bit, in every direction."""

import math
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from sqlalchemy import Connection, Engine, event, insert

from service.store.connection import connect
from service.store.refusal import OutdatedTablesError, TransferError
from service.store.store import Store
from service.store.tables import metadata, sweeps
from service.store.upkeep import migration
from service.store.upkeep.migration import refuse_outdated
from service.store.upkeep.transfer import CopiedTable, transfer
from tests.service.store.conftest import Fresh, Submit, measured
from workers.messages.progress import Progress
from workers.messages.random_return import RandomReturn
from workers.messages.run_spec import RunSpec

LEASE = 60.0


@pytest.fixture(params=["sqlite", "postgresql"])
def fresh_target(request: pytest.FixtureRequest) -> Fresh:
    make: Fresh = request.getfixturevalue(f"fresh_{request.param}")
    return make


@contextmanager
def engines(source: str, target: str) -> Iterator[tuple[Engine, Engine]]:
    reader, writer = connect(source, "reader"), connect(target, "writer")
    try:
        yield reader, writer
    finally:
        reader.dispose()
        writer.dispose()


def moved(source: str, target: str) -> list[CopiedTable]:
    with engines(source, target) as (reader, writer):
        return transfer(reader, writer, lambda *_: None)


def test_everything_arrives_and_goes_on(
    store: Store, submit: Submit, url: str, fresh_target: Fresh
) -> None:
    sweep = submit(seeds=4)
    claim = store.claim_cohort("w", LEASE, 3)
    assert claim is not None
    odd = (measured(0, 800, math.nan), measured(1, 800, math.inf), measured(2, 800, -1e-310))
    store.record(claim, Progress(800, measurements=odd, finished=(1,)))
    store.record_random_return(RandomReturn("Pendulum", 1, -1232.6, -1250.3, -1214.9, 1000))
    store.fail(claim.only({f"{sweep.id}-2"}), "ValueError: \U0001f600")
    store.move_sweep(sweep.id, "pause")
    before = (
        store.find_sweep(sweep.id),
        store.list_runs(sweep.id),
        [store.attempts(f"{sweep.id}-{ordinal}") for ordinal in range(4)],
        store.random_returns(),
        store.events_after(0),
    )
    points = [repr(store.measurements(f"{sweep.id}-{ordinal}")) for ordinal in range(4)]
    store.close()
    target = fresh_target(1)
    copied = {table.name: table.rows for table in moved(url, target)}
    assert set(copied) == set(metadata.tables)
    assert (copied["runs"], copied["measurements"], copied["attempts"]) == (4, 3, 3)
    there = Store.open(target)
    assert before == (
        there.find_sweep(sweep.id),
        there.list_runs(sweep.id),
        [there.attempts(f"{sweep.id}-{ordinal}") for ordinal in range(4)],
        there.random_returns(),
        there.events_after(0),
    )
    assert points == [repr(there.measurements(f"{sweep.id}-{ordinal}")) for ordinal in range(4)]
    last = there.last_event_id()
    specs = [RunSpec("ddpg", "Pendulum", 0)]
    new = there.create_sweep("new", 0, {}, specs, environment_versions={"Pendulum": 1})
    assert [s.id for s in there.list_sweeps()] == [new.id, sweep.id]
    assert there.last_event_id() == last + 1
    there.close()


numbers = st.floats(allow_nan=False)
texts = st.text(st.characters(exclude_categories=["Cs"], exclude_characters="\0"))
rows = st.lists(st.tuples(texts, texts, st.integers(-1000, 1000), numbers, numbers), max_size=20)


@settings(
    suppress_health_check=[HealthCheck.function_scoped_fixture], max_examples=10, deadline=None
)
@given(rows=rows)
def test_there_and_back_again(
    fresh_sqlite: Fresh, fresh_postgresql: Fresh, rows: list[tuple[str, str, int, float, float]]
) -> None:
    """Any rows have the same hashes in either database and after two copies."""
    first, middle, last = fresh_sqlite(), fresh_postgresql(1), fresh_sqlite(2)
    writer = connect(first, "writer")
    with writer.begin() as connection:
        for place, (name, other, priority, created_at, paused_at) in enumerate(rows):
            row = {
                "id": str(place), "name": name, "priority": priority, "request": {other: name},
                "created_at": created_at, "paused_at": paused_at,
            }  # fmt: skip
            connection.execute(insert(sweeps).values(row))
    writer.dispose()
    assert moved(first, middle) == moved(middle, last)


def test_a_target_that_holds_something_is_left_alone(
    store: Store, submit: Submit, url: str, fresh: Fresh
) -> None:
    submit()
    store.close()
    target = fresh(1)
    moved(url, target)
    with pytest.raises(TransferError, match=r"not empty: its table .* has 1 rows"):
        moved(url, target)


def test_a_copy_that_differs_is_not_kept(
    store: Store, submit: Submit, url: str, fresh: Fresh
) -> None:
    """A target that quietly writes something else is found out before anything is committed."""
    sweep = submit()
    store.close()
    target = fresh(1)
    with engines(url, target) as (reader, writer):

        @event.listens_for(writer, "after_cursor_execute")
        def tamper(connection: Connection, cursor: Any, statement: str, *_: object) -> None:
            if statement.startswith("INSERT INTO sweeps"):
                connection.connection.cursor().execute("UPDATE sweeps SET name = 'another'")

        with pytest.raises(TransferError, match="table sweeps differs at the target: 1 rows"):
            transfer(reader, writer, lambda *_: None)
    untouched = Store.open(target)
    assert untouched.find_sweep(sweep.id) is None
    untouched.close()


def test_older_tables_are_refused(fresh: Fresh) -> None:
    engine = connect(fresh(), "writer")
    refuse_outdated(engine)
    migration.downgrade(engine, "0001")
    with pytest.raises(OutdatedTablesError, match=r"revision 0001.*d3pg db upgrade"):
        refuse_outdated(engine)
    migration.upgrade(engine)
    refuse_outdated(engine)
    engine.dispose()
