"""Where runs have their newest checkpoint, and where their attempts were taken up."""

import sqlalchemy as sa
from alembic import op

revision: str = "0003"
down_revision: str | None = "0002"

CONDITION = sa.text("checkpoint_timestep > 0")


def upgrade() -> None:
    """Add the columns; runs of before have no checkpoint."""
    op.add_column(
        "runs",
        sa.Column("checkpoint_timestep", sa.BigInteger(), nullable=False, server_default="0"),
    )
    op.add_column("runs", sa.Column("resumed_timestep", sa.BigInteger()))
    op.add_column("runs", sa.Column("memory_bytes", sa.BigInteger()))
    op.add_column("attempts", sa.Column("resumed_timestep", sa.BigInteger()))
    op.add_column("attempts", sa.Column("note", sa.Text(), nullable=False, server_default=""))
    op.create_index(
        "ix_runs_checkpointed",
        "runs",
        ["status"],
        sqlite_where=CONDITION,
        postgresql_where=CONDITION,
    )


def downgrade() -> None:
    """Drop them."""
    op.drop_index("ix_runs_checkpointed", "runs")
    op.drop_column("attempts", "note")
    op.drop_column("attempts", "resumed_timestep")
    op.drop_column("runs", "memory_bytes")
    op.drop_column("runs", "resumed_timestep")
    op.drop_column("runs", "checkpoint_timestep")
