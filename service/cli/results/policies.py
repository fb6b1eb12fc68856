"""`d3pg policy`: what a run has learned, as a file to act with."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Annotated

import typer

import algorithms
from service.cli.terminal import AsJson, say
from service.client import Client

SUFFIX = ".npz"


def policy(
    run_id: Annotated[str, typer.Argument(metavar="RUN", help="The id of a run.")],
    output: Annotated[
        Path | None, typer.Option("--output", "-o", help="A .npz file, without pickle.")
    ] = None,
    as_json: AsJson = False,
) -> None:
    """Save the policy that a run has learned, or only describe it."""
    if output is not None and output.suffix != SUFFIX:
        raise typer.BadParameter(
            f"{output} must end in {SUFFIX}: a policy is a NumPy archive", param_hint="--output"
        )
    with Client() as client:
        content = client.policy_file(run_id)
    header = algorithms.load_policy(content).header
    if output is not None:
        output.write_bytes(content)
    if as_json:
        file = None if output is None else str(output)
        say(json.dumps({"file": file, **header.document()}, indent=2))
        return
    say(
        f"{run_id} at timestep {header.origin['timestep']:,} in {header.task} "
        f"(version {header.task_version}): {header.action_size} actions of "
        f"{header.feature_map.size} features, hidden layers of {header.hidden_units} "
        f"{header.activation} units"
    )
    if output is not None:
        say(f"Wrote {output}")
