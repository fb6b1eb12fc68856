"""Machines of a cluster, as far as one machine can play them: processes that live and die together.

A `Machine` runs one program and all that comes of it, as a container does: when the program ends,
everything ends. `separate_machines` gives each a network, processes and a host name of its own,
joined by a bridge, which takes root; `Machine` alone shares those of this one.
"""

import os
import shutil
import signal
import subprocess
import tempfile
import time
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager, suppress
from pathlib import Path

from tests.workers.processes import processes_with

MARK = "TESTED_MACHINE"
END_SECONDS = 60.0
AS_A_CONTAINER = ("unshare", "--pid", "--uts", "--fork", "--kill-child", "--mount-proc")
INIT = 'hostname "$0" && { "$@" & wait $!; }'  # a shell, so that orphans are reaped


class Machine:
    """One machine: off until it is started; `ends` when its program does."""

    def __init__(self, folder: Path, address: str = "127.0.0.1", namespace: str = "") -> None:
        """Have its output and its temporary files in the folder; start nothing yet."""
        self.folder = folder
        self.address = address
        self._namespace = namespace
        self._process: subprocess.Popen[bytes] | None = None
        folder.mkdir()

    def command(self, program: Sequence[str]) -> list[str]:
        """Return what runs a program on this machine, started with its `mark`."""
        if not self._namespace:
            return list(program)
        entered = ("ip", "netns", "exec", self._namespace, *AS_A_CONTAINER)
        return [*entered, "sh", "-c", INIT, self._namespace, *program]

    @property
    def mark(self) -> dict[str, str]:
        """What tells its processes: a variable in their environment."""
        return {MARK: str(self.folder)}

    def start(self, program: Sequence[str], environment: Mapping[str, str]) -> None:
        """Run a program with that environment; `terminal` has its output."""
        with (self.folder / "terminal.txt").open("wb") as terminal:
            self._process = subprocess.Popen(
                self.command(program),
                env={**environment, **self.mark},
                stdin=subprocess.DEVNULL,
                stdout=terminal,
                stderr=terminal,
                start_new_session=True,
            )

    @property
    def is_on(self) -> bool:
        """Whether its program runs."""
        return self._process is not None and self._process.poll() is None

    @property
    def processes(self) -> set[int]:
        """All that runs on it, orphans too."""
        return processes_with(f"{MARK}={self.folder}\0")

    def kill(self) -> None:
        """Take its power: nothing of it runs any more."""
        deadline = time.monotonic() + END_SECONDS
        while left := self.processes:
            self._send(signal.SIGKILL, left)
            if self._process is not None:
                self._process.wait(END_SECONDS)  # reaped: Ray goes by that
            assert time.monotonic() < deadline, left
            time.sleep(0.01)

    def freeze(self) -> None:
        """Stop all that runs on it, as `docker pause` does."""
        self._send(signal.SIGSTOP, self.processes)

    def thaw(self) -> None:
        """Let it go on."""
        self._send(signal.SIGCONT, self.processes)

    def unplug(self) -> None:
        """Cut it off the network; what runs on it does not notice at once."""
        _ip("link", "set", self._namespace, "down")

    def plug_in(self) -> None:
        """Connect it again."""
        _ip("link", "set", self._namespace, "up")

    def terminal(self) -> str:
        """Everything that was printed on it since it was last started."""
        return (self.folder / "terminal.txt").read_text()

    def _send(self, number: signal.Signals, processes: set[int]) -> None:
        for pid in processes:
            with suppress(ProcessLookupError):
                os.kill(pid, number)


@contextmanager
def short_folder() -> Iterator[Path]:
    """A folder for machines, gone afterwards; short, for the path of a socket has 107 bytes."""
    folder = Path(tempfile.mkdtemp(prefix="d3pg-m-"))
    try:
        yield folder
    finally:
        shutil.rmtree(folder)


@contextmanager
def separate_machines(names: Sequence[str]) -> Iterator[list[Machine]]:
    """Machines with networks of their own, reachable from this one; all end with the block."""
    bridge = f"d3pg{os.getpid()}"  # an interface's name has 15 bytes at most
    network = f"198.18.{os.getpid() % 256}"  # for tests of networks, says RFC 2544
    namespaces = [f"{bridge}-{number}" for number in range(len(names))]
    with short_folder() as folder:
        try:
            _ip("link", "add", bridge, "type", "bridge")
            _ip("address", "add", f"{network}.1/24", "dev", bridge)
            _ip("link", "set", bridge, "up")
            machines = []
            for number, (name, namespace) in enumerate(zip(names, namespaces, strict=True), 2):
                _connect(namespace, bridge, network, number)
                machines.append(Machine(folder / name, f"{network}.{number}", namespace))
            try:
                yield machines
            finally:
                for machine in machines:
                    machine.kill()
        finally:
            for namespace in namespaces:
                _ip("link", "delete", namespace, check=False)
                _ip("netns", "delete", namespace, check=False)
            _ip("link", "delete", bridge, check=False)


def can_separate() -> bool:
    """Whether this process may make networks: root may, outside of a container."""
    made = _ip("netns", "add", f"d3pg{os.getpid()}", check=False)
    _ip("netns", "delete", f"d3pg{os.getpid()}", check=False)
    return made


def _connect(namespace: str, bridge: str, network: str, number: int) -> None:
    _ip("netns", "add", namespace)
    _ip("link", "add", namespace, "type", "veth", "peer", "name", "eth0", "netns", namespace)
    _ip("link", "set", namespace, "master", bridge, "up")
    _ip("-netns", namespace, "address", "add", f"{network}.{number}/24", "dev", "eth0")
    _ip("-netns", namespace, "link", "set", "eth0", "up")
    _ip("-netns", namespace, "link", "set", "lo", "up")
    _ip("-netns", namespace, "route", "add", "default", "via", f"{network}.1")


def _ip(*words: str, check: bool = True) -> bool:
    done = subprocess.run(["ip", *words], check=check, capture_output=not check)
    return done.returncode == 0
