"""Where the end of a sweep is told, and how that stands."""

import sqlalchemy as sa
from alembic import op

revision: str = "0010"
down_revision: str | None = "0009"


def upgrade() -> None:
    """Add the columns."""
    for column in (
        sa.Column("webhook", sa.Text()),
        sa.Column("webhook_delivered_at", sa.Double()),
        sa.Column("webhook_tries", sa.Integer(), nullable=False, server_default="0"),
        sa.Column("webhook_problem", sa.Text(), nullable=False, server_default=""),
        sa.Column("webhook_not_before", sa.Double(), nullable=False, server_default="0"),
    ):
        op.add_column("sweeps", column)


def downgrade() -> None:
    """Drop them."""
    for name in ("not_before", "problem", "tries", "delivered_at"):
        op.drop_column("sweeps", f"webhook_{name}")
    op.drop_column("sweeps", "webhook")
