"""What sweeps are described with and found by, and the final scores of runs."""

import sqlalchemy as sa
from alembic import op

revision: str = "0008"
down_revision: str | None = "0007"

NUMBER = sa.BigInteger().with_variant(sa.Integer(), "sqlite")
NAMES = """
    INSERT INTO sweep_names (sweep_number, kind, name, place)
    SELECT sweep_number, '{kind}', {kind},
           row_number() OVER (PARTITION BY sweep_number ORDER BY min(ordinal)) - 1
    FROM runs GROUP BY sweep_number, {kind}"""
SCORES = """
    UPDATE runs SET score = (
        SELECT CASE WHEN count(*) = count(return_mean) THEN avg(return_mean) END FROM measurements
        WHERE run_number = runs.number AND (10 * measurements.timestep > 9 * runs.timesteps
            OR measurements.timestep = (
                SELECT max(last.timestep) FROM measurements AS last
                WHERE last.run_number = runs.number)))
    WHERE status = 'succeeded'"""


def upgrade() -> None:
    """Add the columns and the table, and fill them from the runs."""
    op.add_column("sweeps", sa.Column("notes", sa.Text(), nullable=False, server_default=""))
    op.add_column("sweeps", sa.Column("archived_at", sa.Double()))
    op.add_column("runs", sa.Column("score", sa.Double()))
    op.create_table(
        "sweep_names",
        sa.Column("sweep_number", NUMBER, nullable=False),
        sa.Column("kind", sa.Text(), nullable=False),
        sa.Column("name", sa.Text(), nullable=False),
        sa.Column("place", sa.Integer(), nullable=False),
        sa.ForeignKeyConstraint(
            ["sweep_number"], ["sweeps.number"], name="fk_sweep_names_sweep_number"
        ),
        sa.PrimaryKeyConstraint("sweep_number", "kind", "name", name="pk_sweep_names"),
    )
    for kind in ("algorithm", "environment"):
        op.execute(NAMES.format(kind=kind))
    op.execute(SCORES)


def downgrade() -> None:
    """Forget them."""
    op.drop_table("sweep_names")
    op.drop_column("runs", "score")
    op.drop_column("sweeps", "archived_at")
    op.drop_column("sweeps", "notes")
