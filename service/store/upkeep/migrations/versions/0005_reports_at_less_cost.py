"""Reports of workers at less cost: what they change is in no index, what they add refers freely."""

from collections.abc import Mapping
from typing import Any

import sqlalchemy as sa
from alembic import op

revision: str = "0005"
down_revision: str | None = "0004"

RUNNING = sa.text("status = 'running'")
REFERENCES: Mapping[str, Mapping[str, str]] = {
    "measurements": {"run_number": "runs", "diagnostic_set": "diagnostic_sets"},
    "events": {"sweep_number": "sweeps"},
}
KEPT: Mapping[str, Mapping[str, Any]] = {  # which SQLite's new table would be without
    "measurements": {"sqlite_with_rowid": False},
    "events": {"sqlite_autoincrement": True},
}


def upgrade() -> None:
    """Take leases out of the index, and drop the references of tables that only grow."""
    op.drop_index("ix_runs_running", "runs")
    _index("ix_runs_running", ["sweep_number"], RUNNING, RUNNING)
    is_cancelling = sa.text("is_cancelling = 1"), sa.text("is_cancelling")
    _index("ix_runs_cancelling", ["sweep_number"], *is_cancelling)
    for name, references in REFERENCES.items():
        with op.batch_alter_table(name, table_kwargs=KEPT[name]) as table:
            for column in references:
                table.drop_constraint(f"fk_{name}_{column}", type_="foreignkey")


def downgrade() -> None:
    """Put both back."""
    for name, references in REFERENCES.items():
        with op.batch_alter_table(name, table_kwargs=KEPT[name]) as table:
            for column, target in references.items():
                table.create_foreign_key(f"fk_{name}_{column}", target, [column], ["number"])
    op.drop_index("ix_runs_cancelling", "runs")
    op.drop_index("ix_runs_running", "runs")
    columns = ["sweep_number", "lease_until", "is_cancelling"]
    _index("ix_runs_running", columns, RUNNING, RUNNING)


def _index(name: str, columns: list[str], sqlite: sa.TextClause, other: sa.TextClause) -> None:
    op.create_index(name, "runs", columns, sqlite_where=sqlite, postgresql_where=other)
