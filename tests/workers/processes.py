"""What /proc says of the processes that a pool has started."""

import os
from pathlib import Path

LISTENING = "0A"
LOOPBACK = {
    "0100007F",
    "00000000000000000000000001000000",
    "0000000000000000FFFF00000100007F",
}


def processes_with(value: str) -> set[int]:
    """Processes whose environment holds a value, so that also orphans are found; no zombies."""
    found = set()
    for folder in Path("/proc").glob("[0-9]*"):
        try:
            if value.encode() in (folder / "environ").read_bytes():
                found.add(int(folder.name))
        except OSError:
            continue
    return found


def command_line(process: int) -> list[str]:
    """The command and its arguments; empty where the process is no more."""
    try:
        return Path(f"/proc/{process}/cmdline").read_text().rstrip("\0").split("\0")
    except OSError:
        return []


def processor_seconds(process: int) -> float:
    """What a process has used of a processor."""
    fields = Path(f"/proc/{process}/stat").read_text().rpartition(")")[2].split()
    return (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")


def listening_beyond_loopback(process: int) -> set[str]:
    """Addresses (hexadecimal, as in /proc) on which other machines could reach the process."""
    folder = Path(f"/proc/{process}")
    sockets = set()
    for descriptor in (folder / "fd").iterdir():
        try:
            sockets.add(str(descriptor.readlink()))
        except OSError:
            continue
    found = set()
    for table in ("tcp", "tcp6"):
        for line in (folder / "net" / table).read_text().splitlines()[1:]:
            fields = line.split()
            address, state, inode = fields[1].partition(":")[0], fields[3], fields[9]
            if state == LISTENING and f"socket:[{inode}]" in sockets and address not in LOOPBACK:
                found.add(fields[1])
    return found
