"""`d3pg edit` and `rm`: change the description of a sweep; delete sweeps."""

from __future__ import annotations

from typing import Annotated

import typer

from service.cli.identifiers import SweepId, SweepIds
from service.cli.listing import show_sweep
from service.cli.moving import say_moved
from service.cli.submitting import counted_runs
from service.cli.terminal import AsJson, errors, plain, print_json, say
from service.client import Client


def edit(
    sweep_id: SweepId,
    name: Annotated[str | None, typer.Option(help="New name; any text.")] = None,
    notes: Annotated[str | None, typer.Option(help="Markdown, shown as text.")] = None,
    tag: Annotated[
        list[str] | None, typer.Option(help="Tag that replaces the present ones; may be repeated.")
    ] = None,
    untag: Annotated[bool, typer.Option("--untag", help="Remove all tags.")] = False,
    archive: Annotated[
        bool | None,
        typer.Option("--archive/--unarchive", help="Hide the sweep from lists, or show it again."),
    ] = None,
    priority: Annotated[
        int | None, typer.Option(help="Sweeps of higher priority start first.")
    ] = None,
    max_workers: Annotated[
        int | None,
        typer.Option(help="Workers that may train the sweep at once; 0 removes the limit."),
    ] = None,
    webhook: Annotated[
        str | None, typer.Option(help="URL to notify when the sweep has ended; none removes it.")
    ] = None,
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
            max_workers="any" if max_workers == 0 else max_workers,
            webhook=webhook,
        )
        if as_json:
            print_json(sweep)
        else:
            show_sweep(sweep, client.url)


def rm(
    sweep_ids: SweepIds,
    yes: Annotated[bool, typer.Option("--yes", "-y", help="Do not ask.")] = False,
    as_json: AsJson = False,
) -> None:
    """Delete sweeps that have ended, with their measurements and policies, for good."""
    with Client() as client:
        if not yes:
            for sweep_id in sweep_ids:
                sweep = client.sweep(sweep_id)
                say(f"{sweep.id}: {plain(sweep.name)}, {counted_runs(sweep.runs.total)}", errors)
            typer.confirm("Delete for good, with measurements and policies?", abort=True, err=True)
        answer = client.move_all(sweep_ids, "delete")
    say_moved(answer, "deleted", as_json)
