"""The end of a log file, as a terminal would show it."""

import re
from pathlib import Path

TAIL_BYTES = 8192
ESCAPE_SEQUENCE = re.compile(
    r"\x1b(\[[0-9:;<=>?]*[ -/]*[@-~]|\][^\x07\x1b]*(\x07|\x1b\\)?|[@-Z\\-_])"
)
"""Colours, moves of the cursor and titles of windows (ECMA-48)."""
OVERWRITTEN = re.compile(r"[^\n]*\r(?!\n)")
"""What a progress bar wrote before it returned to the beginning of its line."""


def log_tail(path: Path) -> str:
    """Return the last lines of a file, at most 8 KiB, whole but for a longer one.

    Return nothing if there is no file.
    """
    try:
        with path.open("rb") as file:
            size = file.seek(0, 2)
            file.seek(max(0, size - TAIL_BYTES))
            text = file.read().decode(errors="replace")
    except OSError:
        return ""
    shown = OVERWRITTEN.sub("", ESCAPE_SEQUENCE.sub("", text).replace("\r\n", "\n"))
    if size <= TAIL_BYTES:
        return shown
    _, _, whole_lines = shown.partition("\n")
    return whole_lines or shown
