"""`d3pg verify`: a run trained anew from its spec, and held against what is stored."""

from __future__ import annotations

from itertools import islice
from pathlib import Path
from typing import Annotated, NamedTuple

import typer
from rich.progress import track

import algorithms
from algorithms.early_end import DivergedError, Divergence, EarlyEnd, FailedRunsError
from algorithms.threads import one_thread
from physics.task_file import TaskFile
from service.api.schemas.run_answer import RunAnswer
from service.cli.terminal import console, say
from service.client import Client, ServiceError
from service.model.run import RunStatus
from workers.training.fingerprint import fingerprint

Points = list[tuple[int, float]]


class Trained(NamedTuple):
    """What came of a run: its measurements, and how it ended before its timesteps if it did."""

    points: Points
    end: EarlyEnd | None


def verify(
    run: Annotated[str, typer.Argument(metavar="RUN", help="The id of a run.")],
    task: Annotated[
        Path | None,
        typer.Option(metavar="FILE", help="The task file, where the run's task is of one."),
    ] = None,
) -> None:
    """Train a run again, here and alone; its curve must come out the same, bit for bit.

    A run that diverged must diverge again, at the same timestep.
    """
    with Client() as client:
        told = client.run(run)
        rows = client.measurement_rows(run)
        stored = [(int(row["timestep"]), float(row["return_mean"])) for row in rows]
    if not stored and told.status is not RunStatus.DIVERGED:
        raise ServiceError(f"{run} is {told.status} and has measured nothing to compare with.")
    for fact in differing_facts(told):
        say(f"The run was trained with another {fact}: its bits may differ for that reason.")
    again = trained(told, len(stored), environment_of(told, task))
    mismatch = first_mismatch(stored, again.points)
    differing_end = another_end(told, again.end)
    if mismatch is None:
        say(f"{run}: all {len(stored)} measurements are the same, bit for bit.")
    else:
        say(f"{run}: measurement {mismatch + 1} of {len(stored)} and what follows differ.")
    if differing_end:
        say(f"{run}: {differing_end}.")
    elif again.end is not None:
        say(f"{run}: it ended as it had: {again.end.reason}.")
    if mismatch is not None or differing_end:
        raise SystemExit(1)


def environment_of(run: RunAnswer, task: Path | None) -> str:
    """The run's environment as `physics.make` takes it here.

    Raises ServiceError where a task file is needed, or has another text than the run's.
    """
    digest = (run.fingerprint or {}).get("task")
    if digest is None:
        return run.environment
    if task is None:
        raise ServiceError(f"{run.id} is of a task file: give it with --task my_tasks.py")
    try:
        found = TaskFile.read(task).digest
    except ValueError as error:
        raise ServiceError(f"{run.id} cannot be trained here: {error}") from error
    if found != digest:
        raise ServiceError(
            f"{task} has the hash {found}, and the file that {run.id} was trained with {digest}"
        )
    return f"{task}:{run.environment}"


def trained(run: RunAnswer, count: int, environment: str) -> Trained:
    """The first `count` measurements of a run of the same spec; of one that diverged, its end too.

    Raises ServiceError for a run that cannot be trained here.
    """
    wanted = count + (run.status is RunStatus.DIVERGED)  # one more: there it is to end
    points: Points = []
    try:
        measurements = algorithms.train(
            run.algorithm,
            environment,
            seeds=[run.seed],
            weights=run.weights.pair,
            timesteps=run.timesteps,
            config=dict(run.config),
        )
        shown = track(islice(measurements, wanted), "training", total=count, console=console)
        for each in shown:
            points.append((each.timestep, each.return_mean))
    except DivergedError as error:
        return Trained(points, error.divergences[0])
    except FailedRunsError as error:
        return Trained(points, error.failures[0])
    except ValueError as error:
        raise ServiceError(f"{run.id} cannot be trained here: {error}") from error
    return Trained(points[:count], None)


def another_end(run: RunAnswer, end: EarlyEnd | None) -> str:
    """How a run ended otherwise than it had, in words; empty where it did not."""
    has_diverged = run.status is RunStatus.DIVERGED
    if end is None:
        return f"it trains on where it had diverged, at timestep {run.timestep:,}" * has_diverged
    if has_diverged and isinstance(end, Divergence) and end.timestep == run.timestep:
        return ""
    stood = f"it is {run.status}, at timestep {run.timestep:,}"
    return f"trained again it {end.reason}; as stored {stood}"


def first_mismatch(stored: Points, again: Points) -> int | None:
    """The first measurement in which two curves differ; NaN equals NaN."""
    pairs = enumerate(zip(stored, again, strict=False))
    differing = next((i for i, (one, other) in pairs if repr(one) != repr(other)), None)
    if differing is None and len(stored) != len(again):
        return min(len(stored), len(again))
    return differing


def differing_facts(run: RunAnswer) -> list[str]:
    """The names of what this process does differently from the run's worker.

    Learners use one thread wherever they run; what else the process would use does not matter.
    """
    if run.fingerprint is None:
        return []
    with one_thread():
        here = {**fingerprint(), "threads": "1"}
    return [name for name, value in here.items() if run.fingerprint.get(name) != value]
