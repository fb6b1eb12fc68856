"""`d3pg ls` and `d3pg show`: list and show sweeps and runs."""

from __future__ import annotations

from itertools import islice
from typing import Annotated

import typer

from service.api.schemas.listed_sweep_answer import BestAnswer, ListedSweepAnswer
from service.api.schemas.page import Page
from service.api.schemas.run_answer import AttemptAnswer, ListedRunAnswer, RunAnswer
from service.api.schemas.sweep_answer import SweepAnswer, SweepHead
from service.cli.following import counts_text, eta_text, say_findings
from service.cli.identifiers import (
    Identifier,
    MaybeSweepId,
    complete_algorithm,
    complete_environment,
)
from service.cli.terminal import AsJson, console, print_json, print_table, say
from service.client import Client
from service.model.caller import ADMINISTRATOR
from service.model.request.entry import setting_text
from service.model.run_name import is_run

LOG_LINES = 20
MOST_NAMED = 3
WIDE = 140
"""Columns of a terminal that shows what sweeps compare."""


def ls(
    sweep_id: MaybeSweepId = None,
    status: Annotated[
        str | None, typer.Option(help="Only sweeps or runs with this status.")
    ] = None,
    algorithm: Annotated[
        str | None,
        typer.Option(
            "--algorithm",
            "-a",
            help="Only sweeps or runs of this algorithm.",
            autocompletion=complete_algorithm,
        ),
    ] = None,
    environment: Annotated[
        str | None,
        typer.Option(
            "--environment",
            "-e",
            help="Only sweeps or runs in this task.",
            autocompletion=complete_environment,
        ),
    ] = None,
    q: Annotated[
        str | None,
        typer.Option("--search", "-q", help="Only sweeps with this text in name, notes or tags."),
    ] = None,
    tag: Annotated[str | None, typer.Option(help="Only sweeps with this tag.")] = None,
    owner: Annotated[str | None, typer.Option(help="Only sweeps that this user submitted.")] = None,
    archived: Annotated[bool, typer.Option("--archived", help="Only archived sweeps.")] = False,
    limit: Annotated[int, typer.Option(min=1, help="Number of rows to list, at most.")] = 50,
    as_json: AsJson = False,
) -> None:
    """List sweeps, newest first, or the runs of one."""
    if sweep_id is not None and (q or tag or owner or archived):
        raise typer.BadParameter(
            "--search, --tag, --owner and --archived are for sweeps, not for runs"
        )
    with Client() as client:
        if sweep_id is None:
            sweeps = client.sweeps(
                q,
                tag=tag,
                algorithm=algorithm,
                environment=environment,
                status=status,
                archived=archived,
                owner=owner,
            )
            list_sweeps(list(islice(sweeps, limit + 1)), limit, as_json)
        else:
            runs = client.runs(
                sweep_id,
                status=status,
                algorithm=algorithm,
                environment=environment,
                limit=min(1000, limit + 1),
            )
            list_runs(list(islice(runs, limit + 1)), limit, as_json)


def list_sweeps(sweeps: list[ListedSweepAnswer], limit: int, as_json: bool) -> None:
    """Print sweeps, and whether there are more."""
    if as_json:
        print_json(Page[ListedSweepAnswer](items=sweeps[:limit], next=None))
        return
    headings = ("sweep", "status", "done", "ETA", "runs", "submitted (UTC)", "name", "learners",
                "tasks", "best", "tags", "owner")  # fmt: skip
    rows = [
        (s.id, s.status, f"{s.progress:.0%}", eta_text(s).removeprefix("ETA "), counts_text(s),
         f"{s.created_at:%Y-%m-%d %H:%M}", s.name, named(s.algorithms), named(s.environments),
         best_text(s.best), ", ".join(s.tags), owner_text(s))
        for s in sweeps[:limit]
    ]  # fmt: skip
    is_narrow = console.is_terminal and console.width < WIDE
    shown = headings.index("learners") if is_narrow else len(headings)
    print_table(headings[:shown], [row[:shown] for row in rows])
    say_if_more(len(sweeps), limit)


def owner_text(sweep: SweepHead) -> str:
    """The owner of a sweep; empty for the administrator, who owns all where there are no users."""
    return "" if sweep.owner == ADMINISTRATOR else sweep.owner


def named(names: list[str]) -> str:
    """`ddpg, sac`; `ddpg, sac, td3 and 4 more` of many."""
    shown = ", ".join(names[:MOST_NAMED])
    return f"{shown} and {len(names) - MOST_NAMED} more" if len(names) > MOST_NAMED else shown


def best_text(best: BestAnswer | None) -> str:
    """`0.842 (hybrid-ddpg in Pendulum)`; empty where no curve is complete."""
    return "" if best is None else f"{best.score:.3f} ({best.label} in {best.environment})"


def list_runs(runs: list[ListedRunAnswer], limit: int, as_json: bool) -> None:
    """Print runs, and whether there are more."""
    if as_json:
        print_json(Page[ListedRunAnswer](items=runs[:limit], next=None))
        return
    print_table(
        ("run", "status", "learner", "w1", "w2", "task", "seed", "timestep", "reason"),
        [
            (r.id, r.status, r.label, *map(setting_text, r.weights.pair),
             r.environment, r.seed, f"{r.timestep}/{r.timesteps}", r.remark)
            for r in runs[:limit]
        ],
    )  # fmt: skip
    say_if_more(len(runs), limit)


def say_if_more(found: int, limit: int) -> None:
    """Say on standard error that the list goes on."""
    if found > limit:
        typer.echo(f"There are more than {limit}: see them with --limit.", err=True)


def show(identifier: Identifier, as_json: AsJson = False) -> None:
    """Show a sweep, or a run with its attempts."""
    with Client() as client:
        if is_run(identifier):
            run = client.run(identifier)
            if as_json:
                print_json(run)
            else:
                show_run(run, client.attempts(identifier))
            return
        sweep = client.sweep(identifier)
        if as_json:
            print_json(sweep)
        else:
            show_sweep(sweep, client.url)
            say_findings(client, sweep)


def show_sweep(sweep: SweepAnswer, url: str) -> None:
    """Print a sweep, one fact in a line."""
    say(f"sweep      {sweep.id}")
    say(f"name       {sweep.name}")
    say(f"status     {sweep.status}, {sweep.progress:.0%} {eta_text(sweep)}".rstrip())
    say(f"runs       {sweep.runs.total}: {counts_text(sweep)}")
    say(f"learners   {', '.join(entry.label for entry in sweep.entries)}")
    say(f"submitted  {sweep.created_at:%Y-%m-%d %H:%M:%S} UTC, priority {sweep.priority}")
    if owner := owner_text(sweep):
        say(f"owner      {owner}")
    if sweep.tags:
        say(f"tags       {', '.join(sweep.tags)}")
    say(f"page       {url}/sweeps/{sweep.id}")
    if sweep.webhook is not None:
        say(f"webhook    {sweep.webhook.url} {sweep.webhook.problem}".rstrip())
    for line in sweep.notes.splitlines():
        say(f"  {line}")


def show_run(run: RunAnswer, attempts: list[AttemptAnswer]) -> None:
    """Print a run, one fact in a line, then its attempts and the log of the last one."""
    settings = ", ".join(f"{name} = {setting_text(value)}" for name, value in run.config.items())
    w1, w2 = map(setting_text, run.weights.pair)
    say(f"run        {run.id}")
    say(f"status     {run.status}{': ' * bool(run.remark)}{run.remark}")
    say(f"learner    {run.label}")
    say(f"algorithm  {run.algorithm}, w1 = {w1}, w2 = {w2}")
    say(f"settings   {settings or 'the defaults'}")
    say(f"task       {run.environment} (version {run.environment_version}), seed {run.seed}")
    say(f"timestep   {run.timestep:,} of {run.timesteps:,}")
    for attempt in attempts:
        taken_up = (
            f", from timestep {attempt.resumed_timestep:,}" if attempt.resumed_timestep else ""
        )
        say(f"attempt {attempt.attempt}  {attempt.outcome} on {attempt.worker}{taken_up}")
        for sentence in filter(None, (attempt.note, attempt.error)):
            say(sentence)
    if attempts and attempts[-1].log_tail:
        say("its last lines:")
        for line in attempts[-1].log_tail.splitlines()[-LOG_LINES:]:
            say(f"  {line}")
