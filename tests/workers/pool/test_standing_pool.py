"""The pool of a process that stands apart: found at its socket, and not believed blindly."""

import json
import queue
import socket
import threading
from collections.abc import Iterable, Iterator
from pathlib import Path

import pytest

from workers.driver.outbox import GREETING
from workers.driver.terms import Terms
from workers.messages.report import Capacity, Report, to_line
from workers.pool import driven_pool
from workers.pool.pool import PoolUnavailableError
from workers.pool.standing_pool import StandingPool

TERMS = Terms("head:6379", least=1, most=2, worker_bytes=0, checkpoints="/data/checkpoints")


class Process:
    """One at a socket that says what a test says, and notes what it is told, for one service."""

    def __init__(self, path: Path, words: bytes) -> None:
        self.told: list[bytes] = []
        self._words = words
        self._listener = socket.socket(socket.AF_UNIX)
        self._listener.bind(str(path))
        self._listener.listen(1)
        self._thread = threading.Thread(target=self._serve)
        self._thread.start()

    def _serve(self) -> None:
        channel, _ = self._listener.accept()
        with channel, channel.makefile("rb") as lines:
            self.told.append(lines.readline())
            if self._words:
                channel.sendall(self._words)
                self.told += lines

    def close(self) -> None:
        self._thread.join()
        self._listener.close()


@pytest.fixture
def pool(tmp_path: Path) -> Iterator[StandingPool]:
    pool = StandingPool(tmp_path / "sock", TERMS)
    yield pool
    pool.close()


def test_it_says_where_nobody_listens(pool: StandingPool, tmp_path: Path) -> None:
    with pytest.raises(PoolUnavailableError, match=f"answers at {tmp_path / 'sock'}.*No such file"):
        pool.start()


def test_it_says_that_it_was_hung_up_on(pool: StandingPool, tmp_path: Path) -> None:
    process = Process(tmp_path / "sock", b"")
    with pytest.raises(PoolUnavailableError, match="hung up: its log says why"):
        pool.start()
    process.close()
    assert process.told == [TERMS.to_line()]


def test_commands_and_reports_pass(pool: StandingPool, tmp_path: Path) -> None:
    line = to_line(Capacity(2, slots=0))
    process = Process(tmp_path / "sock", f"{GREETING}\n{line}\n".encode())
    pool.start()
    assert pool.reports(10.0) == [Capacity(2, slots=0)]
    pool.acknowledge(1)
    pool.close()
    process.close()
    assert [json.loads(each).get("do") for each in process.told[1:]] == ["acknowledge", "close"]


class OnTheWay(queue.SimpleQueue[Report | None]):
    """Reports of which one is there, and each of the others once somebody waits for it."""

    def __init__(self, reports: Iterable[Report | None]) -> None:
        self._coming = iter(reports)
        self.put(next(self._coming))

    def get(self, block: bool = True, timeout: float | None = None) -> Report | None:
        if self.empty() and timeout:
            self.put(next(self._coming))
        return super().get(block, timeout)


def test_reports_on_the_way_are_gathered(pool: StandingPool) -> None:
    first, second = Capacity(2, slots=0), Capacity(2, slots=2)
    pool._reports = OnTheWay([first, second, None])
    assert pool.reports(10.0) == [first]
    assert pool.reports(10.0, gather_seconds=3600.0) == [second]
    pool._reports = OnTheWay([first, second, None])
    assert pool.reports(10.0, gather_seconds=3600.0) == [first, second]
    with pytest.raises(PoolUnavailableError):  # the end was not lost
        pool.reports(10.0, gather_seconds=3600.0)


@pytest.mark.parametrize("line", [b"news worker-1 " + b"[" * 100_000, b"x" * 5000, b"nonsense"])
def test_what_is_no_report_ends_the_connection(
    pool: StandingPool, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, line: bytes
) -> None:
    monkeypatch.setattr(driven_pool, "LONGEST_LINE", 200_000 if line.startswith(b"news") else 1000)
    process = Process(tmp_path / "sock", f"{GREETING}\n".encode() + line + b"\n")
    pool.start()
    with pytest.raises(PoolUnavailableError, match="ended: its log says why"):
        pool.reports(10.0)
    process.close()
