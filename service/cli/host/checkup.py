"""The checks of `d3pg doctor`; they change nothing."""

from __future__ import annotations

import os
import shutil
import socket
import subprocess
import sys
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Literal

import pysqlite3.dbapi2
from pydantic import ValidationError
from sqlalchemy import URL, make_url, text
from sqlalchemy.exc import SQLAlchemyError

from service.api.schemas.readiness_answer import ReadinessAnswer
from service.client import Client, ServiceError
from service.refusal import RefusalError
from service.settings import Settings
from service.store.connection import check_sqlite, connect
from service.store.unusable import GENERAL, advice, reason_of
from workers.checkpoints.place import Place, folder_in

Verdict = Literal["ok", "warning", "failed"]

OLDEST_PYTHON = (3, 11)
LIBRARIES = {"torch": "2.13.", "ray": "2.60.", "numba": "0.68."}
IMPORT_SECONDS = 120
ANSWER_SECONDS = 5.0
LEAST_FREE, SCARCE = 0.5e9, 5e9  # bytes of disk
LEAST_MEMORY, SCARCE_MEMORY = 1e9, 2e9  # bytes; an idle Ray takes some 0.7e9


@dataclass(frozen=True)
class Finding:
    """What one check found, and what to do about it."""

    check: str
    verdict: Verdict
    found: str
    advice: str = ""


def examine() -> Iterator[Finding]:
    """Run all checks in order; those that need settings only if the settings are valid."""
    yield check_python(sys.version_info[:3])
    for library, series in LIBRARIES.items():
        yield check_library(library, series)
    yield check_memory(os.sysconf("SC_PAGE_SIZE") * os.sysconf("SC_AVPHYS_PAGES"))
    try:
        settings = Settings()
    except ValidationError as error:
        yield from unreadable(error)
        return
    yield check_disk(settings.data_dir)
    yield check_checkpoints(settings.checkpoint_place)
    yield check_token(settings.data_dir / "token")
    yield check_database(settings.store_url)
    yield check_port(settings)


def check_python(running: tuple[int, ...]) -> Finding:
    """Whether this Python is new enough."""
    found = ".".join(map(str, running))
    if running[:2] >= OLDEST_PYTHON:
        return Finding("python", "ok", f"{found}, {sys.executable}")
    return Finding("python", "failed", found, "Install Python 3.11 or newer.")


def check_library(name: str, series: str) -> Finding:
    """Whether a library of the right series loads, in a process of its own."""
    code = f"import {name}; print({name}.__version__)"
    try:
        done = subprocess.run(  # noqa: S603 - our own interpreter and code
            [sys.executable, "-c", code],
            capture_output=True, text=True, timeout=IMPORT_SECONDS, check=False,
        )  # fmt: skip
    except subprocess.TimeoutExpired:
        return Finding(name, "failed", f"did not load within {IMPORT_SECONDS} s", reinstall(name))
    if done.returncode:
        last = (done.stderr.strip().splitlines() or ["it died"])[-1]
        return Finding(name, "failed", f"does not load: {last}", reinstall(name))
    found = done.stdout.strip()
    if found.startswith(series):
        return Finding(name, "ok", found)
    return Finding(name, "failed", f"{found}, not {series}*", reinstall(name))


def reinstall(name: str) -> str:
    """What to do about a library."""
    return f"pip install '{name}=={LIBRARIES[name]}*'"


def check_memory(available: float) -> Finding:
    """Whether a Ray and its workers fit into the free memory [bytes]."""
    found = f"{available / 1e9:.1f} GB free"
    advice = "A worker needs about 0.5 GB, Ray 0.7 GB: end other programs, or lower D3PG_WORKERS."
    if available < LEAST_MEMORY:
        return Finding("memory", "failed", found, advice)
    if available < SCARCE_MEMORY:
        return Finding("memory", "warning", found, advice)
    return Finding("memory", "ok", found)


def unreadable(error: ValidationError) -> Iterator[Finding]:
    """One finding for each setting that the service would refuse."""
    for problem in error.errors():
        name = "_".join(["D3PG", *(str(part).upper() for part in problem["loc"])])
        yield Finding("settings", "failed", f"{name}: {problem['msg']}", "Correct or unset it.")


def check_disk(data_dir: Path) -> Finding:
    """Whether the data directory, or where it will be made, can be written and has room."""
    place = next(
        each for each in (data_dir.absolute(), *data_dir.absolute().parents) if each.exists()
    )
    if not os.access(place, os.W_OK | os.X_OK) or not place.is_dir():
        advice = "Choose another directory with D3PG_DATA_DIR (--data-dir)."
        return Finding("disk", "failed", f"{place} cannot be written", advice)
    free = shutil.disk_usage(place).free
    found = f"{free / 1e9:.1f} GB free for {data_dir}"
    advice = "Make room, or choose another directory with D3PG_DATA_DIR (--data-dir)."
    if free < LEAST_FREE:
        return Finding("disk", "failed", found, advice)
    return Finding(
        "disk", "ok" if free >= SCARCE else "warning", found, "" if free >= SCARCE else advice
    )


def check_checkpoints(place: Place) -> Finding:
    """Whether the place of the checkpoints can be read."""
    try:
        folder_in(place, "d3pg-doctor").names()
    except OSError as trouble:
        advice = "Runs still train, but an interrupted run begins again from the start."
        return Finding("checkpoints", "failed", f"{place}: {trouble.strerror}", advice)
    return Finding("checkpoints", "ok", f"{place} can be read from here")


def check_token(file: Path) -> Finding:
    """Whether the token file, if there is one, is its owner's alone."""
    if not file.exists():
        return Finding("token", "ok", "none yet: the first start of the service makes one")
    if file.stat().st_mode & 0o077:
        advice = f"Run chmod 600 {file}, or delete it if somebody else has read it."
        return Finding("token", "failed", f"{file} can be read by other users", advice)
    return Finding("token", "ok", f"{file}, readable by its owner alone")


def check_database(url: str | URL) -> Finding:
    """Whether the database can be opened and holds tables of ours, or is still to be made."""
    address = make_url(url)
    shown = address.render_as_string(hide_password=True)
    try:
        if address.get_backend_name() == "sqlite":
            check_sqlite(pysqlite3.dbapi2.sqlite_version_info)
            shown = f"SQLite {pysqlite3.dbapi2.sqlite_version}, {address.database}"
            if not Path(address.database or "").exists():
                return Finding("database", "ok", f"{shown}, not made yet")
        runs = counted_runs(url)
    except RefusalError as error:
        return Finding("database", "failed", shown, str(error))
    except SQLAlchemyError as error:
        general = f"{GENERAL} `d3pg serve` makes a new database."
        known = advice(address, error)
        return Finding("database", "failed", f"{shown}: {reason_of(error)}", known or general)
    return Finding("database", "ok", f"{shown}, {runs} runs")


def counted_runs(url: str | URL) -> int:
    """How many runs the database holds. Raises SQLAlchemyError."""
    engine = connect(url, "reader")
    try:
        with engine.connect() as connection:
            return int(connection.execute(text("SELECT count(*) FROM runs")).scalar_one())
    finally:
        engine.dispose()


def check_port(settings: Settings) -> Finding:
    """Whether the port is free, or a service of ours answers there."""
    where = f"{settings.host}:{settings.port}"
    with socket.socket(socket.AF_INET6 if ":" in settings.host else socket.AF_INET) as probe:
        probe.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        try:
            probe.bind((settings.host, settings.port))
        except OSError as error:
            refusal = error.strerror
        else:
            return Finding("port", "ok", f"{where} is free")
    try:
        with Client(settings.url, timeout_seconds=ANSWER_SECONDS) as client:
            return running_service(where, client.readiness())
    except ServiceError:
        advice = "Choose another port with D3PG_PORT (--port), or end what listens there."
        return Finding("port", "failed", f"{where} cannot be used: {refusal}", advice)


def running_service(where: str, readiness: ReadinessAnswer) -> Finding:
    """The readiness of a service that already runs."""
    problems = [check.problem for check in readiness.checks if check.problem]
    if not problems:
        return Finding("port", "ok", f"the service runs at {where} and is ready")
    return Finding("port", "warning", f"the service runs at {where}: {'; '.join(problems)}")
