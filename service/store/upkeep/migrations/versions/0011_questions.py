"""Whether a sweep's question is open: it then gets more seeds."""

import sqlalchemy as sa
from alembic import op

revision: str = "0011"
down_revision: str | None = "0010"

OPEN = sa.text("question = 'open'")


def upgrade() -> None:
    """Add the column; no sweep until now asks a question."""
    op.add_column("sweeps", sa.Column("question", sa.Text()))
    op.create_index(
        "ix_sweeps_open", "sweeps", ["number"], sqlite_where=OPEN, postgresql_where=OPEN
    )


def downgrade() -> None:
    """Drop both."""
    op.drop_index("ix_sweeps_open", "sweeps")
    op.drop_column("sweeps", "question")
