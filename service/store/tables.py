"""The tables.

    sweeps 1-* runs 1-* attempts
                    1-1 diagnoses
                    1-* measurements *-1 diagnostic_sets
           1-* sweep_names   its tags, algorithms and environments: what it is found by
    events         what changed, in order; what the event stream reads
    random_returns what uniform random actions earn, per environment version
    users, shares, sessions   who may call the service; of their tokens the SHA-256 alone
    last_commit    one row: the name of the latest commit

A run's name is "<sweep>-<ordinal>"; inside, rows are joined by integers. Times are float64 seconds
since 1970 by the database's clock.

Measurements and events have no foreign keys: PostgreSQL checks one in the time that a row takes.
Their writer has read the run and the sweep in the same transaction, they go before what they refer
to does (`claiming.deletion`), and `integrity` looks. No index has a column that every report
changes (`lease_until`, `timestep`): PostgreSQL writes all indexes of a row anew where one has.
"""

from sqlalchemy import (
    BigInteger,
    Boolean,
    CheckConstraint,
    Column,
    Double,
    ForeignKey,
    Index,
    Integer,
    LargeBinary,
    MetaData,
    Table,
    Text,
    UniqueConstraint,
    false,
    func,
    literal,
    text,
)

from service.model.caller import ADMINISTRATOR
from service.store.column_types import Document, Exact, now

metadata = MetaData(
    naming_convention={
        "ix": "ix_%(table_name)s_%(column_0_N_name)s",
        "uq": "uq_%(table_name)s_%(column_0_N_name)s",
        "ck": "ck_%(table_name)s_%(constraint_name)s",
        "fk": "fk_%(table_name)s_%(column_0_name)s",
        "pk": "pk_%(table_name)s",
    }
)

# SQLite numbers rows by itself only where the column's type is exactly INTEGER.
Number = BigInteger().with_variant(Integer, "sqlite")

sweeps = Table(
    "sweeps",
    metadata,
    Column("number", Number, primary_key=True, autoincrement=True),
    Column("id", Text, nullable=False, unique=True),
    Column("name", Text, nullable=False),
    Column("priority", Integer, nullable=False),
    Column("request", Document, nullable=False),
    Column("created_at", Double, nullable=False, default=now()),
    Column("last_claimed_at", Double, nullable=False, default=0.0),
    Column("cancelled_at", Double),
    Column("paused_at", Double),
    Column("submission_key", Text, unique=True, index=True),
    Column("question", Text),  # "open" or "settled", or the search; NULL: it asks and searches none
    Column("search", Document),  # as it was planned; NULL: it does not search
    Column("notes", Text, nullable=False, default="", server_default=""),
    Column("archived_at", Double),
    Column("deleted_at", Double),  # nobody sees it any more; its rows and files go bit by bit
    Column("max_workers", Integer),
    Column("webhook", Text),  # a URL
    Column("webhook_delivered_at", Double),  # of the latest end; also where that was given up
    Column("webhook_tries", Integer, nullable=False, default=0, server_default="0"),
    Column("webhook_problem", Text, nullable=False, default="", server_default=""),
    Column("webhook_not_before", Double, nullable=False, default=0.0, server_default="0"),
    Column("owner", Text, nullable=False, default=ADMINISTRATOR, server_default=ADMINISTRATOR),
    sqlite_autoincrement=True,
)
_open = text("question = 'open'")
Index("ix_sweeps_open", sweeps.c.number, sqlite_where=_open, postgresql_where=_open)

is_asking = (func.coalesce(sweeps.c.question, "") == "open") & sweeps.c.cancelled_at.is_(None)
is_there = sweeps.c.deleted_at.is_(None)

sweep_names = Table(
    "sweep_names",
    metadata,
    Column("sweep_number", ForeignKey(sweeps.c.number), primary_key=True),
    Column("kind", Text, primary_key=True),  # "tag", "algorithm" or "environment"
    Column("name", Text, primary_key=True),
    Column("place", Integer, nullable=False),  # in the order that they were given
)

runs = Table(
    "runs",
    metadata,
    Column("number", Number, primary_key=True, autoincrement=True),
    Column("sweep_number", ForeignKey(sweeps.c.number), nullable=False),
    Column("ordinal", Integer, nullable=False),
    Column("cell", Integer, nullable=False),  # numbers the cells of one sweep
    Column("entry", Integer, nullable=False, default=0, server_default="0"),
    Column("algorithm", Text, nullable=False),
    Column("environment", Text, nullable=False),
    Column("environment_version", Integer, nullable=False),
    Column("seed", BigInteger, nullable=False),
    Column("w1", Double, nullable=False),
    Column("w2", Double, nullable=False),
    Column("config", Document, nullable=False),
    Column("timesteps", BigInteger, nullable=False),
    Column("status", Text, nullable=False, default="queued"),
    Column("reason", Text, nullable=False, default=""),
    Column("attempt", Integer, nullable=False, default=0),
    Column("timestep", BigInteger, nullable=False, default=0),
    Column("is_cancelling", Boolean, nullable=False, default=False),
    Column("losses", Integer, nullable=False, default=0),  # workers lost in a row
    Column("not_before", Double, nullable=False, default=0.0),
    Column("lease_until", Double),
    Column("created_at", Double, nullable=False, default=now()),
    Column("started_at", Double),
    Column("finished_at", Double),
    Column("fingerprint", Document),
    Column("checkpoint_timestep", BigInteger, nullable=False, default=0, server_default="0"),
    Column("resumed_timestep", BigInteger),  # NULL until the current attempt's worker says
    Column("memory_bytes", BigInteger),
    Column("score", Exact),  # of a run that succeeded: its final score, as it was measured
    Column("may_have_policy", Boolean, nullable=False, default=False, server_default=false()),
    Column("kept_bytes", BigInteger),  # of checkpoints that are kept after its end; NULL: unknown
    # Set by a claim, not by what a worker tells: it may be lost between writing and telling.
    Column("may_have_files", Boolean, nullable=False, default=False, server_default=false()),
    UniqueConstraint("sweep_number", "ordinal"),
    CheckConstraint("(status = 'running') = (lease_until IS NOT NULL)", name="lease"),
    sqlite_autoincrement=True,
)
# Written out, not bound: SQLite takes a partial index only for a condition it can read.
is_queued = runs.c.status == literal("queued", literal_execute=True)
is_running = runs.c.status == literal("running", literal_execute=True)
Index("ix_runs_sweep_number_status_ordinal", runs.c.sweep_number, runs.c.status, runs.c.ordinal)
_queued, _running = text("status = 'queued'"), text("status = 'running'")
Index(
    "ix_runs_queued",
    runs.c.sweep_number,
    runs.c.ordinal,
    runs.c.not_before,
    sqlite_where=_queued,
    postgresql_where=_queued,
)
Index(
    "ix_runs_running",
    runs.c.sweep_number,
    sqlite_where=_running,
    postgresql_where=_running,
)
Index(
    "ix_runs_cancelling",
    runs.c.sweep_number,
    sqlite_where=text("is_cancelling = 1"),
    postgresql_where=text("is_cancelling"),
)
Index(
    "ix_runs_may_have_files",
    runs.c.status,
    sqlite_where=text("may_have_files = 1"),
    postgresql_where=text("may_have_files"),
)

attempts = Table(
    "attempts",
    metadata,
    Column("run_number", ForeignKey(runs.c.number), primary_key=True),
    Column("attempt", Integer, primary_key=True),
    Column("worker", Text, nullable=False),
    Column("outcome", Text, nullable=False, default="running"),
    Column("error", Text, nullable=False, default=""),
    Column("log_tail", Text, nullable=False, default=""),
    Column("started_at", Double, nullable=False, default=now()),
    Column("ended_at", Double),
    Column("fingerprint", Document),
    Column("resumed_timestep", BigInteger),
    Column("note", Text, nullable=False, default="", server_default=""),
)

diagnostic_sets = Table(
    "diagnostic_sets",
    metadata,
    Column("number", Number, primary_key=True, autoincrement=True),
    Column("names", Text, nullable=False, unique=True),  # a JSON list
)

measurements = Table(
    "measurements",
    metadata,
    Column("run_number", Number, primary_key=True, autoincrement=False),
    Column("timestep", BigInteger, primary_key=True, autoincrement=False),
    Column("return_mean", Exact),  # which `packed` has too: SQL sorts by it, and takes its means
    Column("updates", BigInteger, nullable=False),
    Column("jacobians", BigInteger, nullable=False),
    Column("diagnostic_set", Number, nullable=False),
    Column("packed", LargeBinary, nullable=False),  # service.store.reading.packed
    sqlite_with_rowid=False,
)

diagnoses = Table(
    "diagnoses",
    metadata,
    Column("run_number", ForeignKey(runs.c.number), primary_key=True),
    Column("attempt", Integer, nullable=False),
    Column("asked_at", Double, nullable=False, default=now()),
    Column("is_waiting", Boolean, nullable=False, default=True),
    Column("findings", Text),  # NULL while there are none
    Column("problem", Text, nullable=False, default=""),
)
Index(
    "ix_diagnoses_waiting",
    diagnoses.c.asked_at,
    sqlite_where=text("is_waiting = 1"),
    postgresql_where=text("is_waiting"),
)

events = Table(
    "events",
    metadata,
    Column("id", Number, primary_key=True, autoincrement=True),
    Column("sweep_number", Number, nullable=False),
    Column("kind", Text, nullable=False),
    Column("payload", Document, nullable=False),
    Column("created_at", Double, nullable=False, default=now()),
    sqlite_autoincrement=True,
)
Index("ix_events_sweep_number_id", events.c.sweep_number, events.c.id)

random_returns = Table(
    "random_returns",
    metadata,
    Column("environment", Text, primary_key=True),
    Column("version", Integer, primary_key=True, autoincrement=False),
    Column("mean", Double, nullable=False),
    Column("low", Double, nullable=False),
    Column("high", Double, nullable=False),
    Column("episodes", Integer, nullable=False),
    Column("measured_at", Double, nullable=False, default=now()),
)

users = Table(
    "users",
    metadata,
    Column("name", Text, primary_key=True),
    Column("scope", Text, nullable=False),
    Column("token_hash", Text, nullable=False),
    Column("created_at", Double, nullable=False, default=now()),
    Column("revoked_at", Double),
)

shares = Table(
    "shares",
    metadata,
    Column("id", Text, primary_key=True),
    Column("token_hash", Text, nullable=False),
    Column("sweeps", Document, nullable=False),  # a list of ids
    Column("page", Text, nullable=False),
    Column("made_by", Text, nullable=False),
    Column("created_at", Double, nullable=False),
    Column("expires_at", Double, nullable=False),
)

sessions = Table(
    "sessions",
    metadata,
    Column("id", Text, primary_key=True),
    Column("token_hash", Text, nullable=False),
    Column("key_hash", Text, nullable=False),
    Column("name", Text, nullable=False),
    Column("browser", Text, nullable=False),
    Column("created_at", Double, nullable=False),
    Column("expires_at", Double, nullable=False),
)

last_commit = Table("last_commit", metadata, Column("name", Text, primary_key=True))
