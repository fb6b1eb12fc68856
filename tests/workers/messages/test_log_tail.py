"""The end of a log."""

from pathlib import Path

from workers.messages.log_tail import TAIL_BYTES, log_tail


def test_short_logs_are_whole(tmp_path: Path) -> None:
    log = tmp_path / "log"
    log.write_text("one\ntwo\n")
    assert log_tail(log) == "one\ntwo\n"


def test_long_logs_lose_their_beginning_at_a_line(tmp_path: Path) -> None:
    log = tmp_path / "log"
    log.write_bytes(b"".join(b"line %05d \xff\n" % number for number in range(5000)))
    tail = log_tail(log)
    assert len(tail) <= TAIL_BYTES
    assert tail.startswith("line 0")
    assert tail.splitlines()[-1] == "line 04999 \N{REPLACEMENT CHARACTER}"


def test_no_log_is_an_empty_one(tmp_path: Path) -> None:
    assert log_tail(tmp_path / "none") == ""
