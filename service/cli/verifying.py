"""`d3pg verify`: a run trained anew from its spec, and held against what is stored."""

from __future__ import annotations

from typing import Annotated

import typer
from rich.progress import track

import algorithms
from algorithms.threads import one_thread
from service.api.schemas.run_answer import RunAnswer
from service.cli.terminal import console, say
from service.client import Client
from workers.training.fingerprint import fingerprint

Curve = list[tuple[int, float]]


def verify(run: Annotated[str, typer.Argument(metavar="RUN", help="The id of a run.")]) -> None:
    """Train a run again, here and alone; its curve must come out the same, bit for bit."""
    with Client() as client:
        told = client.run(run)
        rows = client.measurement_rows(run)
        stored = [(int(row["timestep"]), float(row["return_mean"])) for row in rows]
    differing = differing_facts(told)
    for fact in differing:
        say(f"The run was trained with another {fact}: its bits may differ for that reason.")
    mismatch = first_mismatch(stored, trained(told, len(stored)))
    if mismatch is None:
        say(f"{run}: all {len(stored)} measurements are the same, bit for bit.")
        return
    say(f"{run}: measurement {mismatch + 1} of {len(stored)} and what follows differ.")
    raise SystemExit(1)


def trained(run: RunAnswer, count: int) -> Curve:
    """The first `count` measurements of a run of the same spec."""
    measurements = algorithms.train(
        run.algorithm,
        run.environment,
        seeds=[run.seed],
        weights=(run.weights.w1, run.weights.w2),
        timesteps=run.timesteps,
        config=dict(run.config),
    )
    shown = track(measurements, "training", total=count, console=console)
    return [(each.timestep, each.return_mean) for each, _ in zip(shown, range(count), strict=False)]


def first_mismatch(stored: Curve, again: Curve) -> int | None:
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
