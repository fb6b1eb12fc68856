"""`d3pg search`: which setting of a learner is best in each task, within a budget of timesteps."""

from __future__ import annotations

import shlex
import warnings
from collections.abc import Mapping
from typing import Annotated, Any

import typer

from service.api.schemas.search.search_answer import SearchAnswer
from service.cli.algorithm_option import ALGORITHM_TEXT, algorithm_of
from service.cli.following import follow
from service.cli.identifiers import complete_environment
from service.cli.submitting import say_notices, show_estimate
from service.cli.terminal import AsJson, console, print_json, say
from service.client import Client, SubmissionNotice
from service.model.inquiry.search import FEWEST_SEEDS
from service.model.request.entry import setting_text


def search(
    learner: Annotated[
        list[str], typer.Argument(metavar="LEARNER...", help=f"{ALGORITHM_TEXT}; lists are grids.")
    ],
    environment: Annotated[
        list[str],
        typer.Option(
            "--environment",
            "-e",
            help="A task; may be repeated.",
            autocompletion=complete_environment,
        ),
    ],
    budget: Annotated[int, typer.Option(help="Timesteps of all runs together, at most.")],
    grid: Annotated[
        list[str] | None,
        typer.Option(help="Setting of every learner: NAME=VALUE,VALUE,...; may be repeated."),
    ] = None,
    reduction: Annotated[
        int, typer.Option(help="One in this many entries goes on to the next rung.")
    ] = 3,
    score: Annotated[str, typer.Option(help="area or final.")] = "area",
    seeds: Annotated[int, typer.Option(help="Seeds of each entry, at least.")] = FEWEST_SEEDS,
    timesteps: Annotated[
        int | None, typer.Option(help="Timesteps of the longest runs; the preset's if unset.")
    ] = None,
    name: Annotated[str | None, typer.Option(help="Name of the sweep; any text.")] = None,
    dry_run: Annotated[
        bool, typer.Option("--dry-run", help="Only show what would be trained, and its cost.")
    ] = False,
    as_json: AsJson = False,
) -> None:
    """Find the best entry of a grid in each task by successive halving, and wait for it.

    Exits with 0 if every task has a winner.
    """
    request = {
        "name": name or f"search: {', '.join([*learner, *(grid or ())])}",
        "algorithms": [algorithm_of(":".join([each, *(grid or ())])) for each in learner],
        "environments": environment,
        "seeds": seeds,
        **({} if timesteps is None else {"timesteps": timesteps}),
        "search": {"budget": budget, "reduction": reduction, "score": score},
    }
    with Client() as client:
        if dry_run:
            show_estimate(client.estimate(request), as_json)
            return
        found = found_by(client, request, as_json)
    raise typer.Exit(0 if all(task.winner for task in found.tasks) else 1)


def found_by(client: Client, request: Mapping[str, Any], as_json: bool) -> SearchAnswer:
    """Submit a search, wait for its end and print what it found."""
    with warnings.catch_warnings(action="ignore", category=SubmissionNotice):
        sweep = client.submit(request)
    if as_json:
        client.wait(sweep.id)
    else:
        say(f"Sweep {sweep.id}: {client.url}/sweeps/{sweep.id}")
        say_notices(sweep.notices)
        follow(client, sweep.id, console)  # it ends with what was found
    found = client.search(sweep.id)
    if as_json:
        print_json(found)
    else:
        for command in _asking(found, request.get("timesteps")):
            say(f"Ask on other seeds: {command}")
    return found


def _asking(found: SearchAnswer, timesteps: int | None) -> list[str]:
    """Return the commands that compare winners with their learner's presets."""
    length = [] if timesteps is None else ["--timesteps", str(timesteps)]
    return [
        shlex.join(
            ["d3pg", "ask", f"{_text(won)} vs {won['name']}", "-e", task.environment, *length]
        )
        for task in found.tasks
        if (won := task.algorithm) is not None and len(won) > 1
    ]


def _text(algorithm: Mapping[str, Any]) -> str:
    """Return an algorithm in one word, as `d3pg ask` takes it."""
    stated = {**algorithm.get("weights", {}), **algorithm.get("config", {})}
    settings = [
        f"{name}={value if isinstance(value, str) else setting_text(value)}"
        for name, value in stated.items()
    ]
    return ":".join([algorithm["name"], *settings])
