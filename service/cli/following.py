"""Following a sweep in the terminal: a progress bar with ETA, and how each curve stands."""

from __future__ import annotations

from typing import Any

from rich.console import Console, Group
from rich.live import Live
from rich.progress import BarColumn, Progress, TaskProgressColumn, TextColumn
from rich.table import Table
from rich.text import Text

from service.client import Client

Json = dict[str, Any]

STATUSES = ("queued", "paused", "running", "succeeded", "failed", "diverged", "cancelled")


def follow(client: Client, sweep_id: str, console: Console) -> int:
    """Show a sweep until it ends; the exit code: 0 if no run failed or diverged, else 1."""
    sweep = client.sweep(sweep_id)
    show = _follow_live if console.is_terminal else _follow_lines
    ended = show(client, sweep, console)
    for run in _unsuccessful(client, ended):
        console.print(
            f"{run['id']} {run['algorithm']} {run['environment']} seed {run['seed']}: "
            f"{run['status']}: {run['reason']}",
            markup=False,
        )
    return 1 if ended["runs"]["failed"] + ended["runs"]["diverged"] else 0


def _follow_live(client: Client, sweep: Json, console: Console) -> Json:
    progress = Progress(
        TextColumn("{task.description}"),
        BarColumn(),
        TaskProgressColumn(),
        TextColumn("{task.fields[eta]}"),
        TextColumn("{task.fields[counts]}"),
        console=console,
    )
    bar = progress.add_task(Text(sweep["name"]).plain, total=1.0, eta="", counts="")
    with Live(console=console, refresh_per_second=4) as live:

        def progressed(sweep: Json) -> None:
            progress.update(
                bar, completed=sweep["progress"], eta=eta_text(sweep), counts=counts_text(sweep)
            )
            live.update(Group(progress, standings(client, sweep)))

        return client.wait(sweep["id"], progressed=progressed)


def _follow_lines(client: Client, sweep: Json, console: Console) -> Json:
    """Plain lines, one for every tenth of the way: what a log file wants."""
    shown = -1

    def progressed(sweep: Json) -> None:
        nonlocal shown
        tenth = int(sweep["progress"] * 10)
        if tenth > shown:
            shown = tenth
            line = (
                f"{sweep['name']}: {sweep['progress']:.0%} {counts_text(sweep)} {eta_text(sweep)}"
            )
            console.print(line.rstrip(), markup=False, soft_wrap=True)

    ended = client.wait(sweep["id"], progressed=progressed)
    console.print(standings(client, ended))
    return ended


def standings(client: Client, sweep: Json) -> Table:
    """A row a curve: the latest normalised return_history, mean and deviation over seeds."""
    curves = client.curves(sweep["id"], metric="return_history", normalized=True, max_points=2)
    table = Table("task", "algorithm", "timestep", "return_history", "n", box=None, padding=(0, 2))
    for panel in curves["panels"]:
        for curve in panel["curves"]:
            table.add_row(Text(panel["environment"]), Text(curve["label"]), *_latest(curve))
    return table


def _latest(curve: Json) -> tuple[str, str, str]:
    known = [i for i, mean in enumerate(curve["mean"]) if mean is not None]
    if not known:
        return "-", "-", "0"
    i = known[-1]
    value = f"{curve['mean'][i]:.3f}"
    if curve["high"][i] is not None:
        value += f" ± {curve['high'][i] - curve['mean'][i]:.3f}"
    return f"{curve['x'][i]:,.0f}", value, str(curve["n"][i])


def counts_text(sweep: Json) -> str:
    """The runs by status, those there are: `2 running, 14 queued`."""
    counts = ((sweep["runs"][status], status) for status in STATUSES)
    return ", ".join(f"{count} {status}" for count, status in counts if count)


def eta_text(sweep: Json) -> str:
    """The time left in words; empty where it is not known."""
    seconds = sweep["eta_seconds"]
    if seconds is None:
        return ""
    minutes, seconds = divmod(round(seconds), 60)
    hours, minutes = divmod(minutes, 60)
    return f"ETA {hours}:{minutes:02}:{seconds:02}" if hours else f"ETA {minutes}:{seconds:02}"


def _unsuccessful(client: Client, sweep: Json) -> list[Json]:
    return [
        run
        for status in ("failed", "diverged")
        if sweep["runs"][status]
        for run in client.runs(sweep["id"], status=status)
    ]
