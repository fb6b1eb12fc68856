"""What a sweep that searches was planned to do: its seeds and its rungs."""

import sqlalchemy as sa
from alembic import op

revision: str = "0015"
down_revision: str | None = "0013"


def upgrade() -> None:
    """Add the column; no sweep until now searches."""
    op.add_column("sweeps", sa.Column("search", sa.Text()))


def downgrade() -> None:
    """Drop it."""
    op.drop_column("sweeps", "search")
