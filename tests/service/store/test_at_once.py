"""Statements about many rows at once: the same on every database, and prepared once."""

from pathlib import Path

import pytest
from sqlalchemy import Connection, event, func, select

from service.store.at_once import Row, among, insert_each, update_each
from service.store.store import Store
from service.store.tables import attempts, runs
from tests.service.store.conftest import Submit


def ordinals(store: Store, picked: list[int]) -> list[int]:
    query = select(runs.c.ordinal).where(among(runs.c.ordinal, picked)).order_by(runs.c.ordinal)
    return store.read(lambda connection: list(connection.scalars(query)))


@pytest.mark.parametrize("picked", [[], [2], [3, 0, 3, 17], list(range(-40_000, 40_000))])
def test_rows_are_picked_by_any_number_of_numbers(
    store: Store, submit: Submit, picked: list[int]
) -> None:
    submit(seeds=4)
    assert ordinals(store, picked) == [each for each in range(4) if each in picked]
    query = select(func.count()).where(~among(runs.c.ordinal, picked))
    left = store.read(lambda connection: connection.scalar(query))
    assert left == sum(each not in picked for each in range(4))


def test_rows_are_found_by_their_key_and_not_one_after_the_other(tmp_path: Path) -> None:
    """SQLite uses no index for a condition that is compared with 1."""
    store = Store.open(f"sqlite:///{tmp_path / 'd3pg.sqlite'}")
    query = select(runs.c.reason).where(among(runs.c.number, [1, 3]))

    def plan(connection: Connection) -> list[str]:
        text = str(query.compile(connection, compile_kwargs={"render_postcompile": True}))
        explained = connection.exec_driver_sql(f"EXPLAIN QUERY PLAN {text}", ("[1, 3]",))
        return [row.detail for row in explained]

    assert store.read(plan)[0] == "SEARCH runs USING INTEGER PRIMARY KEY (rowid=?)"
    store.close()


def test_each_row_is_updated_to_what_it_is_told(store: Store, submit: Submit) -> None:
    submit(seeds=3)
    told: list[Row] = [
        {"ordinal": 0, "fingerprint": {"a": "\N{SNOWMAN}"}, "timestep": None, "late": 0.5},
        {"ordinal": 2, "fingerprint": None, "timestep": 2**40, "late": 1e-300},
        {"ordinal": 9, "fingerprint": None, "timestep": 1, "late": 0},
    ]
    store.write(
        update_each,
        runs,
        ("ordinal",),
        told,
        lambda new: {
            "fingerprint": new["fingerprint"],
            "timestep": func.coalesce(new["timestep"], runs.c.timestep + 7),
            "not_before": new["late"] * 2,
        },
    )
    query = select(runs.c.fingerprint, runs.c.timestep, runs.c.not_before).order_by(runs.c.ordinal)
    rows = store.read(lambda connection: [tuple(row) for row in connection.execute(query)])
    assert rows == [({"a": "\N{SNOWMAN}"}, 7, 1.0), (None, 0, 0.0), (None, 2**40, 2e-300)]


def test_rows_are_inserted_with_the_defaults_of_what_they_do_not_tell(
    store: Store, submit: Submit
) -> None:
    submit(seeds=3)
    told: list[Row] = [
        {"run_number": number, "attempt": 4, "worker": f"w{number}"} for number in (1, 3)
    ]
    store.write(insert_each, attempts, told)
    query = select(attempts).order_by(attempts.c.run_number)
    rows = store.read(lambda connection: connection.execute(query).all())
    assert [(r.run_number, r.attempt, r.worker, r.outcome, r.note) for r in rows] == [
        (1, 4, "w1", "running", ""),
        (3, 4, "w3", "running", ""),
    ]
    assert all(row.started_at > 0 and row.ended_at is None for row in rows)


def test_nothing_told_is_nothing_done(store: Store) -> None:
    store.write(update_each, runs, ("number",), [], dict)
    store.write(insert_each, attempts, [])


def test_the_text_of_a_statement_does_not_follow_how_many_rows_there_are(
    store: Store, submit: Submit
) -> None:
    submit(seeds=4)

    def texts(connection: Connection, count: int) -> list[str]:
        seen: list[str] = []

        def note(*told: object) -> None:
            seen.append(str(told[2]))

        event.listen(connection, "before_cursor_execute", note)
        numbers = list(range(count))
        connection.execute(select(runs.c.number).where(among(runs.c.number, numbers)))
        rows: list[Row] = [{"number": number, "timestep": 800} for number in numbers]
        update_each(connection, runs, ("number",), rows, lambda new: {"timestep": new["timestep"]})
        event.remove(connection, "before_cursor_execute", note)
        return seen

    assert store.write(texts, 2) == store.write(texts, 300)
