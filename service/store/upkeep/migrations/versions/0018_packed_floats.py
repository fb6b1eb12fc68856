"""Floats of a measurement are bytes of one column, so that a run's points are read as one value."""

import math
import struct
from collections.abc import Callable, Iterable, Iterator
from typing import Any

import sqlalchemy as sa
from alembic import op

revision: str = "0018"
down_revision: str | None = "0017"

AT_ONCE = 10_000
NUMBER = sa.BigInteger().with_variant(sa.Integer(), "sqlite")
OWN = struct.Struct("<4d")
"""return_mean, return_history, seconds, compile_seconds; NULL of a column is NaN here."""

Values = Iterable[tuple[Any, ...]]


def upgrade() -> None:
    """Pack them; return_mean stays a column too. Some 10 s for each million of measurements."""
    before = (
        "return_mean, updates, jacobians, diagnostic_set,"
        " return_history, seconds, compile_seconds, diagnostics"
    )
    columns = [*_common(), sa.Column("packed", sa.LargeBinary(), nullable=False)]
    _rewrite(before, columns, _packed)


def downgrade() -> None:
    """Unpack them."""
    before = "return_mean, updates, jacobians, diagnostic_set, packed"
    columns = [
        *_common(),
        sa.Column("return_history", sa.Double()),
        sa.Column("seconds", sa.Double()),
        sa.Column("diagnostics", sa.LargeBinary(), nullable=False),
        sa.Column("compile_seconds", sa.Double()),
    ]
    _rewrite(before, columns, _unpacked)


def _common() -> list[sa.Column[Any]]:
    return [
        sa.Column("return_mean", sa.Double()),
        sa.Column("updates", sa.BigInteger(), nullable=False),
        sa.Column("jacobians", sa.BigInteger(), nullable=False),
        sa.Column("diagnostic_set", NUMBER, nullable=False),
    ]


def _rewrite(
    before: str, columns: list[sa.Column[Any]], written: Callable[[Values], Values]
) -> None:
    """Make the table anew with these columns behind its key, of rows with those of before."""
    connection = op.get_bind()
    op.rename_table("measurements", "measurements_before")
    if connection.dialect.name == "postgresql":  # where two tables cannot have one name for it
        op.execute("ALTER INDEX pk_measurements RENAME TO pk_measurements_before")
    op.create_table(
        "measurements",
        sa.Column("run_number", NUMBER, nullable=False, autoincrement=False),
        sa.Column("timestep", sa.BigInteger(), nullable=False, autoincrement=False),
        *columns,
        sa.PrimaryKeyConstraint("run_number", "timestep", name="pk_measurements"),
        sqlite_with_rowid=False,
    )
    mark = "?" if connection.dialect.name == "sqlite" else "%s"
    marks = ", ".join([mark] * (2 + len(columns)))
    rows = connection.execute(
        sa.text(
            f"SELECT run_number, timestep, {before} FROM measurements_before"  # noqa: S608
            " ORDER BY run_number, timestep"
        ),
        execution_options={"yield_per": AT_ONCE},
    )
    for part in rows.partitions():
        values = list(written(map(tuple, part)))
        connection.exec_driver_sql(f"INSERT INTO measurements VALUES ({marks})", values)  # noqa: S608
    op.drop_table("measurements_before")


def _packed(rows: Values) -> Iterator[tuple[Any, ...]]:
    for *key, mean, updates, jacobians, of_set, history, seconds, compiling, diagnostics in rows:
        floats = (math.nan if x is None else x for x in (mean, history, seconds, compiling))
        yield *key, mean, updates, jacobians, of_set, OWN.pack(*floats) + diagnostics


def _unpacked(rows: Values) -> Iterator[tuple[Any, ...]]:
    for *common, packed in rows:
        _, *floats = OWN.unpack_from(packed)
        history, seconds, compiling = (None if math.isnan(x) else x for x in floats)
        yield *common, history, seconds, packed[OWN.size :], compiling
