"""What was acknowledged is there: a process killed at each of its writes, a disk that fails.

strace does the harm; the databases are real files. Slow.
"""

import re
import shutil
import subprocess
import sys
from itertools import count
from pathlib import Path

import pytest

from service.store.connection import connect
from service.store.store import Store
from service.store.upkeep.integrity import check
from tests.service.store.conftest import Fresh
from tests.service.store.submitting import submit

pytestmark = [
    pytest.mark.slow,
    pytest.mark.timeout(600),
    pytest.mark.skipif(shutil.which("strace") is None, reason="needs strace: apt-get install it"),
]

RUNS = 1000
SECONDS = 60


def strace(arguments: list[str], url: str, sweeps: int, runs: int, log: Path) -> tuple[int, str]:
    """Submit under strace; the exit code and what was said."""
    command = [sys.executable, "-m", "tests.service.store.submitting", url, str(sweeps), str(runs)]
    done = subprocess.run(
        ["strace", "-f", "-o", str(log), *arguments, *command],
        capture_output=True,
        text=True,
        timeout=SECONDS,
        check=False,
    )
    return done.returncode, done.stdout


def kept(said: str) -> list[str]:
    return re.findall(r"^(\S+) kept$", said, re.MULTILINE)


def assert_whole(url: str) -> None:
    engine = connect(url, "reader")
    with engine.connect() as connection:
        assert [each for each in check(connection) if each.faults] == []
    engine.dispose()


def test_every_acknowledgement_has_reached_the_disk(fresh_sqlite: Fresh, tmp_path: Path) -> None:
    log = tmp_path / "strace"
    code, said = strace(["-e", "trace=fsync,fdatasync"], fresh_sqlite(), 100, 1, log)
    assert (code, len(kept(said))) == (0, 100)
    assert len(re.findall(r"f(?:data)?sync\(", log.read_text())) >= 100


def test_killed_at_any_write_a_sweep_is_there_whole_or_not_at_all(
    fresh_sqlite: Fresh, tmp_path: Path
) -> None:
    """strace counts the writes of each thread; the first ones are those of opening the store."""
    outcomes = set()
    for write in count(1):
        url = fresh_sqlite(0)
        harm = ["-e", "trace=pwrite64", "-e", f"inject=pwrite64:signal=KILL:when={write}"]
        code, said = strace(harm, url, 1, RUNS, tmp_path / "strace")
        store = Store.open(url)
        sweeps = store.list_sweeps()
        assert [sweep.runs.total for sweep in sweeps] in ([], [RUNS])
        assert len(sweeps) >= len(kept(said))
        outcomes.add(len(sweeps))
        sweep_id = submit(store, "key-0", RUNS)  # the client asks again
        assert [sweep.id for sweep in store.list_sweeps()] == [sweep_id]
        assert len(store.list_runs(sweep_id, limit=2 * RUNS)) == RUNS
        store.close()
        assert_whole(url)
        if code == 0:
            break
    assert outcomes == {0, 1}
    assert write > 50


@pytest.mark.parametrize(
    ("harm", "sentence"),
    [
        ("fsync:error=EIO:when=5..9", "disk I/O error"),
        ("pwrite64:error=EIO:when=30..40", "disk I/O error"),
        ("pwrite64:error=ENOSPC:when=30..40", "database or disk is full"),
    ],
)
def test_a_disk_that_fails_for_a_while_is_said_and_loses_nothing(
    fresh_sqlite: Fresh, tmp_path: Path, harm: str, sentence: str
) -> None:
    url = fresh_sqlite()
    call = harm.partition(":")[0]
    arguments = ["-e", f"trace={call}", "-e", f"inject={harm}"]
    code, said = strace(arguments, url, 40, 4, tmp_path / "strace")
    assert code == 0, said
    assert sentence in said
    assert said.splitlines()[-1].endswith("kept")  # it goes on by itself
    store = Store.open(url)
    names = {sweep.name for sweep in store.list_sweeps(limit=100)}
    store.close()
    assert names >= set(kept(said))
    assert_whole(url)
