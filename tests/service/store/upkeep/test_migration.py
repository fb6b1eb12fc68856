"""Migrations: what they make is what `tables` says, and each can be undone."""

import math
from dataclasses import replace
from typing import Any

from sqlalchemy import inspect, select

from service.model.request.entry import Entries
from service.store.connection import connect
from service.store.store import Store
from service.store.tables import events, metadata, runs
from service.store.upkeep import migration
from tests.service.store.conftest import Submit, measured
from workers.messages.progress import Progress
from workers.messages.run_spec import RunSpec, Weights


def test_migrations_make_the_tables(url: str) -> None:
    engine = connect(url, "writer")
    migration.check(engine)
    tables = set(inspect(engine).get_table_names())
    engine.dispose()
    assert tables == {*metadata.tables, "alembic_version"}


def test_migrations_can_be_undone_and_done_again(url: str) -> None:
    engine = connect(url, "writer")
    migration.downgrade(engine, "base")
    assert inspect(engine).get_table_names() == ["alembic_version"]
    migration.upgrade(engine)
    migration.check(engine)
    engine.dispose()


def test_indexes_that_migrations_make_are_those_of_the_tables(url: str) -> None:
    engine = connect(url, "writer")
    found = inspect(engine)
    made = {
        table: {
            index["name"]
            for index in found.get_indexes(table)
            if "duplicates_constraint" not in index  # PostgreSQL lists those of constraints too
        }
        for table in metadata.tables
    }
    declared = {name: {i.name for i in t.indexes} for name, t in metadata.tables.items()}
    engine.dispose()
    assert made == declared


def test_whatever_a_worker_once_had_may_have_left_files(
    store: Store, submit: Submit, url: str
) -> None:
    submit(seeds=2)
    assert store.claim_cohort("worker-1", 60.0, limit=1) is not None
    store.close()
    engine = connect(url, "writer")
    migration.downgrade(engine, "0003")
    migration.upgrade(engine)
    with engine.connect() as connection:
        query = select(runs.c.may_have_files).order_by(runs.c.ordinal)
        assert list(connection.scalars(query)) == [True, False]
    engine.dispose()


def test_what_was_measured_before_compiling_was_told_apart_keeps_its_seconds(
    store: Store, submit: Submit, url: str
) -> None:
    submit(seeds=1)
    claim = store.claim_cohort("worker-1", 60.0, limit=1)
    assert claim is not None
    store.record(claim, Progress(800, measurements=(measured(0, 800),)))
    store.close()
    engine = connect(url, "writer")
    migration.downgrade(engine, "0005")
    migration.upgrade(engine)
    engine.dispose()
    again = Store.open(url)
    [found] = again.measurements(claim.runs[0].run_id)
    again.close()
    assert math.isnan(found.compile_seconds)
    assert replace(found, compile_seconds=0.25) == measured(0, 800)


def test_opening_again_keeps_everything(store: Store, submit: Submit, url: str) -> None:
    sweep = submit()
    store.close()
    again = Store.open(url)
    assert again.list_sweeps() == [sweep]
    again.close()


def test_runs_of_before_are_of_the_entry_that_their_place_said(url: str) -> None:
    request: dict[str, Any] = {
        "algorithms": [
            {"name": "gd", "environments": ["Pendulum"]},
            {"name": "hybrid-ddpg", "weights": [{"w1": 1}, {"w2": 1}]},
        ],
        "environments": ["Acrobot", "Pendulum"],
        "seeds": [7, 3],
    }
    cells = Entries(request).cells
    specs = [
        RunSpec(entry.algorithm, environment, seed, entry.weights or Weights())
        for environment, entry in cells
        for seed in request["seeds"]
    ]
    places = [entry.place for _, entry in cells for _ in request["seeds"]]
    versions = dict.fromkeys(request["environments"], 1)
    opened = Store.open(url)
    sweep = opened.create_sweep(
        "x", 0, request, specs, entries=places, environment_versions=versions
    )
    opened.close()
    engine = connect(url, "writer")
    migration.downgrade(engine, "0006")
    migration.upgrade(engine)
    engine.dispose()
    again = Store.open(url)
    assert [run.entry for run in again.list_runs(sweep.id)] == places
    again.close()
    assert places == [1, 1, 2, 2, 0, 0, 1, 1, 2, 2]


def test_what_was_submitted_before_there_were_users_is_the_administrators(
    store: Store, submit: Submit, url: str
) -> None:
    submit(seeds=1)
    store.close()
    engine = connect(url, "writer")
    migration.downgrade(engine, "0012")
    migration.upgrade(engine)
    engine.dispose()
    again = Store.open(url)
    assert [sweep.owner for sweep in again.list_sweeps()] == ["admin"]
    assert (again.users(), again.shares(), again.sessions()) == ([], [], [])
    again.close()


def test_measurements_of_a_report_were_an_event_for_each_run(
    store: Store, submit: Submit, url: str
) -> None:
    submit(seeds=2)
    claim = store.claim_cohort("worker-1", 60.0)
    assert claim is not None
    store.record(claim, Progress(800, measurements=(measured(0, 800),)))
    store.record(claim, Progress(1600, measurements=(measured(0, 1600), measured(1, 1600))))
    before = store.events_after(0)
    store.close()
    engine = connect(url, "writer")
    migration.downgrade(engine, "0015")
    query = select(events.c.payload).where(events.c.kind == "measurements")
    with engine.connect() as connection:
        [older] = connection.scalars(query)
    migration.upgrade(engine)
    engine.dispose()
    first = claim.runs[0].run_id
    assert older == {"sweep_id": first[:-2], "run_id": first, "from": 800, "to": 800}
    again = Store.open(url)
    assert again.events_after(0) == before[:-1]
    again.close()
