"""A disk that fills up, for real: told in sentences, nothing acknowledged lost, over by itself."""

import json
import os
import subprocess
from collections.abc import Iterator
from http import HTTPStatus
from pathlib import Path

import pytest
from fastapi import FastAPI
from httpx2 import Response
from starlette.testclient import TestClient
from typer.testing import CliRunner

from service.cli.app import app as commands
from service.store.store import Store
from service.store.upkeep.trouble import FULL
from tests.service.conftest import SWEEP, TOKEN
from tests.service.served import served

SWEEPS = "/api/v1/sweeps"
RUNS = 12  # of the sweep


@pytest.fixture
def disk(tmp_path: Path) -> Iterator[Path]:
    """A small disk of its own."""
    folder = tmp_path / "disk"
    folder.mkdir()
    mount = ["mount", "-t", "tmpfs", "-o", "size=8m", "d3pg-test", str(folder)]
    done = subprocess.run(mount, capture_output=True, text=True, check=False)
    if done.returncode != 0:
        pytest.skip(f"a small disk cannot be mounted here: {done.stderr.strip()}")
    yield folder
    subprocess.run(["umount", str(folder)], check=True)


@pytest.fixture
def store(disk: Path) -> Iterator[Store]:
    opened = Store.open(f"sqlite:///{disk / 'd3pg.sqlite'}")
    yield opened
    opened.close()


def fill(disk: Path) -> Path:
    """Take all the space there is."""
    filler = disk / "filler"
    with filler.open("wb", buffering=0) as file:
        try:
            while True:
                file.write(bytes(os.sysconf("SC_PAGESIZE")))
        except OSError:
            return filler


def database_problem(client: TestClient) -> str | None:
    (problem,) = (
        each["problem"]
        for each in client.get("/readyz").json()["checks"]
        if each["name"] == "database"
    )
    return None if problem is None else str(problem)


def submit_until_refused(client: TestClient) -> tuple[list[str], Response]:
    """The sweeps that were acknowledged, and the refusal."""
    acknowledged: list[str] = []
    for _ in range(200):
        response = client.post(SWEEPS, json=SWEEP)
        if response.status_code != HTTPStatus.ACCEPTED:
            return acknowledged, response
        acknowledged.append(response.json()["id"])
    pytest.fail("the disk did not fill up")


def test_a_full_disk_is_told_and_over_when_there_is_space(
    client: TestClient, store: Store, disk: Path
) -> None:
    acknowledged = [client.post(SWEEPS, json=SWEEP).json()["id"]]
    filler = fill(disk)
    more, refusal = submit_until_refused(client)
    acknowledged += more

    assert refusal.status_code == HTTPStatus.SERVICE_UNAVAILABLE
    assert refusal.headers["content-type"] == "application/problem+json"
    assert int(refusal.headers["retry-after"]) > 0
    assert refusal.json()["type"] == "database-full"
    assert refusal.json()["detail"].startswith(str(FULL))
    assert database_problem(client) == str(FULL)
    assert client.get(f"{SWEEPS}/{acknowledged[0]}").status_code == HTTPStatus.OK

    filler.unlink()
    assert database_problem(client) is None
    acknowledged.append(client.post(SWEEPS, json=SWEEP).json()["id"])
    assert sorted(sweep.id for sweep in store.list_sweeps()) == sorted(acknowledged)
    assert all(sweep.runs.total == RUNS for sweep in store.list_sweeps())


def test_the_command_line_tells_it(
    app: FastAPI, client: TestClient, disk: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    filler = fill(disk)
    submit_until_refused(client)
    monkeypatch.setenv("D3PG_TOKEN", TOKEN)
    with served(app) as url:
        monkeypatch.setenv("D3PG_URL", url)
        refused = CliRunner().invoke(commands, ["submit", "-"], input=json.dumps(SWEEP))
        assert str(FULL) in str(refused.exception)  # which the command `d3pg` prints
        filler.unlink()
        submitted = CliRunner().invoke(commands, ["submit", "-"], input=json.dumps(SWEEP))
        assert submitted.exit_code == 0, submitted.output
