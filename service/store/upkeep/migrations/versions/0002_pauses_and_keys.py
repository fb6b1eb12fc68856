"""Sweeps that are paused, keys of submissions, the name of the latest commit."""

import sqlalchemy as sa
from alembic import op

revision: str = "0002"
down_revision: str | None = "0001"


def upgrade() -> None:
    """Add them."""
    op.add_column("sweeps", sa.Column("paused_at", sa.Double()))
    op.add_column("sweeps", sa.Column("submission_key", sa.Text()))
    op.create_index("ix_sweeps_submission_key", "sweeps", ["submission_key"], unique=True)
    op.create_table(
        "last_commit",
        sa.Column("name", sa.Text(), nullable=False),
        sa.PrimaryKeyConstraint("name", name="pk_last_commit"),
    )


def downgrade() -> None:
    """Drop them; runs that are paused are queued."""
    op.execute("UPDATE runs SET status = 'queued' WHERE status = 'paused'")
    op.drop_table("last_commit")
    op.drop_index("ix_sweeps_submission_key", "sweeps")
    op.drop_column("sweeps", "submission_key")
    op.drop_column("sweeps", "paused_at")
