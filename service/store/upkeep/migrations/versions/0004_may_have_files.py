"""Which runs may have files of checkpoints, told or not."""

import sqlalchemy as sa
from alembic import op

revision: str = "0004"
down_revision: str | None = "0003"

TOLD = sa.text("checkpoint_timestep > 0")


def upgrade() -> None:
    """Add the flag; whatever a worker once had may have left files."""
    op.add_column(
        "runs",
        sa.Column("may_have_files", sa.Boolean(), nullable=False, server_default=sa.false()),
    )
    op.execute("UPDATE runs SET may_have_files = true WHERE attempt > 0")
    op.drop_index("ix_runs_checkpointed", "runs")
    op.create_index(
        "ix_runs_may_have_files",
        "runs",
        ["status"],
        sqlite_where=sa.text("may_have_files = 1"),
        postgresql_where=sa.text("may_have_files"),
    )


def downgrade() -> None:
    """Go back to what workers told."""
    op.drop_index("ix_runs_may_have_files", "runs")
    op.create_index(
        "ix_runs_checkpointed", "runs", ["status"], sqlite_where=TOLD, postgresql_where=TOLD
    )
    op.drop_column("runs", "may_have_files")
