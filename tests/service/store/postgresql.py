"""A PostgreSQL server of the tests' own: in a new directory, on a socket in it, as nobody."""

import os
import pwd
import shutil
import signal
import subprocess
import tempfile
import time
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

import psycopg

START_SECONDS = 30.0
FAST = ("fsync=off", "full_page_writes=off")  # a server that dies may lose data, none of ours does


class PostgreSQL:
    """One server, running. `crash` and `start` are for tests of what a restart does."""

    def __init__(self, folder: Path, settings: tuple[str, ...]) -> None:
        """Make the cluster of databases and start the server."""
        self._folder = folder
        self._settings = (*settings, "listen_addresses=", f"unix_socket_directories={folder}")
        self.databases: set[str] = set()
        make: list[str | Path] = [programs() / "initdb", "--pgdata", folder / "data"]
        subprocess.run(
            [
                *make,
                "--username=d3pg",
                "--auth=trust",
                "--encoding=UTF8",
                "--locale=C",
                "--no-sync",
            ],
            cwd=folder,
            check=True,
            capture_output=True,
            user=account(),
        )
        self.start()

    def start(self) -> None:
        """Start the server and wait until it answers."""
        options = [word for setting in self._settings for word in ("-c", setting)]
        with (self._folder / "log").open("ab") as log:
            self._process = subprocess.Popen(
                [programs() / "postgres", "-D", self._folder / "data", *options],
                cwd=self._folder,
                stdout=log,
                stderr=log,
                user=account(),
            )
        deadline = time.monotonic() + START_SECONDS
        while True:
            try:
                self.execute("SELECT 1")
            except psycopg.OperationalError:
                assert time.monotonic() < deadline, (self._folder / "log").read_text()
                time.sleep(0.02)
            else:
                return

    @property
    def process_id(self) -> int:
        """The server's process, whose children serve the sessions."""
        return self._process.pid

    def stop(self) -> None:
        """Stop it in order: its sessions are ended."""
        self._process.send_signal(signal.SIGINT)
        self._process.wait(START_SECONDS)

    def crash(self) -> None:
        """Stop it as `pg_ctl --mode=immediate` does: what was under way is gone."""
        self._process.send_signal(signal.SIGQUIT)
        self._process.wait(START_SECONDS)

    def execute(self, statement: str, database: str = "postgres") -> None:
        """Run one statement outside of any transaction, as the server's owner."""
        with psycopg.connect(self.conninfo(database), autocommit=True) as connection:
            connection.execute(statement.encode())

    def create(self, name: str) -> str:
        """Make a database and return its address."""
        self.execute(f"CREATE DATABASE {name}")
        self.databases.add(name)
        return self.url(name)

    def ask_passwords_of(self, database: str) -> None:
        """Let nobody into a database without a password, from now on."""
        rules = self._folder / "data" / "pg_hba.conf"
        rules.write_text(f"local {database} all scram-sha-256\n{rules.read_text()}")
        self.execute("SELECT pg_reload_conf()")
        deadline = time.monotonic() + START_SECONDS
        with suppress(psycopg.OperationalError):
            while True:
                psycopg.connect(self.conninfo(database)).close()
                assert time.monotonic() < deadline, "the rules were not read"
                time.sleep(0.02)

    def url(self, database: str, user: str = "d3pg") -> str:
        """The address of a database, for SQLAlchemy."""
        return f"postgresql+psycopg://{user}@/{database}?host={self._folder}"

    def conninfo(self, database: str) -> str:
        """The address of a database, for psycopg."""
        return f"host={self._folder} user=d3pg dbname={database}"


def programs() -> Path:
    """Where Debian keeps the newest server's programs."""
    found = sorted(Path("/usr/lib/postgresql").glob("*/bin/initdb"), key=lambda p: int(p.parts[4]))
    assert found, "the tests need PostgreSQL: apt-get install postgresql (`make test` does)"
    return found[-1].parent


def account() -> str | None:
    """Who runs the server: it refuses root."""
    if os.geteuid() != 0:
        return None
    names = {entry.pw_name for entry in pwd.getpwall()}
    return "postgres" if "postgres" in names else "nobody"


@contextmanager
def running_postgresql(*settings: str) -> Iterator[PostgreSQL]:
    """A server that is gone afterwards, its databases too; without settings, a fast one."""
    folder = Path(tempfile.mkdtemp(prefix="d3pg-postgresql-"))  # short: a socket's path is
    if (owner := account()) is not None:
        shutil.chown(folder, owner)
    try:
        server = PostgreSQL(folder, settings or FAST)
        try:
            yield server
        finally:
            server.stop()
    finally:
        shutil.rmtree(folder)
