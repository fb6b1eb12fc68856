"""Measures all figures to hold and prints a table of them: goal, measured, held.

    python -m benchmarks.held [WORD ...]    # only the commands that have one of these words

It is meant for people on a quiet machine: it takes more than an hour, and its numbers depend on the
machine's other work. So its exit code is 0 whatever is held, and no check runs it. The output of
commands goes to standard error as it appears.
"""

import argparse
import os
import subprocess
import sys

from benchmarks.held.figure import Measured, table
from benchmarks.held.figures import FIGURES


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("words", nargs="*", help="of the commands to run; all if left out")
    words = parser.parse_args().words
    asked = [
        figure
        for figure in FIGURES
        if not words or any(word in " ".join(figure.command) for word in words)
    ]
    printed = {command: run(command) for command in dict.fromkeys(f.command for f in asked)}
    print(table([Measured.of(figure, *printed[figure.command]) for figure in asked]))


def run(command: tuple[str, ...]) -> tuple[str, int]:
    """Run `python -m` with these words; return what it printed and its exit code."""
    load = os.getloadavg()[0]
    print(f"== {' '.join(command)} (load {load:.1f})", file=sys.stderr, flush=True)
    with subprocess.Popen(  # noqa: S603 - our own commands
        [sys.executable, "-m", *command], stdout=subprocess.PIPE, text=True
    ) as process:
        assert process.stdout is not None
        lines = []
        for line in process.stdout:
            print(line, end="", file=sys.stderr, flush=True)
            lines.append(line)
    return "".join(lines), process.returncode


if __name__ == "__main__":
    main()
