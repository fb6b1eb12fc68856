"""What was found about runs: where the simulator's gradients help them."""

import sqlalchemy as sa
from alembic import op

revision: str = "0012"
down_revision: str | None = "0011"


def upgrade() -> None:
    """Add the table."""
    op.create_table(
        "diagnoses",
        sa.Column(
            "run_number", sa.BigInteger().with_variant(sa.Integer(), "sqlite"), nullable=False
        ),
        sa.Column("attempt", sa.Integer(), nullable=False),
        sa.Column("asked_at", sa.Double(), nullable=False),
        sa.Column("is_waiting", sa.Boolean(), nullable=False),
        sa.Column("findings", sa.Text()),
        sa.Column("problem", sa.Text(), nullable=False),
        sa.ForeignKeyConstraint(["run_number"], ["runs.number"], name="fk_diagnoses_run_number"),
        sa.PrimaryKeyConstraint("run_number", name="pk_diagnoses"),
    )
    op.create_index(
        "ix_diagnoses_waiting",
        "diagnoses",
        ["asked_at"],
        sqlite_where=sa.text("is_waiting = 1"),
        postgresql_where=sa.text("is_waiting"),
    )


def downgrade() -> None:
    """Drop it."""
    op.drop_table("diagnoses")
