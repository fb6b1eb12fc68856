"""Event streams over real connections: resumable, closed cleanly, none left behind."""

import asyncio
import gc
import json
import signal
import socket
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path

import httpx2
import pytest
from fastapi import FastAPI
from starlette.testclient import TestClient

from service.store.connection import READERS
from tests.end_to_end.running_service import free_port
from tests.service.conftest import SWEEP, TOKEN
from tests.service.served import served

HEADERS = {"Authorization": f"Bearer {TOKEN}"}
CONNECTIONS = 3 * READERS  # descriptors of the store's connections, which are kept once opened
Message = dict[str, str]


@pytest.fixture
def url(app: FastAPI) -> Iterator[str]:
    """A real server of the application."""
    with served(app) as url:
        yield url


@contextmanager
def stream(url: str, path: str, **headers: str) -> Iterator[Iterator[Message]]:
    """The messages of a stream, field by field."""
    with (
        httpx2.Client(base_url=url, headers=HEADERS | headers, timeout=10) as client,
        client.stream("GET", path) as response,
    ):
        assert response.status_code == 200
        assert response.headers["content-type"].startswith("text/event-stream")
        yield messages(response.iter_lines())


def messages(lines: Iterator[str]) -> Iterator[Message]:
    message: Message = {}
    for line in lines:
        if line:
            field, _, value = line.partition(": ")
            message[field] = value
            continue
        if "event" in message:
            yield message
        message = {}


def test_a_stream_tells_what_changes_and_resumes(url: str, client: TestClient) -> None:
    with stream(url, "/api/v1/events") as told:
        assert next(told)["event"] == "reload"
        sweep = client.post("/api/v1/sweeps", json=SWEEP).json()
        created = next(told)
        assert created["event"] == "sweep"
        assert json.loads(created["data"])["sweep_id"] == sweep["id"]
    client.post(sweep["links"]["cancel"])
    with stream(url, sweep["links"]["events"], **{"Last-Event-ID": created["id"]}) as told:
        resumed = [next(told) for _ in range(13)]
    assert [message["event"] for message in resumed] == ["sweep", *["run"] * 12]
    ids = [int(message["id"]) for message in resumed]
    assert ids == sorted(set(ids))
    assert ids[0] == int(created["id"]) + 1
    with stream(url, f"/api/v1/events?after={ids[-2]}") as told:
        assert next(told) == resumed[-1]


@pytest.mark.parametrize("last", ["x", "-1", "9" * 20])
def test_a_nonsense_position_starts_anew(url: str, last: str) -> None:
    with stream(url, "/api/v1/events", **{"Last-Event-ID": last}) as told:
        assert next(told)["event"] == "reload"


def test_aborted_streams_leave_nothing_behind(url: str, app: FastAPI, client: TestClient) -> None:
    del client
    host, port = url.removeprefix("http://").split(":")
    request = (
        f"GET /api/v1/events HTTP/1.1\r\nHost: {host}:{port}\r\n"
        f"Authorization: Bearer {TOKEN}\r\n\r\n"
    )
    with stream(url, "/api/v1/events") as told:
        assert next(told)["event"] == "reload"
    feed = app.state.event_feed
    wait_for(lambda: feed.listeners == 0)
    bound = left_open() + CONNECTIONS
    for _ in range(5):
        open_sockets = [socket.create_connection((host, int(port))) for _ in range(100)]
        for each in open_sockets:
            each.sendall(request.encode())
        for each in open_sockets[::2]:  # some before the first byte, some after it
            each.recv(1)
        for each in open_sockets:
            each.close()
    wait_for(lambda: feed.listeners == 0 and left_open() <= bound)


def wait_for(is_so: Callable[[], bool]) -> None:
    deadline = time.monotonic() + 20
    while not is_so():
        assert time.monotonic() < deadline
        time.sleep(0.05)


def left_open() -> int:
    """Descriptors and tasks of this process, in which the server runs too."""
    gc.collect()
    # By type: isinstance asks some objects of torch for their class, and they warn of it.
    tasks = [each for each in gc.get_objects() if issubclass(type(each), asyncio.Task)]
    running = sum(not task.done() for task in tasks)
    return running + len(list(Path("/proc/self/fd").iterdir()))


SERVER = """
import sys
import uvicorn
from service.api.app import create_app
from service.settings import Settings
from service.store.store import Store

class Dispatcher:
    problem = None

settings = Settings()
store = Store.open(settings.store_url)
app = create_app(settings, store, Dispatcher())
uvicorn.run(app, port=settings.port, log_config=None, timeout_graceful_shutdown=2)
store.close()
"""


def test_sigterm_ends_the_server_with_50_streams_open(tmp_path: Path) -> None:
    port = free_port()
    variables = {"D3PG_DATA_DIR": str(tmp_path), "D3PG_TOKEN": TOKEN, "D3PG_PORT": str(port)}
    path = {"PYTHONPATH": ":".join(filter(None, sys.path))}
    server = subprocess.Popen([sys.executable, "-c", SERVER], env=variables | path)
    try:
        wait_until_healthy(port)
        clients = [socket.create_connection(("127.0.0.1", port)) for _ in range(50)]
        for each in clients:
            each.sendall(
                f"GET /api/v1/events HTTP/1.1\r\nHost: localhost\r\nAuthorization: Bearer {TOKEN}"
                "\r\n\r\n".encode()
            )
        for each in clients:
            assert each.recv(1)
        started = time.monotonic()
        server.send_signal(signal.SIGTERM)
        server.wait(10)
        assert time.monotonic() - started < 5
        for each in clients:
            each.close()
    finally:
        server.kill()
        server.wait()


def wait_until_healthy(port: int) -> None:
    deadline = time.monotonic() + 60
    while time.monotonic() < deadline:
        try:
            if httpx2.get(f"http://127.0.0.1:{port}/healthz").status_code == 200:
                return
        except httpx2.TransportError:
            time.sleep(0.1)
    pytest.fail("the server did not start")
