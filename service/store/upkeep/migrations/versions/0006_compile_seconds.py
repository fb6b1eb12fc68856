"""What compiling and loading kernels took, apart from training."""

import sqlalchemy as sa
from alembic import op

revision: str = "0006"
down_revision: str | None = "0005"


def upgrade() -> None:
    """Add the column; NULL is NaN: what was measured before did not tell it apart."""
    op.add_column("measurements", sa.Column("compile_seconds", sa.Double()))


def downgrade() -> None:
    """Drop it."""
    op.drop_column("measurements", "compile_seconds")
