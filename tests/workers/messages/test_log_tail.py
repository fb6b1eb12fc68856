"""The end of a log."""

from pathlib import Path

import pytest

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


@pytest.mark.parametrize(
    ("printed", "shown"),
    [
        ("\x1b[31mred\x1b[0m and \x1b[1;4mbold\x1b[m\n", "red and bold\n"),
        ("\x1b]0;a title\x07text\x1b[2K\n", "text\n"),
        ("  0%\r 50%\r100%\ndone\n", "100%\ndone\n"),
        ("one\r\ntwo\r\n", "one\ntwo\n"),
    ],
)
def test_it_is_what_a_terminal_would_show(tmp_path: Path, printed: str, shown: str) -> None:
    log = tmp_path / "log"
    log.write_bytes(printed.encode())
    assert log_tail(log) == shown


@pytest.mark.parametrize("between", ["\r", ""])
def test_of_one_long_line_the_end_is_kept(tmp_path: Path, between: str) -> None:
    log = tmp_path / "log"
    log.write_bytes(between.join(f"step {step}" for step in range(5000)).encode())
    assert log_tail(log).endswith("step 4999")
