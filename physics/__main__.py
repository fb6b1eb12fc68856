"""`python -m physics`: compile the kernels, or audit the derivatives."""

import argparse
import sys
import time

from physics.audit.audit import audit
from physics.audit.notes import failures, notes
from physics.audit.record import COUNT, RegimeAudit, as_table, write_record
from physics.catalogue import EXTRAS, as_task, names
from physics.environment import Environment
from physics.kernels.compile_notice import compile_notice


def main() -> int:
    """Run one command; return the exit status."""
    parser = argparse.ArgumentParser(prog="python -m physics", description=__doc__)
    commands = parser.add_subparsers(dest="command", required=True)
    compiling = commands.add_parser("compile", help="compile every kernel, or load it")
    auditing = commands.add_parser("audit", help="compare every derivative with differences")
    for command in (compiling, auditing):
        command.add_argument(
            "names",
            nargs="*",
            help="tasks, as names or as my_tasks.py:Arm (default: all but MuJoCo's)",
        )
    auditing.add_argument("--count", type=int, default=COUNT, help="smooth states of each regime")
    auditing.add_argument("--write", action="store_true", help="store it as the project's record")
    arguments = parser.parse_args()
    try:
        tasks = [as_task(name) for name in arguments.names or without_extras()]
    except ValueError as error:
        parser.error(str(error))
    compile_all(tasks)
    if arguments.command == "audit":
        return audit_all(tasks, arguments.count, arguments.write)
    return 0


def without_extras() -> list[str]:
    """All tasks but those that need an extra: an audit of these takes hours."""
    extras = {name for tasks in EXTRAS.values() for name in tasks}
    return [name for name in names() if name not in extras]


def compile_all(tasks: list[Environment]) -> None:
    """Compile task by task, and print the seconds of each."""
    for task in tasks:
        with compile_notice(task.label):
            seconds = task.compile()
        say(f"kernels of {task.label}: {seconds:.2f} s")


def audit_all(tasks: list[Environment], count: int, keep: bool) -> int:
    """Audit task by task; return 1 if one of them did not pass."""
    rows: list[RegimeAudit] = []
    remarks: list[str] = []
    for task in tasks:
        say(f"audit of {task.label} ...")
        start = time.perf_counter()
        try:
            with compile_notice(f"the audit of {task.label}"):
                found = audit(task, count)
                remarks += [*failures(found, count, task.tolerance), *notes(task, found)]
            rows += found
        except Exception as error:
            remarks.append(f"NOT PASSED: {task.label}: {type(error).__name__}: {error}")
        say(f"audit of {task.label}: {time.perf_counter() - start:.1f} s")
    say(as_table(rows))
    for remark in remarks:
        say(remark)
    if keep:
        write_record(rows)
    return 1 if any(remark.startswith("NOT PASSED") for remark in remarks) else 0


def say(line: str) -> None:
    """Print a line and flush it, so that progress is visible."""
    sys.stdout.write(line + "\n")
    sys.stdout.flush()


if __name__ == "__main__":
    sys.exit(main())
