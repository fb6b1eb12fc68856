"""Arguments that name sweeps, runs, algorithms and tasks: beginnings suffice, the shell completes.

An id may be shortened to a beginning that no other sweep's id has. In the id of a run, the part of
the sweep may be shortened (`3f9a-17`).
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator, Sequence
from contextlib import suppress
from itertools import islice
from typing import Annotated, Literal

import typer

from service.api.schemas.listed_sweep_answer import ListedSweepAnswer
from service.cli.terminal import plain
from service.client import Client, ServiceError
from service.model.compared import SEPARATOR

WHOLE = re.compile(r"[0-9a-f]{12}(-\d+)?")
BEGINNING = re.compile(r"(?P<sweep>[0-9a-f]{1,12})(?P<run>-\d+)?")
MOST_OFFERED = 50


def whole_id(text: str) -> str:
    """Return the id that a text is the beginning of. Raises typer.BadParameter for several."""
    cut = BEGINNING.fullmatch(text)
    if WHOLE.fullmatch(text) or not cut:
        return text  # the service says what is wrong with it
    with Client() as client:
        found = [sweep.id for sweep in islice(_beginning(client, cut["sweep"]), 3)]
    if len(found) > 1:
        raise typer.BadParameter(f"{text!r} is the beginning of several: {', '.join(found)}, ...")
    return f"{found[0]}{cut['run'] or ''}" if found else text


def whole_ids(text: str) -> str:
    """Apply `whole_id` to each of several joined ids, such as `3f9a+b2`."""
    return SEPARATOR.join(map(whole_id, text.split(SEPARATOR)))


def _one(context: typer.Context, text: str | None) -> str | None:
    """Return the whole id, but not while the shell completes: that must not wait for it."""
    return text if context.resilient_parsing or not text else whole_ids(text)


def _each(context: typer.Context, texts: Sequence[str]) -> list[str]:
    return list(texts) if context.resilient_parsing else [whole_id(text) for text in texts]


def _beginning(client: Client, text: str) -> Iterator[ListedSweepAnswer]:
    found = client.sweeps(text, archived=None) if text else client.sweeps()
    return (sweep for sweep in found if sweep.id.startswith(text))


def complete_sweep(incomplete: str) -> list[tuple[str, str]]:
    """Offer the sweeps whose ids begin with the text, with their names."""
    with suppress(ServiceError), Client(timeout_seconds=3.0) as client:
        found = islice(_beginning(client, incomplete), MOST_OFFERED)
        return [(sweep.id, plain(sweep.name)) for sweep in found]
    return []


def complete_id(incomplete: str) -> list[tuple[str, str]]:
    """Offer sweeps; after a whole sweep id, the runs of the sweep."""
    sweep_id, dash, _ = incomplete.partition("-")
    if not dash:
        return complete_sweep(incomplete)
    with suppress(ServiceError), Client(timeout_seconds=3.0) as client:
        runs = (run for run in client.runs(sweep_id) if run.id.startswith(incomplete))
        offered = islice(runs, MOST_OFFERED)
        return [(r.id, f"{plain(r.label)} {plain(r.environment)} seed {r.seed}") for r in offered]
    return []


def complete_algorithm(incomplete: str) -> list[tuple[str, str]]:
    """Offer the algorithms whose names begin with the text."""
    return _from_catalogue(incomplete, "algorithms")


def complete_environment(incomplete: str) -> list[tuple[str, str]]:
    """Offer the tasks whose names begin with the text."""
    return _from_catalogue(incomplete, "environments")


def _from_catalogue(
    incomplete: str, kind: Literal["algorithms", "environments"]
) -> list[tuple[str, str]]:
    with suppress(ServiceError), Client(timeout_seconds=3.0) as client:
        known = client.catalogue_names(kind)
        return [(n, text) for n, text in known.items() if n.lower().startswith(incomplete.lower())]
    return []


def _argument(
    metavar: str, text: str, callback: Callable[..., object], complete: Callable[..., object]
) -> object:
    return typer.Argument(metavar=metavar, help=text, callback=callback, autocompletion=complete)


SweepId = Annotated[
    str, _argument("SWEEP", "The id of a sweep, or its beginning.", _one, complete_sweep)
]
SweepIds = Annotated[
    list[str], _argument("SWEEP...", "Ids of sweeps, or beginnings.", _each, complete_sweep)
]
MaybeSweepId = Annotated[str | None, _argument("[SWEEP]", "List its runs.", _one, complete_sweep)]
Identifier = Annotated[
    str, _argument("ID", "A sweep or a single run, or its beginning.", _one, complete_id)
]
RunId = Annotated[str, _argument("RUN", "The id of a run, or its beginning.", _one, complete_id)]
Identifiers = Annotated[
    list[str], _argument("ID...", "Sweeps and single runs, or beginnings.", _each, complete_id)
]
