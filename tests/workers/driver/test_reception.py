"""The reception: one service after the other, all with the same terms."""

import socket
import stat
import threading
from collections.abc import Iterator
from contextlib import suppress
from dataclasses import replace
from pathlib import Path

import pytest

from workers.driver import reception as module
from workers.driver.outbox import GREETING, Outbox
from workers.driver.reception import Reception, listening
from workers.driver.settings import DriverSettings
from workers.driver.terms import Terms

TERMS = Terms("head:6379", least=1, most=2, worker_bytes=0, checkpoints="/data/checkpoints")


@pytest.fixture
def settings(tmp_path: Path) -> DriverSettings:
    return DriverSettings(tmp_path / "sock", tmp_path, tmp_path / "spool", str(tmp_path))


class Driver:
    """A process as its services see it: it does nothing, and notes what they say."""

    def __init__(self, reception: Reception) -> None:
        self.terms: list[Terms | None] = []
        self.said: list[bytes] = []
        self._reception = reception
        self.thread = threading.Thread(target=self._run)
        self.thread.start()

    def _run(self) -> None:
        self.terms.append(self._reception.first_terms())
        for visit in self._reception.visits():
            self.said += visit.lines


@pytest.fixture
def driver(settings: DriverSettings) -> Iterator[Driver]:
    with listening(settings) as listener:
        driver = Driver(Reception(listener, Outbox(settings.spool), waits_long=True))
        yield driver
        with visitor(settings, replace(TERMS, address="an end").to_line()):
            driver.thread.join()


def visitor(settings: DriverSettings, first_line: bytes) -> socket.socket:
    channel = socket.socket(socket.AF_UNIX)
    channel.settimeout(10.0)
    channel.connect(str(settings.socket))
    channel.sendall(first_line)
    return channel


def answer(channel: socket.socket) -> str:
    """What it is told first; empty where it was hung up on."""
    with channel.makefile("r") as lines:
        return lines.readline().strip()


def test_services_with_the_same_terms_come_one_after_the_other(
    driver: Driver, settings: DriverSettings
) -> None:
    for word in (b"one\n", b"two\n"):
        with visitor(settings, TERMS.to_line()) as service:
            assert answer(service) == GREETING
            service.sendall(word)
    with visitor(settings, TERMS.to_line()) as service:
        assert answer(service) == GREETING
        assert driver.said == [b"one\n", b"two\n"]
    assert driver.terms == [TERMS]


def test_one_with_other_terms_ends_what_was_made_for_the_others(
    driver: Driver, settings: DriverSettings
) -> None:
    with visitor(settings, TERMS.to_line()) as service:
        assert answer(service) == GREETING
    with visitor(settings, replace(TERMS, most=3).to_line()) as service:
        driver.thread.join(10.0)
        assert not driver.thread.is_alive()
        assert answer(service) == ""
    assert driver.terms == [TERMS]


@pytest.mark.parametrize("first_line", [b"GET / HTTP/1.1\n", b"x" * 200_000, b"\n"])
def test_who_states_no_terms_is_hung_up_on_and_disturbs_nobody(
    driver: Driver,
    settings: DriverSettings,
    first_line: bytes,
    capsys: pytest.CaptureFixture[str],
) -> None:
    # Reset, where what it had to say was not read to its end.
    with visitor(settings, first_line) as stranger, suppress(ConnectionResetError):
        assert answer(stranger) == ""
    with visitor(settings, TERMS.to_line()) as service:
        assert answer(service) == GREETING
    assert driver.terms == [TERMS]
    assert "it did not say what it asks for" in capsys.readouterr().err


def test_who_says_nothing_does_not_hold_the_others_up(
    driver: Driver, settings: DriverSettings, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(module, "FIRST_WORD_SECONDS", 0.1)
    with visitor(settings, b"") as silent, visitor(settings, TERMS.to_line()) as service:
        assert answer(service) == GREETING
        assert answer(silent) == ""


def test_one_that_a_service_started_does_not_wait_for_ever(
    settings: DriverSettings, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(module, "IDLE_NO_SERVICE_SECONDS", 0.0)
    with listening(settings) as listener:
        assert Reception(listener, Outbox(settings.spool), waits_long=False).first_terms() is None


def test_the_socket_is_for_its_user_alone_and_takes_the_place_of_an_earlier_one(
    settings: DriverSettings,
) -> None:
    for _ in range(2):
        with listening(settings):
            mode = settings.socket.stat().st_mode
            assert stat.S_ISSOCK(mode)
            assert mode & 0o777 == 0o600


def test_a_listener_that_was_handed_down_is_used(settings: DriverSettings) -> None:
    with socket.socket(socket.AF_UNIX) as theirs:
        theirs.bind(str(settings.socket))
        theirs.listen(1)
        handed = replace(settings, listener=theirs.detach())
        with listening(handed) as listener:
            assert listener.getsockname() == str(settings.socket)
