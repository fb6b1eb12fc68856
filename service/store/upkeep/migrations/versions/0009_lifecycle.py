"""Deleting and extending sweeps, limits of workers, and what is kept after a run's end."""

import sqlalchemy as sa
from alembic import op

revision: str = "0009"
down_revision: str | None = "0008"


def upgrade() -> None:
    """Add the columns; whatever a worker once had may have left a policy."""
    op.add_column("sweeps", sa.Column("deleted_at", sa.Double()))
    op.add_column("sweeps", sa.Column("max_workers", sa.Integer()))
    op.add_column("runs", sa.Column("kept_bytes", sa.BigInteger()))
    op.add_column(
        "runs",
        sa.Column("may_have_policy", sa.Boolean(), nullable=False, server_default=sa.false()),
    )
    op.execute("UPDATE runs SET may_have_policy = true WHERE attempt > 0")


def downgrade() -> None:
    """Drop them. A sweep that was being deleted is there again, as far as it was not gone."""
    for column in ("may_have_policy", "kept_bytes"):
        op.drop_column("runs", column)
    for column in ("max_workers", "deleted_at"):
        op.drop_column("sweeps", column)
