"""A pool that an earlier service left is taken up where it speaks as this one does."""

import json
import signal
import socket
import subprocess
import sys
import tempfile
import threading
from collections.abc import Iterator
from pathlib import Path

import pytest

from workers.messages.report import FORMAT
from workers.pool.process import PoolProcess, PoolSettings


@pytest.fixture
def scratch() -> Iterator[Path]:
    """Where the process listens: a short name, for a socket's path has at most 107 bytes."""
    with tempfile.TemporaryDirectory(prefix="d3pg-", ignore_cleanup_errors=True) as folder:
        yield Path(folder)


def left(settings: PoolSettings, scratch: Path, spoken: int) -> "subprocess.Popen[bytes]":
    """A process as an earlier service left it, with its record; it greets whoever connects."""
    code = "print('up', flush=True); import time; time.sleep(600)"
    command = [sys.executable, "-c", code, f"--scratch={scratch}"]
    process = subprocess.Popen(command, start_new_session=True, stdout=subprocess.PIPE)
    assert process.stdout is not None
    with process.stdout as output:
        assert output.readline() == b"up\n"
    record = {"format": spoken, "process": process.pid, "scratch": str(scratch)}
    (settings.data_dir / "pool.json").write_text(json.dumps(record))
    return process


def greet(listener: socket.socket) -> None:
    """Greet one service, and listen to it until it goes."""
    channel, _ = listener.accept()
    with channel:
        channel.sendall(b"greeting\n")
        while channel.recv(4096):
            pass


@pytest.mark.parametrize("spoken", [FORMAT, FORMAT - 1])
def test_a_pool_of_another_format_is_ended(
    tmp_path: Path, scratch: Path, monkeypatch: pytest.MonkeyPatch, spoken: int
) -> None:
    monkeypatch.setattr(PoolProcess, "_launch", lambda _: None)
    settings = PoolSettings(2, "", tmp_path, tmp_path / "checkpoints")
    pool, process = PoolProcess(settings), left(settings, scratch, spoken)
    with socket.socket(socket.AF_UNIX) as listener, socket.socket(socket.AF_UNIX) as nobody:
        listener.bind(f"{scratch}/pool.sock")
        listener.listen(1)
        greeter = threading.Thread(target=greet, args=(listener,))
        greeter.start()
        if spoken == FORMAT:
            pool.start()
            assert pool.process_id == process.pid
            pool.close()
        else:
            nobody.connect(f"{scratch}/pool.sock")
            assert nobody.recv(16) == b"greeting\n"
            pool.start()
        assert pool.process_id is None
    assert process.wait(10.0) == -signal.SIGKILL
    assert not scratch.exists()
    greeter.join()
