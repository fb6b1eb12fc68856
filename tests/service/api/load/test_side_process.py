"""The process beside: one thing after the other, bounded, and gone with the service."""

import os
import subprocess
import sys
import threading
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import pytest

from service.api.load import side_process
from service.api.load.side_process import AbandonedError, BusyError, SideProcess, TooSlowError


@pytest.fixture
def side() -> Iterator[SideProcess]:
    side = SideProcess(limit_seconds=30.0)
    yield side
    side.close()


def test_results_and_errors_come_back(side: SideProcess) -> None:
    assert side.call("operator:add", 2, 3) == 5
    other = side.call("os:getpid")
    assert other != os.getpid()
    with pytest.raises(ZeroDivisionError, match="by zero"):
        side.call("operator:floordiv", 1, 0)
    with pytest.raises(AttributeError, match="no_such"):
        side.call("operator:no_such")
    assert side.call("os:getpid") == other


def test_another_starts_where_one_died(side: SideProcess) -> None:
    first = side.call("os:getpid")
    with pytest.raises(EOFError):
        side.call("os:_exit", 1)
    assert side.call("os:getpid") != first


def test_what_takes_too_long_is_ended() -> None:
    side = SideProcess(limit_seconds=0.2)
    with pytest.raises(TooSlowError, match=r"longer than 0\.2 s"):
        side.call("time:sleep", 3600)
    side.close()


def test_so_many_wait_and_no_more(side: SideProcess, monkeypatch: pytest.MonkeyPatch) -> None:
    entered, leave = threading.Event(), threading.Event()

    def work(*_: object) -> None:
        entered.set()
        leave.wait()

    monkeypatch.setattr(side, "_call", work)
    with ThreadPoolExecutor() as threads:
        monkeypatch.setattr(side, "_waiting", threading.Semaphore(1))
        first = threads.submit(side.call, "anything")
        entered.wait()
        with pytest.raises(BusyError):
            side.call("anything")
        leave.set()
        first.result()
    assert side_process.MOST_WAITING > 1


def test_what_waits_too_long_or_is_given_up_is_not_begun(side: SideProcess) -> None:
    impatient = SideProcess(waiting_seconds=0.0)
    with impatient._turn, pytest.raises(BusyError, match="others before it took 0 s"):
        impatient.call("os:getpid")
    with pytest.raises(AbandonedError):
        side.call("os:_exit", 1, is_wanted=lambda: False)
    assert side.call("operator:add", 2, 3) == 5, "the next one has its turn"


def test_it_has_no_secret_of_the_service(
    side: SideProcess, monkeypatch: pytest.MonkeyPatch
) -> None:
    for name in ("D3PG_TOKEN", "D3PG_DATABASE_URL", "PGPASSWORD", "RAY_AUTH_TOKEN"):
        monkeypatch.setenv(name, "a-secret-of-the-service")
    pid = side.call("os:getpid")
    assert "a-secret" not in Path(f"/proc/{pid}/environ").read_text()


def test_a_closed_one_starts_nothing(side: SideProcess) -> None:
    side.close()
    with pytest.raises(RuntimeError, match="stopping"):
        side.call("os:getpid")


def test_closing_ends_what_it_does(side: SideProcess) -> None:
    side.call("os:getpid")  # it is up
    with ThreadPoolExecutor() as threads:
        busy = threads.submit(side.call, "signal:pause")
        while not side._turn.locked():
            pass
        side.close()
        with pytest.raises((EOFError, OSError, RuntimeError)):
            busy.result()


def test_it_ends_with_the_service_however_that_ends() -> None:
    """A service that is killed leaves no process behind: the pipe of its output closes."""
    code = (
        "import os\n"
        "from service.api.load.side_process import SideProcess\n"
        "if __name__ == '__main__':\n"
        "    print(SideProcess().call('os:getpid'), flush=True)\n"
        "    os.kill(os.getpid(), 9)\n"
    )
    service = subprocess.run(
        [sys.executable, "-c", code], stdout=subprocess.PIPE, timeout=60, check=False
    )
    assert service.returncode == -9
    assert int(service.stdout) > 0  # and `run` returned: the other end of its output is closed too
