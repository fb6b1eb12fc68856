"""Following a sweep in the terminal: a progress bar with ETA, and how each curve stands."""

from __future__ import annotations

import textwrap
from collections.abc import Callable, Iterator
from itertools import islice

import typer
from rich.console import Console, Group
from rich.live import Live
from rich.progress import BarColumn, Progress, TaskProgressColumn, TextColumn
from rich.text import Text

from service.api.schemas.curves_answer import CurveAnswer
from service.api.schemas.question.verdict_answer import VerdictAnswer
from service.api.schemas.run_answer import RunAnswer
from service.api.schemas.search.search_answer import SearchAnswer
from service.api.schemas.sweep_answer import SweepAnswer, SweepHead
from service.cli.identifiers import SweepId
from service.cli.terminal import AsJson, console, plain, print_json, print_table, say, table_of
from service.client import Client

MAX_NAME = 24
MAX_NAMED = 4
MAX_LOOKED_AT = 100
HEADINGS = ("task", "learner", "timestep", "return_history", "n")

Progressed = Callable[[SweepAnswer], None]


def watch(sweep_id: SweepId, as_json: AsJson = False) -> None:
    """Follow a sweep to its end: progress, ETA and latest values of its curves."""
    with Client() as client:
        code = follow(client, sweep_id, console, as_json=as_json)
    raise typer.Exit(code)


def follow(client: Client, sweep_id: str, console: Console, *, as_json: bool = False) -> int:
    """Show a sweep until it ends. Return the exit code: 0 if no run failed or diverged, else 1.

    On KeyboardInterrupt, say that the sweep goes on, and raise it again.
    """
    sweep = client.sweep(sweep_id)
    try:
        ended = _followed(client, sweep, console, as_json)
    except KeyboardInterrupt:
        typer.echo(f"The sweep goes on. Look again: d3pg watch {sweep_id}", err=True)
        raise
    if not as_json:
        say_findings(client, ended, console)
        for run in _unsuccessful(client, ended):
            say(
                f"{run.id} {run.label} {run.environment} seed {run.seed}: "
                f"{run.status}: {run.reason}",
                console,
            )
    return 1 if ended.runs.failed + ended.runs.diverged else 0


def say_findings(client: Client, sweep: SweepAnswer, console: Console = console) -> None:
    """Print the results so far of a sweep's question and search, if it has them."""
    if sweep.request.get("question"):
        say_verdict(client.verdict(sweep.id), console)
    if sweep.request.get("search"):
        say_search(client.search(sweep.id), console)


def say_search(found: SearchAnswer, console: Console = console) -> None:
    """Print what a search has found: a line a task, and what its seeds are not used for."""
    for task in found.tasks:
        say(f"{task.environment}: {task.sentence}", console)
    if found.is_settled:
        say(found.kept_apart, console)


def say_verdict(verdict: VerdictAnswer, console: Console = console) -> None:
    """Print the results of a question: a line a comparison, and the sentence for a paper."""
    for each in verdict.comparisons:
        say(f"{each.environment}: {each.label} vs {each.against}: {each.sentence}", console)
    if verdict.is_settled:
        say(verdict.paper, console)
    if verdict.searches:
        say(verdict.kept_apart, console)


def _followed(client: Client, sweep: SweepAnswer, console: Console, as_json: bool) -> SweepAnswer:
    """Show a sweep until it ends."""
    if as_json:
        return client.wait(sweep.id, progressed=changes(lambda s: print_json(s, indent=None)))
    show = _follow_live if console.is_terminal else _follow_lines
    return show(client, sweep, console)


def _follow_live(client: Client, sweep: SweepAnswer, console: Console) -> SweepAnswer:
    progress = Progress(
        TextColumn("{task.description}", markup=False),
        BarColumn(bar_width=24),
        TaskProgressColumn(),
        TextColumn("{task.fields[eta]}"),
        TextColumn("{task.fields[counts]}"),
        console=console,
    )
    name = textwrap.shorten(plain(sweep.name), MAX_NAME, placeholder=" …") or sweep.id
    bar = progress.add_task(name, total=1.0, eta="", counts="")
    with Live(console=console, refresh_per_second=4) as live:

        def progressed(sweep: SweepAnswer) -> None:
            progress.update(
                bar, completed=sweep.progress, eta=eta_text(sweep), counts=counts_text(sweep)
            )
            table = table_of(HEADINGS, standings(client, sweep.id), console.width)
            live.update(Group(progress, table, Text(starting_text(client, sweep))))

        return client.wait(sweep.id, progressed=progressed)


def _follow_lines(client: Client, sweep: SweepAnswer, console: Console) -> SweepAnswer:
    """Print a plain line for each tenth of the progress, as suits a log file.

    If a sweep gets more runs, as from its question, its progress falls and lines are repeated.
    """
    shown = -1
    starting = ""

    def progressed(sweep: SweepAnswer) -> None:
        nonlocal shown, starting
        before, starting = starting, starting_text(client, sweep)
        if starting not in ("", before):
            say(starting, console)
        tenth = int(sweep.progress * 10)
        if tenth != shown:
            shown = tenth
            line = f"{sweep.name}: {sweep.progress:.0%} {counts_text(sweep)} {eta_text(sweep)}"
            say(line.rstrip(), console)

    ended = client.wait(sweep.id, progressed=progressed)
    print_table(HEADINGS, standings(client, ended.id), console)
    return ended


def changes(progressed: Progressed) -> Progressed:
    """Pass on a sweep only when it differs from the one before, its ETA aside."""
    before: SweepAnswer | None = None

    def passing(sweep: SweepAnswer) -> None:
        nonlocal before
        timeless = sweep.model_copy(update={"eta_seconds": None})
        if timeless != before:
            before = timeless
            progressed(sweep)

    return passing


def standings(client: Client, sweep_id: str) -> list[tuple[str, ...]]:
    """A row a curve: the latest normalised return_history, mean and deviation over n seeds."""
    curves = client.curves(sweep_id, metric="return_history", normalized=True, max_points=2)
    return [
        (panel.environment, curve.label, *_latest(curve))
        for panel in curves.panels
        for curve in panel.curves
    ]


def starting_text(client: Client, sweep: SweepAnswer) -> str:
    """Name the runs whose kernels are being loaded or compiled; nothing where there are none."""
    if not sweep.runs.running:
        return ""
    running = client.runs(sweep.id, status="running", sort="timestep", limit=MAX_LOOKED_AT)
    names = [run.id for run in islice(running, MAX_LOOKED_AT) if run.is_starting]
    if not names:
        return ""
    others = f" and {len(names) - MAX_NAMED} more" if len(names) > MAX_NAMED else ""
    return f"Kernels are loaded, or compiled at first use: {', '.join(names[:MAX_NAMED])}{others}"


def _latest(curve: CurveAnswer) -> tuple[str, str, str]:
    known = [i for i, mean in enumerate(curve.mean) if mean is not None]
    if not known:
        return "-", "-", f"0 of {curve.runs}"
    i = known[-1]
    mean, high = curve.mean[i], curve.high[i]
    value = f"{mean:.3f}"
    if mean is not None and high is not None:
        value += f" ± {high - mean:.3f}"
    n = curve.n[i]
    return f"{curve.x[i]:,.0f}", value, str(n) if n == curve.runs else f"{n} of {curve.runs}"


def counts_text(sweep: SweepHead) -> str:
    """The number of runs by status, zeros left out: `2 running, 14 queued`."""
    counts = sweep.runs.model_dump(exclude={"total"})
    return ", ".join(f"{count} {status}" for status, count in counts.items() if count)


def eta_text(sweep: SweepHead) -> str:
    """The time left in words; empty where it is not known, or none is left."""
    if not sweep.eta_seconds:
        return ""
    minutes, seconds = divmod(round(sweep.eta_seconds), 60)
    hours, minutes = divmod(minutes, 60)
    return f"ETA {hours}:{minutes:02}:{seconds:02}" if hours else f"ETA {minutes}:{seconds:02}"


def _unsuccessful(client: Client, sweep: SweepAnswer) -> Iterator[RunAnswer]:
    for status in ("failed", "diverged"):
        if getattr(sweep.runs, status):
            yield from client.runs(sweep.id, status=status)
