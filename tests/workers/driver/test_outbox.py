"""The outbox: what is not recorded is told again, to the next listener or through the spool."""

import socket
from pathlib import Path

import pytest

from workers.driver.outbox import GREETING, Outbox, lines_left_in
from workers.messages.assignment import Assignment
from workers.messages.progress import Progress
from workers.messages.report import (
    Busy,
    Capacity,
    Ended,
    Lost,
    News,
    Ready,
    Report,
    from_line,
    to_line,
)
from workers.messages.run_spec import RunSpec
from workers.messages.work import Work

READY = Ready("worker-1", 4711, "here")
BUSY = Busy("worker-1", Work("a-0/1", (Assignment("a-0", 1, RunSpec("ddpg", "Pendulum", 0), 1),)))
NEWS = [News("worker-1", "a-0/1", Progress(800 * step)) for step in range(1, 4)]
ENDED = Ended("worker-1", "a-0/1")
LOST = Lost("worker-1", "its worker ended while the service was away", "")


class Listener:
    """The other end of a connection."""

    def __init__(self, outbox: Outbox) -> None:
        self._ours, theirs = socket.socketpair()
        self._ours.settimeout(10.0)
        self._theirs = theirs
        self._lines = self._ours.makefile("rb")
        outbox.attach(theirs)
        assert self.line() == GREETING

    def line(self) -> str:
        return self._lines.readline().decode().strip()

    def hear(self, count: int) -> list[Report]:
        return [from_line(self.line()) for _ in range(count)]

    def close(self) -> None:
        for end in (self._lines, self._ours, self._theirs):
            end.close()


@pytest.fixture
def spool(tmp_path: Path) -> Path:
    return tmp_path / "spool" / "pool.jsonl"


@pytest.fixture
def outbox(spool: Path) -> Outbox:
    return Outbox(spool)


def left_in(spool: Path) -> list[Report]:
    return [from_line(line) for line in lines_left_in(spool)]


def put(outbox: Outbox, *reports: Report) -> None:
    for report in reports:
        outbox.put(to_line(report))


def test_what_was_not_acknowledged_is_told_again_after_what_each_worker_does(
    outbox: Outbox,
) -> None:
    put(outbox, READY, BUSY, NEWS[0])
    first = Listener(outbox)
    assert first.hear(3) == [READY, BUSY, NEWS[0]]
    outbox.acknowledge(3)
    put(outbox, NEWS[1])
    assert first.hear(1) == [NEWS[1]]
    outbox.detach()
    first.close()
    put(outbox, NEWS[2], ENDED)
    second = Listener(outbox)
    assert second.hear(4) == [BUSY, NEWS[1], NEWS[2], ENDED]
    outbox.acknowledge(4)
    outbox.detach()
    second.close()
    third = Listener(outbox)
    assert third.hear(1) == [READY]
    third.close()


def test_what_nobody_heard_is_in_the_spool_until_it_is_recorded(
    outbox: Outbox, spool: Path
) -> None:
    put(outbox, READY, BUSY)
    first = Listener(outbox)
    assert first.hear(2) == [READY, BUSY]
    outbox.acknowledge(2)
    outbox.detach()
    first.close()
    put(outbox, *NEWS)
    assert left_in(spool) == [BUSY, *NEWS, LOST]
    second = Listener(outbox)
    assert second.hear(4) == [BUSY, *NEWS]
    outbox.acknowledge(4)
    assert not spool.exists()
    second.close()


def test_the_next_process_tells_what_one_left_and_keeps_it_until_it_is_recorded(
    outbox: Outbox, spool: Path
) -> None:
    put(outbox, READY, BUSY, NEWS[0])
    left = [READY, BUSY, NEWS[0], LOST]
    following = Outbox(spool)
    following.put(to_line(Capacity(1, slots=0)))  # while nobody listens
    assert left_in(spool)[:4] == left
    first = Listener(following)
    assert first.hear(5) == [*left, Capacity(1, slots=0)]
    following.acknowledge(4)
    following.detach()
    first.close()
    assert left_in(spool) == [Capacity(1, slots=0)]
    second = Listener(following)
    assert second.hear(1) == [Capacity(1, slots=0)]
    following.acknowledge(1)
    assert not spool.exists()
    second.close()


@pytest.mark.parametrize(
    "damaged",
    [
        to_line(NEWS[1])[:40],
        to_line(NEWS[1]).replace("cohort", "cohorx"),
        to_line(ENDED).replace("cohort", "cohorx"),
        to_line(ENDED).replace("ended", "ender"),
        "3",
        "ended",
        "ended worker-1",
        "ended worker-1 []",
        "ended worker-1 {}",
        '{"kind": "ended"}',
    ],
)
def test_a_damaged_line_is_left_out(spool: Path, damaged: str) -> None:
    spool.parent.mkdir()
    spool.write_text(f"{to_line(BUSY)}\n{to_line(NEWS[0])}\n{damaged}")
    assert left_in(spool)[:-1] == [BUSY, NEWS[0]]


def test_it_trains_on_a_disk_that_takes_nothing(tmp_path: Path) -> None:
    (tmp_path / "spool").write_text("a file where the folder would be")
    outbox = Outbox(tmp_path / "spool" / "pool.jsonl")
    put(outbox, READY, BUSY)
    listener = Listener(outbox)
    assert listener.hear(2) == [READY, BUSY]
    listener.close()


def test_what_the_cluster_has_room_for_is_told_to_every_listener(outbox: Outbox) -> None:
    put(outbox, Capacity(1, slots=1), READY, Capacity(2, slots=1))
    first = Listener(outbox)
    assert first.hear(3) == [Capacity(1, slots=1), READY, Capacity(2, slots=1)]
    outbox.acknowledge(3)
    outbox.detach()
    first.close()
    second = Listener(outbox)
    assert second.hear(2) == [Capacity(2, slots=1), READY]
    second.close()


def test_a_line_is_passed_on_unread(outbox: Outbox) -> None:
    """Between worker and service nobody parses a report."""
    outbox.put("news worker-1 {this is no JSON")
    listener = Listener(outbox)
    assert listener.line() == "news worker-1 {this is no JSON"
    outbox.acknowledge(1)
    outbox.detach()
    listener.close()
