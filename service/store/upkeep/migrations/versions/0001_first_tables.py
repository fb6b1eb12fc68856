"""The first tables: sweeps, runs, attempts, measurements, events, random returns."""

import sqlalchemy as sa
from alembic import op

revision: str = "0001"
down_revision: str | None = None

NUMBER = sa.BigInteger().with_variant(sa.Integer(), "sqlite")


def upgrade() -> None:
    """Make the tables."""
    _make_sweeps()
    _make_runs()
    _make_attempts()
    _make_measurements()
    _make_events()
    _make_random_returns()


def downgrade() -> None:
    """Drop them, the dependent ones first."""
    for table in (
        "random_returns",
        "events",
        "measurements",
        "diagnostic_sets",
        "attempts",
        "runs",
        "sweeps",
    ):
        op.drop_table(table)


def _make_sweeps() -> None:
    op.create_table(
        "sweeps",
        sa.Column("number", NUMBER, autoincrement=True),
        sa.Column("id", sa.Text(), nullable=False),
        sa.Column("name", sa.Text(), nullable=False),
        sa.Column("priority", sa.Integer(), nullable=False),
        sa.Column("request", sa.Text(), nullable=False),
        sa.Column("created_at", sa.Double(), nullable=False),
        sa.Column("last_claimed_at", sa.Double(), nullable=False),
        sa.Column("cancelled_at", sa.Double()),
        sa.PrimaryKeyConstraint("number", name="pk_sweeps"),
        sa.UniqueConstraint("id", name="uq_sweeps_id"),
        sqlite_autoincrement=True,
    )


def _make_runs() -> None:
    op.create_table(
        "runs",
        sa.Column("number", NUMBER, autoincrement=True),
        sa.Column("sweep_number", NUMBER, nullable=False),
        sa.Column("ordinal", sa.Integer(), nullable=False),
        sa.Column("cell", sa.Integer(), nullable=False),
        sa.Column("algorithm", sa.Text(), nullable=False),
        sa.Column("environment", sa.Text(), nullable=False),
        sa.Column("environment_version", sa.Integer(), nullable=False),
        sa.Column("seed", sa.BigInteger(), nullable=False),
        sa.Column("w1", sa.Double(), nullable=False),
        sa.Column("w2", sa.Double(), nullable=False),
        sa.Column("config", sa.Text(), nullable=False),
        sa.Column("timesteps", sa.BigInteger(), nullable=False),
        sa.Column("status", sa.Text(), nullable=False),
        sa.Column("reason", sa.Text(), nullable=False),
        sa.Column("attempt", sa.Integer(), nullable=False),
        sa.Column("timestep", sa.BigInteger(), nullable=False),
        sa.Column("is_cancelling", sa.Boolean(), nullable=False),
        sa.Column("losses", sa.Integer(), nullable=False),
        sa.Column("not_before", sa.Double(), nullable=False),
        sa.Column("lease_until", sa.Double()),
        sa.Column("created_at", sa.Double(), nullable=False),
        sa.Column("started_at", sa.Double()),
        sa.Column("finished_at", sa.Double()),
        sa.Column("fingerprint", sa.Text()),
        sa.PrimaryKeyConstraint("number", name="pk_runs"),
        sa.ForeignKeyConstraint(["sweep_number"], ["sweeps.number"], name="fk_runs_sweep_number"),
        sa.UniqueConstraint("sweep_number", "ordinal", name="uq_runs_sweep_number_ordinal"),
        sa.CheckConstraint(
            "(status = 'running') = (lease_until IS NOT NULL)", name="ck_runs_lease"
        ),
        sqlite_autoincrement=True,
    )
    op.create_index(
        "ix_runs_sweep_number_status_ordinal", "runs", ["sweep_number", "status", "ordinal"]
    )
    _index_status("ix_runs_queued", ["sweep_number", "ordinal", "not_before"], "queued")
    _index_status("ix_runs_running", ["sweep_number", "lease_until", "is_cancelling"], "running")


def _index_status(name: str, columns: list[str], status: str) -> None:
    condition = sa.text(f"status = '{status}'")
    op.create_index(name, "runs", columns, sqlite_where=condition, postgresql_where=condition)


def _make_attempts() -> None:
    op.create_table(
        "attempts",
        sa.Column("run_number", NUMBER, nullable=False),
        sa.Column("attempt", sa.Integer(), nullable=False),
        sa.Column("worker", sa.Text(), nullable=False),
        sa.Column("outcome", sa.Text(), nullable=False),
        sa.Column("error", sa.Text(), nullable=False),
        sa.Column("log_tail", sa.Text(), nullable=False),
        sa.Column("started_at", sa.Double(), nullable=False),
        sa.Column("ended_at", sa.Double()),
        sa.Column("fingerprint", sa.Text()),
        sa.PrimaryKeyConstraint("run_number", "attempt", name="pk_attempts"),
        sa.ForeignKeyConstraint(["run_number"], ["runs.number"], name="fk_attempts_run_number"),
    )


def _make_measurements() -> None:
    op.create_table(
        "diagnostic_sets",
        sa.Column("number", NUMBER, autoincrement=True),
        sa.Column("names", sa.Text(), nullable=False),
        sa.PrimaryKeyConstraint("number", name="pk_diagnostic_sets"),
        sa.UniqueConstraint("names", name="uq_diagnostic_sets_names"),
    )
    op.create_table(
        "measurements",
        sa.Column("run_number", NUMBER, nullable=False),
        sa.Column("timestep", sa.BigInteger(), autoincrement=False, nullable=False),
        sa.Column("return_mean", sa.Double()),
        sa.Column("return_history", sa.Double()),
        sa.Column("updates", sa.BigInteger(), nullable=False),
        sa.Column("jacobians", sa.BigInteger(), nullable=False),
        sa.Column("seconds", sa.Double()),
        sa.Column("diagnostic_set", NUMBER, nullable=False),
        sa.Column("diagnostics", sa.LargeBinary(), nullable=False),
        sa.PrimaryKeyConstraint("run_number", "timestep", name="pk_measurements"),
        sa.ForeignKeyConstraint(["run_number"], ["runs.number"], name="fk_measurements_run_number"),
        sa.ForeignKeyConstraint(
            ["diagnostic_set"], ["diagnostic_sets.number"], name="fk_measurements_diagnostic_set"
        ),
        sqlite_with_rowid=False,
    )


def _make_events() -> None:
    op.create_table(
        "events",
        sa.Column("id", NUMBER, autoincrement=True),
        sa.Column("sweep_number", NUMBER, nullable=False),
        sa.Column("kind", sa.Text(), nullable=False),
        sa.Column("payload", sa.Text(), nullable=False),
        sa.Column("created_at", sa.Double(), nullable=False),
        sa.PrimaryKeyConstraint("id", name="pk_events"),
        sa.ForeignKeyConstraint(["sweep_number"], ["sweeps.number"], name="fk_events_sweep_number"),
        sqlite_autoincrement=True,
    )
    op.create_index("ix_events_sweep_number_id", "events", ["sweep_number", "id"])


def _make_random_returns() -> None:
    op.create_table(
        "random_returns",
        sa.Column("environment", sa.Text(), nullable=False),
        sa.Column("version", sa.Integer(), autoincrement=False, nullable=False),
        sa.Column("mean", sa.Double(), nullable=False),
        sa.Column("low", sa.Double(), nullable=False),
        sa.Column("high", sa.Double(), nullable=False),
        sa.Column("episodes", sa.Integer(), nullable=False),
        sa.Column("measured_at", sa.Double(), nullable=False),
        sa.PrimaryKeyConstraint("environment", "version", name="pk_random_returns"),
    )
