"""`d3pg verify`: train a run again from its spec, and compare it with what is stored."""

from __future__ import annotations

from itertools import islice
from pathlib import Path
from typing import Annotated, NamedTuple

import typer
from pydantic import BaseModel
from rich.progress import track

import algorithms
from algorithms.early_end import DivergedError, Divergence, EarlyEnd, FailedRunsError
from algorithms.threads import one_thread
from physics.task_file import TaskFile
from service.api.schemas.run_answer import RunAnswer
from service.cli.identifiers import RunId
from service.cli.terminal import AsJson, errors, print_json, say
from service.client import Client, ServiceError
from service.model.run import RunStatus
from workers.training.fingerprint import fingerprint

Points = list[tuple[int, float]]


class Trained(NamedTuple):
    """The result of a run: its measurements, and how it ended if that was before its timesteps."""

    points: Points
    end: EarlyEnd | None


class Verdict(BaseModel):
    """How a run that was trained again compares with what is stored.

    Attributes:
        run: its id.
        is_same: whether its curve and its end are, bit for bit.
        measurements: how many are stored.
        first_mismatch: the first that differs, counted from 0; None where none does.
        end: how its end differs; empty if it ended alike.
        differing_facts: what this process does differently from the run's worker.
    """

    run: str
    is_same: bool
    measurements: int
    first_mismatch: int | None
    end: str
    differing_facts: list[str]


def verify(
    run: RunId,
    task: Annotated[
        Path | None,
        typer.Option(metavar="FILE", help="The task file, if the run's task is from one."),
    ] = None,
    as_json: AsJson = False,
) -> None:
    """Train a run again, alone and on this machine; its curve must be the same, bit for bit.

    A run that diverged must diverge again, at the same timestep.
    """
    with Client() as client:
        told = client.run(run)
        rows = client.measurement_rows(run)
        stored = [(int(row["timestep"]), float(row["return_mean"])) for row in rows]
    if not stored and told.status is not RunStatus.DIVERGED:
        raise ServiceError(f"{run} is {told.status} and has measured nothing to compare with.")
    facts = differing_facts(told)
    for fact in facts if not as_json else ():
        say(f"The run was trained with another {fact}: its bits may differ for that reason.")
    again = trained(told, len(stored), environment_of(told, task))
    mismatch = first_mismatch(stored, again.points)
    differing_end = another_end(told, again.end)
    verdict = Verdict(
        run=run,
        is_same=mismatch is None and not differing_end,
        measurements=len(stored),
        first_mismatch=mismatch,
        end=differing_end,
        differing_facts=facts,
    )
    if as_json:
        print_json(verdict)
    else:
        _say(verdict, again.end)
    if not verdict.is_same:
        raise SystemExit(1)


def environment_of(run: RunAnswer, task: Path | None) -> str:
    """The run's environment as `physics.make` takes it here.

    Raises ServiceError where a task file is needed, or has another text than the run's.
    """
    digest = (run.fingerprint or {}).get("task")
    if digest is None:
        return run.environment
    if task is None:
        raise ServiceError(f"{run.id} needs its task file: name it with --task my_tasks.py")
    try:
        found = TaskFile.read(task).digest
    except ValueError as error:
        raise ServiceError(f"{run.id} cannot be trained here: {error}") from error
    if found != digest:
        raise ServiceError(
            f"{task} has the hash {found}, but {run.id} was trained with "
            f"the file of the hash {digest}: name that file"
        )
    return f"{task}:{run.environment}"


def _say(verdict: Verdict, end: EarlyEnd | None) -> None:
    run, stored = verdict.run, verdict.measurements
    if verdict.first_mismatch is None:
        say(f"{run}: all {stored} measurements are the same, bit for bit.")
    else:
        say(f"{run}: measurement {verdict.first_mismatch + 1} of {stored} and what follows differ.")
    if verdict.end:
        say(f"{run}: {verdict.end}.")
    elif end is not None:
        say(f"{run}: it ended as before: {end.reason}.")


def trained(run: RunAnswer, count: int, environment: str) -> Trained:
    """Train a run of the same spec to `count` measurements; one that diverged, to its end.

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
        shown = track(islice(measurements, wanted), "training", total=count, console=errors)
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
    """How the end of a run differs from the stored one, in words; empty if it does not."""
    has_diverged = run.status is RunStatus.DIVERGED
    if end is None:
        return f"it trains beyond its divergence, at timestep {run.timestep:,}" * has_diverged
    if has_diverged and isinstance(end, Divergence) and end.timestep == run.timestep:
        return ""
    stood = f"it is {run.status}, at timestep {run.timestep:,}"
    return f"trained again, it {end.reason}; as stored, {stood}"


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
