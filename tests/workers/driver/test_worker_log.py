"""The log of a worker: told as it grows, bounded, begun anew."""

import os
import subprocess
import sys
from pathlib import Path

import pytest

from workers.driver.worker_log import LONGEST_BYTES, WorkerLog
from workers.messages.log_tail import TAIL_BYTES


@pytest.fixture
def path(tmp_path: Path) -> Path:
    return tmp_path / "logs" / "worker-1.log"


def printed(path: Path, text: str) -> None:
    with path.open("a") as log:
        log.write(text)


def test_it_is_told_where_there_is_more(path: Path) -> None:
    log = WorkerLog(path)
    assert log.news(0.0) == ""
    printed(path, "one\n")
    assert log.news(0.0) == "one\n"
    assert log.news(0.0) == ""
    printed(path, "two\n")
    assert log.news(0.0) == "one\ntwo\n"


def test_it_is_told_no_more_often_than_asked(path: Path) -> None:
    now = [100.0]
    log = WorkerLog(path, lambda: now[0])
    printed(path, "one\n")
    assert log.news(2.0) == "one\n"
    printed(path, "two\n")
    now[0] += 1.9
    assert log.news(2.0) == ""
    now[0] += 0.1
    assert log.news(2.0) == "one\ntwo\n"


def test_a_cohort_begins_it_anew(path: Path) -> None:
    log = WorkerLog(path)
    printed(path, "of another\n")
    assert log.news(0.0) == "of another\n"
    log.begin()
    assert log.tail() == log.news(0.0) == ""
    printed(path, "of this one\n")
    assert log.news(0.0) == "of this one\n"


def test_a_long_one_is_cut_to_its_end(path: Path) -> None:
    log = WorkerLog(path)
    printed(path, "".join(f"line {number}\n" for number in range(LONGEST_BYTES // 8)))
    tail = log.news(0.0)
    assert tail.endswith(f"line {LONGEST_BYTES // 8 - 1}\n")
    assert path.read_text() == tail
    assert len(tail) <= TAIL_BYTES
    assert log.news(0.0) == ""
    printed(path, "the next\n")
    assert log.news(0.0).endswith(f"{tail[-20:]}the next\n")


def test_it_takes_all_output_of_its_process(path: Path) -> None:
    code = f"""
import logging, os, sys
from pathlib import Path
from workers.driver.worker_log import WorkerLog
log = WorkerLog(Path({str(path)!r}))
log.take_output()
print("printed")
log.tail()
logging.getLogger("a task").info("logged %d", 1)
logging.getLogger("a task").debug("not logged")
os.write(2, b"of a library in C\\n")
"""
    environment = {**os.environ, "PYTHONPATH": os.pathsep.join(sys.path)}
    subprocess.run([sys.executable, "-c", code], check=True, env=environment)
    first, second, third = path.read_text().splitlines()
    assert (first, third) == ("printed", "of a library in C")
    assert second.endswith("INFO a task: logged 1")
