"""A process that need not be our child, and all that it has started."""

import os
import select
import signal
from pathlib import Path


def runs_with(pid: int, argument: str) -> bool:
    """Whether that process exists and was started with that argument."""
    try:
        arguments = Path(f"/proc/{pid}/cmdline").read_bytes().split(b"\0")
    except OSError:
        return False
    return argument.encode() in arguments


def wait_for_end(pid: int, seconds: float) -> None:
    """Wait so long at most for the end of a process."""
    try:
        descriptor = os.pidfd_open(pid)
    except ProcessLookupError:
        return
    try:
        select.select([descriptor], [], [], seconds)
    finally:
        os.close(descriptor)


def kill_group(leader: int) -> None:
    """Kill the remaining processes of a group."""
    try:
        os.killpg(leader, signal.SIGKILL)
    except ProcessLookupError:
        return
