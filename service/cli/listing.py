"""`d3pg ls` and `d3pg show`: sweeps and runs as they stand."""

from __future__ import annotations

from itertools import islice
from typing import Annotated

import typer

from service.api.schemas.page import Page
from service.api.schemas.run_answer import AttemptAnswer, ListedRunAnswer, RunAnswer
from service.api.schemas.sweep_answer import SweepAnswer
from service.cli.following import counts_text, eta_text
from service.cli.terminal import AsJson, Identifier, print_json, print_table, say
from service.client import Client
from service.model.entry import setting_text
from service.model.run import RunStatus
from service.model.run_name import is_run

LOG_LINES = 20


def ls(
    sweep_id: Annotated[
        str | None, typer.Argument(metavar="[SWEEP]", help="List its runs, not the sweeps.")
    ] = None,
    status: Annotated[RunStatus | None, typer.Option(help="Only runs that stand there.")] = None,
    algorithm: Annotated[str | None, typer.Option(help="Only its runs.")] = None,
    environment: Annotated[str | None, typer.Option(help="Only runs in this task.")] = None,
    limit: Annotated[int, typer.Option(min=1, help="At most so many.")] = 50,
    as_json: AsJson = False,
) -> None:
    """List sweeps, newest first, or the runs of one."""
    filters = {"status": status, "algorithm": algorithm, "environment": environment}
    given = {name: str(value) for name, value in filters.items() if value is not None}
    if sweep_id is None and given:
        raise typer.BadParameter("runs are filtered, sweeps are not: name a SWEEP")
    with Client() as client:
        if sweep_id is None:
            list_sweeps(list(islice(client.sweeps(), limit + 1)), limit, as_json)
        else:
            runs = client.runs(sweep_id, limit=min(1000, limit + 1), **given)
            list_runs(list(islice(runs, limit + 1)), limit, as_json)


def list_sweeps(sweeps: list[SweepAnswer], limit: int, as_json: bool) -> None:
    """Print sweeps, and whether there are more."""
    if as_json:
        print_json(Page[SweepAnswer](items=sweeps[:limit], next=None))
        return
    print_table(
        ("sweep", "status", "done", "ETA", "runs", "submitted (UTC)", "name"),
        [
            (s.id, s.status, f"{s.progress:.0%}", eta_text(s).removeprefix("ETA "),
             counts_text(s), f"{s.created_at:%Y-%m-%d %H:%M}", s.name)
            for s in sweeps[:limit]
        ],
    )  # fmt: skip
    say_if_more(len(sweeps), limit)


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


def show_sweep(sweep: SweepAnswer, url: str) -> None:
    """Print a sweep, a line a fact."""
    say(f"sweep      {sweep.id}")
    say(f"name       {sweep.name}")
    say(f"status     {sweep.status}, {sweep.progress:.0%} {eta_text(sweep)}".rstrip())
    say(f"runs       {sweep.runs.total}: {counts_text(sweep)}")
    say(f"learners   {', '.join(entry.label for entry in sweep.entries)}")
    say(f"submitted  {sweep.created_at:%Y-%m-%d %H:%M:%S} UTC, priority {sweep.priority}")
    say(f"page       {url}/sweeps/{sweep.id}")


def show_run(run: RunAnswer, attempts: list[AttemptAnswer]) -> None:
    """Print a run, a line a fact, then its attempts and what the last one printed."""
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
