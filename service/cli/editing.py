"""`d3pg edit`: how a sweep is described, found and ranked."""

from __future__ import annotations

from typing import Annotated

import typer

from service.cli.listing import show_sweep
from service.cli.terminal import AsJson, SweepId, print_json
from service.client import Client


def edit(
    sweep_id: SweepId,
    name: Annotated[str | None, typer.Option(help="Any text.")] = None,
    notes: Annotated[str | None, typer.Option(help="Markdown, shown as text.")] = None,
    tag: Annotated[
        list[str] | None, typer.Option(help="Replaces its tags; may be repeated.")
    ] = None,
    untag: Annotated[bool, typer.Option("--untag", help="Take all its tags away.")] = False,
    archive: Annotated[
        bool | None, typer.Option("--archive/--unarchive", help="Out of the lists, or back.")
    ] = None,
    priority: Annotated[int | None, typer.Option(help="Higher goes first.")] = None,
    as_json: AsJson = False,
) -> None:
    """Change the name, notes, tags or priority of a sweep, or archive it; at any time."""
    if untag and tag:
        raise typer.BadParameter("--tag and --untag contradict each other", param_hint="--untag")
    with Client() as client:
        sweep = client.edit(
            sweep_id,
            name=name,
            notes=notes,
            tags=[] if untag else tag or None,
            archived=archive,
            priority=priority,
        )
        if as_json:
            print_json(sweep)
        else:
            show_sweep(sweep, client.url)
