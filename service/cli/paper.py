"""`d3pg paper`: the paper's evaluation, from its sweeps to its figures, and its tuning.

With --json, standard output has one JSON value that says what was written. All other messages go to
standard error.
"""

from __future__ import annotations

import hashlib
import json
import warnings
from collections.abc import Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Annotated, Any

import typer
from rich.console import Console

from algorithms import catalogue
from service.api.schemas.sweep_answer import SweepAnswer
from service.cli.following import follow
from service.cli.host.own_service import data_dir, own_service
from service.cli.terminal import AsJson, console, errors, say
from service.client import Client, ServiceError, SubmissionNotice
from service.paper import results, speeds
from service.paper.evaluation import SEEDS, evaluation
from service.paper.former import Former, former, whole_sweeps
from service.paper.search import preset_file, tuning, tuning_file
from service.paper.search.tuning import Outcome
from service.paper.summary import summarized
from service.paper.today import SHOWN

app = typer.Typer(name="paper")

Output = Annotated[Path, typer.Option("--output", "-o", help="Folder of the results.")]
AnyCode = Annotated[
    bool,
    typer.Option("--any-code", help="Also keep complete sweeps that another code trained."),
]


@app.callback(invoke_without_command=True)
def run(
    context: typer.Context,
    seeds: Annotated[int, typer.Option(min=1, help="Runs of each curve, at most.")] = SEEDS,
    scale: Annotated[
        float, typer.Option(min=0.001, max=1, help="Share of the timesteps, for a quick look.")
    ] = 1.0,
    output: Output = Path("results"),
    any_code: AnyCode = False,
    as_json: AsJson = False,
) -> None:
    """Run the whole evaluation, or go on with it, and write its results.

    Uses the service that answers at D3PG_URL, else starts one in D3PG_DATA_DIR. After an
    interruption, call it again with the same seeds and scale: it goes on from the last checkpoints.
    A new service does not train sweeps that are complete in the folder: all runs ended, and this
    code trained them with the present settings. Keeping those of another code is right only if its
    changes leave their results as they are; provenance.json says which code trained what.
    """
    if context.invoked_subcommand is not None:
        return
    told = console_of(as_json)
    with any_service(told) as client:
        requests, kept = wanted(client, evaluation(seeds, scale), output, told, any_code=any_code)
        sweeps = [submitted(client, request) for request in requests]
        for sweep in sweeps:
            say(f"{sweep.name}:  {client.url}/sweeps/{sweep.id}?figures=1", told)
        codes = [follow(client, sweep.id, told) for sweep in sweeps]
        write(client, sweeps, output, kept, as_json)
    raise SystemExit(max(codes, default=0))


@app.command(name="write")
def write_results(
    seeds: Annotated[
        int, typer.Option(min=1, help="Runs of each curve in the evaluation, at most.")
    ] = SEEDS,
    scale: Annotated[
        float, typer.Option(min=0.001, max=1, help="Share of the timesteps in the evaluation.")
    ] = 1.0,
    output: Output = Path("results"),
    any_code: AnyCode = False,
    as_json: AsJson = False,
) -> None:
    """Write what the evaluation has measured so far, without waiting for its end."""
    told = console_of(as_json)
    with any_service(told) as client:
        requests, kept = wanted(client, evaluation(seeds, scale), output, told, any_code=any_code)
        write(client, [submitted(client, request) for request in requests], output, kept, as_json)


@app.command()
def derive(output: Output = Path("results"), as_json: AsJson = False) -> None:
    """Write gains.csv and figure 7 again, from the folder's measurements; needs no service."""
    results.derive(output)
    written = list(map(str, (output / "gains.csv", *sorted(output.glob("figure-7.*")))))
    say(json.dumps({"files": written}) if as_json else f"Wrote {', '.join(written)}")


@app.command(name="time")
def measure_time(output: Output = Path("results"), as_json: AsJson = False) -> None:
    """Measure ddpg's time on this processor, and add it to the folder's speeds.csv.

    Do this once on each kind of machine that trains a part of the evaluation, with nothing else
    running: figure 7 compares processor time in units of ddpg's on the same processor.
    """
    told, found = console_of(as_json), []
    for speed in speeds.measure(SHOWN):
        found.append(speed)
        say(f"{speed.environment}: {speed.timesteps:,} timesteps take {speed.seconds:.3g} s", told)
        speeds.write(output, found)
    file = str(output / speeds.FILE)
    say(json.dumps({"file": file}) if as_json else f"Wrote {file}")


@app.command()
def summary(output: Output = Path("results"), as_json: AsJson = False) -> None:
    """Print the answers of the folder's measurements to the evaluation's questions, in Markdown."""
    text = summarized(output)
    typer.echo(json.dumps({"markdown": text}) if as_json else text)


@app.command()
def tune(output: Output = Path("results"), as_json: AsJson = False) -> None:
    """Run the searches that choose the presets, or go on with them, and write tuning.csv.

    Searches that are complete in the folder's tuning.csv are not made again.
    """
    told = console_of(as_json)
    rows = tuning_file.read(output)
    with any_service(told) as client:
        rows = search(
            client,
            [
                tuning.settings_search(task, name, rows)
                for name, space in tuning.SPACES.items()
                for task in space.tasks()
            ],
            rows,
            output,
            told,
        )
        rows = search(
            client,
            [
                tuning.weights_search(
                    task, hybrid, tuning.best(rows, task, catalogue.baseline(hybrid)).config, rows
                )
                for hybrid in tuning.PAIRS
                for task in tuning.TIMESTEPS
            ],
            rows,
            output,
            told,
        )
    file = str(output / "tuning.csv")
    found = {"file": file, "outcomes": len(rows)}
    say(json.dumps(found) if as_json else f"{file} has {len(rows)} outcomes")


@app.command()
def presets(output: Output = Path("results"), as_json: AsJson = False) -> None:
    """Write algorithms/presets.toml from the folder's tuning.csv, which must be complete."""
    try:
        text = preset_file.as_toml(preset_file.presets_of(tuning_file.read(output)))
    except ValueError as reason:
        raise typer.BadParameter(str(reason)) from None
    preset_file.FILE.write_text(text, encoding="utf-8")
    file = str(preset_file.FILE)
    say(json.dumps({"file": file}) if as_json else f"Wrote {file}")


def search(
    client: Client,
    requests: Iterable[Mapping[str, Any] | None],
    known: Sequence[Outcome],
    output: Path,
    told: Console,
) -> list[Outcome]:
    """Run searches in order; write the known outcomes after each search, and return them."""
    sweeps = [
        submitted(client, {**request, "priority": -place})
        for place, request in enumerate(requests)
        if request
    ]
    for sweep in sweeps:
        follow(client, sweep.id, told)
        found = tuning.outcomes(client.curves(sweep.id, normalized=True, max_points=1000))
        known = list({row.cell: row for row in (*known, *found)}.values())
        tuning_file.write(output, known)
    return list(known)


def console_of(as_json: bool) -> Console:
    """The console for messages on progress."""
    return errors if as_json else console


@contextmanager
def any_service(told: Console) -> Iterator[Client]:
    """Yield a client of the service that answers, else of one that the command starts."""
    try:
        client = Client()
        client.readiness()
    except ServiceError:
        say("Starting a service and a local Ray ...", told)
        try:
            with own_service() as (client, _):
                yield client
        except KeyboardInterrupt:
            kept = f"Stopped. Everything measured is kept in {data_dir()}/; call again to go on."
            say(kept, told)
            raise
    else:
        with client:
            yield client


def submitted(client: Client, request: Mapping[str, Any]) -> SweepAnswer:
    """Submit a request, once however often this is called, and return its sweep."""
    text = json.dumps(request, sort_keys=True)
    with warnings.catch_warnings(action="ignore", category=SubmissionNotice):  # it means all of it
        return client.submit(request, f"paper {hashlib.sha256(text.encode()).hexdigest()[:32]}")


def wanted(
    client: Client,
    requests: Sequence[Mapping[str, Any]],
    output: Path,
    told: Console,
    *,
    any_code: bool,
) -> tuple[list[Mapping[str, Any]], Former]:
    """Return the requests for the service, and what the folder has of the other sweeps.

    The other sweeps are complete in the folder, and a new service does not have them. Prints which.
    """
    held = [client.sweep(sweep.id).request for sweep in client.sweeps(archived=None)]
    new = [request for request in requests if request not in held]
    whole = whole_sweeps(output, new, any_code=any_code)
    for request in whole:
        say(f"{request['name']}:  whole in {output}/, not trained again", told)
    return [request for request in requests if request not in whole], former(output, whole)


def write(
    client: Client, sweeps: Iterable[SweepAnswer], output: Path, kept: Former, as_json: bool
) -> None:
    """Write the present results of the sweeps, and say what is missing."""
    now = [client.sweep(sweep.id) for sweep in sweeps]
    lacking = list(results.write(client, now, output, kept))
    counts = [sweep.runs.model_dump() for sweep in now]
    counts += [evidence["runs"] for evidence in kept.evidence.values()]
    ended, total = (sum(each[name] for each in counts) for name in ("succeeded", "total"))
    if as_json:
        sweep_ids = [sweep.id for sweep in now]
        document = {"output": str(output), "sweeps": sweep_ids, "succeeded": ended, "total": total}
        say(json.dumps({**document, "lacking": lacking}))
        return
    for sentence in (*lacking, f"Wrote {output}/: {ended} of {total} runs reached their end."):
        say(sentence)
