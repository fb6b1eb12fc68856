"""`d3pg submit`: a sweep from a YAML file, from flags, or from both: flags replace its fields."""

from __future__ import annotations

import warnings
from collections.abc import Iterable
from pathlib import Path
from typing import Annotated

import typer

from service.api.schemas.sweep_answer import CellAnswer, CostAnswer, DryRunAnswer
from service.cli.algorithm_option import ALGORITHM_TEXT, algorithm_of, values_of
from service.cli.following import follow
from service.cli.identifiers import complete_algorithm, complete_environment
from service.cli.sweep_file import read_request
from service.cli.terminal import AsJson, console, print_json, print_table, say
from service.client import Client, SubmissionNotice
from service.model.request.entry import setting_text


def submit(
    file: Annotated[
        Path | None, typer.Argument(metavar="[FILE.yaml]", help="The sweep; - reads stdin.")
    ] = None,
    algorithm: Annotated[
        list[str] | None,
        typer.Option(
            "--algorithm",
            "-a",
            help=f"{ALGORITHM_TEXT}; may be repeated.",
            autocompletion=complete_algorithm,
        ),
    ] = None,
    environment: Annotated[
        list[str] | None,
        typer.Option(
            "--environment",
            "-e",
            help="A task; may be repeated.",
            autocompletion=complete_environment,
        ),
    ] = None,
    seeds: Annotated[
        str | None, typer.Option(help="How many seeds each curve gets, or which: 0,3,7.")
    ] = None,
    timesteps: Annotated[
        int | None, typer.Option(help="Timesteps of each run; the preset's if unset.")
    ] = None,
    scale: Annotated[
        str | None, typer.Option(help="Share of the timesteps; a list is a grid: 0.1,1.")
    ] = None,
    name: Annotated[str | None, typer.Option(help="Name of the sweep; any text.")] = None,
    notes: Annotated[str | None, typer.Option(help="Markdown, shown as text.")] = None,
    tag: Annotated[
        list[str] | None, typer.Option(help="Tag to find the sweep by; may be repeated.")
    ] = None,
    priority: Annotated[
        int | None, typer.Option(help="Sweeps of higher priority start first.")
    ] = None,
    max_workers: Annotated[
        int | None, typer.Option(help="Workers that may train its runs at once.")
    ] = None,
    webhook: Annotated[
        str | None, typer.Option(help="URL that gets a signed POST when the sweep has ended.")
    ] = None,
    key: Annotated[
        str | None,
        typer.Option(
            help="Any text; a second submission with the same key returns the first sweep."
        ),
    ] = None,
    dry_run: Annotated[
        bool, typer.Option("--dry-run", help="Only count the runs and estimate their cost.")
    ] = False,
    watch: Annotated[bool, typer.Option("--watch", help="Follow the sweep to its end.")] = False,
    as_json: AsJson = False,
) -> None:
    """Queue a sweep: a YAML file, flags, or a file with some fields replaced by flags."""
    flags = {
        "name": name,
        "algorithms": [algorithm_of(each) for each in algorithm or []] or None,
        "environments": environment or None,
        "seeds": None if seeds is None else values_of(seeds),
        "timesteps": timesteps,
        "scale": None if scale is None else values_of(scale),
        "notes": notes,
        "tags": tag or None,
        "priority": priority,
        "max_workers": max_workers,
        "webhook": webhook,
    }
    given = {field: value for field, value in flags.items() if value is not None}
    if file is None and not {"algorithms", "environments"} <= given.keys():
        raise typer.BadParameter("name a FILE.yaml, or at least --algorithm and --environment")
    request = {"seeds": 1, **given} if file is None else read_request(file) | given
    with Client() as client:
        if dry_run:
            show_estimate(client.estimate(request), as_json)
            return
        with warnings.catch_warnings(action="ignore", category=SubmissionNotice):
            sweep = client.submit(request, key)  # its notices are printed below
        if as_json:
            print_json(sweep)
        else:
            say(f"Sweep {sweep.id}: {counted_runs(sweep.runs.total)} queued.")
            say(f"{client.url}/sweeps/{sweep.id}")
            say_notices(sweep.notices)
        if watch:
            raise typer.Exit(follow(client, sweep.id, console, as_json=as_json))


def show_estimate(answer: DryRunAnswer, as_json: bool) -> None:
    """Print what would be queued, cell by cell, and its estimated cost."""
    if as_json:
        print_json(answer)
        return
    print_table(
        ("task", "learner", "w1", "w2", "timesteps", "seeds", "core time"),
        [(*cell_columns(cell), cell.seeds, cost_text(cell.cost)) for cell in answer.cells],
    )
    say(f"{counted_runs(answer.runs.total)}, {answer.timesteps:,} timesteps; nothing was queued.")
    estimate = answer.estimate
    if estimate.core_seconds is not None:
        say(f"About {duration(estimate.core_seconds)} of one core" + wall_text(answer) + ".")
    say(estimate.explanation)
    say(f"{answer.product}.")
    say_notices(answer.notices)


def say_notices(notices: Iterable[str]) -> None:
    """Print the notices of a submission."""
    for notice in notices:
        say(f"Note: {notice}")


def counted_runs(count: int) -> str:
    """`1 run`, `16 runs`."""
    return f"{count:,} run{'' if count == 1 else 's'}"


def cell_columns(cell: CellAnswer) -> tuple[object, ...]:
    """Task, learner, weights and timesteps."""
    weights = map(setting_text, cell.weights.pair)
    return cell.environment, cell.label, *weights, cell.timesteps


def cost_text(cost: CostAnswer) -> str:
    """The cost of a cell; a dash where it is not known."""
    return "-" if cost.core_seconds is None else duration(cost.core_seconds)


def wall_text(answer: DryRunAnswer) -> str:
    """How long it takes on the workers that are up, if any are."""
    wall, workers = answer.estimate.wall_seconds, answer.estimate.workers
    if wall is None:
        return ""
    return f", {duration(wall)} on the {workers} worker{'s' * (workers > 1)} here"


def duration(seconds: float) -> str:
    """Seconds in words: `3.2 s`, `4:05`, `1:02:05`."""
    if seconds < 60:
        return f"{seconds:.2g} s"
    minutes, rest = divmod(round(seconds), 60)
    hours, minutes = divmod(minutes, 60)
    return f"{hours}:{minutes:02}:{rest:02}" if hours else f"{minutes}:{rest:02}"
