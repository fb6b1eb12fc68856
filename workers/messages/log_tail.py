"""The end of a log file."""

from pathlib import Path

TAIL_BYTES = 8192


def log_tail(path: Path) -> str:
    """Return the last whole lines of a file, at most 8 KiB; nothing where there is no file."""
    try:
        with path.open("rb") as file:
            size = file.seek(0, 2)
            file.seek(max(0, size - TAIL_BYTES))
            text = file.read().decode(errors="replace")
    except OSError:
        return ""
    return text if size <= TAIL_BYTES else text.partition("\n")[2]
