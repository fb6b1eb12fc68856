"""`d3pg logs`: what the worker of a run prints."""

from __future__ import annotations

from typing import Annotated

import typer

from service.api.schemas.run_answer import AttemptAnswer
from service.cli.identifiers import RunId
from service.cli.terminal import AsJson, errors, print_json, say
from service.client import Client


def logs(
    run_id: RunId,
    follow: Annotated[
        bool, typer.Option("--follow", "-f", help="Print new lines until the run has ended.")
    ] = False,
    as_json: AsJson = False,
) -> None:
    """Print the last lines that the worker of a run printed, at most 8 KiB of them.

    The runs of a cohort, up to 16 seeds, share one worker and its log. With --json: print the
    attempt that the lines belong to; with --follow, print it each time that there are new lines.
    """
    with Client() as client:
        found = client.follow_log(run_id) if follow else iter(client.attempts(run_id)[-1:])
        before: AttemptAnswer | None = None
        for attempt in found:
            if as_json:
                print_json(attempt, indent=None if follow else 2)
            else:
                say_new(before, attempt)
            before = attempt
    if before is None:
        say(f"No worker has claimed {run_id} yet.", errors)


def say_new(before: AttemptAnswer | None, attempt: AttemptAnswer) -> None:
    """Print the lines that were not printed before; a heading where another attempt begins."""
    goes_on = before is not None and before.attempt == attempt.attempt
    if not goes_on:
        say(f"attempt {attempt.attempt} on {attempt.worker}", errors)
    if text := added(before.log_tail if before and goes_on else "", attempt.log_tail):
        say(text.rstrip("\n"))


def added(before: str, after: str) -> str:
    """Return the text at the end of a log that was not there before.

    Both texts may have lost lines at their beginning, so the last lines of the old one are matched
    with the first lines of the new one.
    """
    if after.startswith(before):
        return after.removeprefix(before)
    whole_lines = before[: before.rfind("\n") + 1]  # the last one may have grown meanwhile
    old, new = whole_lines.splitlines(keepends=True), after.splitlines(keepends=True)
    common = next((n for n in range(min(len(old), len(new)), 0, -1) if old[-n:] == new[:n]), 0)
    return "".join(new[common:])
