"""`d3pg add` and `extend`: more seeds, more entries, more timesteps for a sweep."""

from __future__ import annotations

from typing import Annotated, Any

import typer

from service.api.schemas.sweep_answer import SweepAnswer
from service.cli.algorithm_option import ALGORITHM_TEXT, algorithm_of
from service.cli.following import counts_text
from service.cli.identifiers import SweepId
from service.cli.submitting import show_estimate
from service.cli.terminal import AsJson, print_json, say
from service.client import Client

DryRun = Annotated[
    bool, typer.Option("--dry-run", help="Only count the runs and estimate their cost.")
]


def add(
    sweep_id: SweepId,
    seeds: Annotated[str | None, typer.Option(help="Seeds to add: 16,17 or 16-31.")] = None,
    algorithm: Annotated[
        list[str] | None,
        typer.Option("--algorithm", "-a", help=f"{ALGORITHM_TEXT}; may be repeated."),
    ] = None,
    dry_run: DryRun = False,
    as_json: AsJson = False,
) -> None:
    """Add seeds to every curve of a sweep, or entries to every task of it."""
    if (seeds is None) == (not algorithm):
        raise typer.BadParameter("give either --seeds or --algorithm")
    with Client() as client:
        if seeds is not None:
            added: dict[str, Any] = {"seeds": seeds_of(seeds)}
        else:
            added = {"algorithms": [algorithm_of(each) for each in algorithm or ()]}
        if dry_run:
            show_estimate(client.estimate_growth(sweep_id, **added), as_json)
        elif seeds is not None:
            say_grown(client.add_seeds(sweep_id, **added), as_json)
        else:
            say_grown(client.add_entries(sweep_id, **added), as_json)


def extend(
    sweep_id: SweepId,
    timesteps: Annotated[int, typer.Option(help="Timesteps of each run, counted from its start.")],
    dry_run: DryRun = False,
    as_json: AsJson = False,
) -> None:
    """Give the runs of a sweep more timesteps: they go on from where they ended, bit for bit."""
    with Client() as client:
        if dry_run:
            show_estimate(client.estimate_growth(sweep_id, timesteps=timesteps), as_json)
            return
        say_grown(client.extend(sweep_id, timesteps), as_json)


def say_grown(sweep: SweepAnswer, as_json: bool) -> None:
    """Print the status of a sweep and its runs by status."""
    if as_json:
        print_json(sweep)
    else:
        say(f"{sweep.id}: {sweep.status} ({counts_text(sweep)})")


def seeds_of(text: str) -> list[int]:
    """Read `16,17` and `16-31`. Raises typer.BadParameter."""
    try:
        ranges = [[int(end) for end in part.split("-")] for part in text.split(",")]
        return [seed for first, *last in ranges for seed in range(first, (*last, first)[0] + 1)]
    except ValueError as error:
        raise typer.BadParameter(
            f"{text!r} is not a list of seeds: write 16,17 or 16-31", param_hint="--seeds"
        ) from error
