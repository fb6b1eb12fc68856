"""Display: the progress of a training in a terminal and in a log file, and its summary.

A display is a context in which a training runs. It yields a function that shows the progress: a bar
with the time left in a terminal, a line for every tenth of the way elsewhere.
"""

import time
from collections.abc import Callable, Iterator
from contextlib import AbstractContextManager, contextmanager

import numpy as np
from rich.console import Console
from rich.progress import BarColumn, Progress, SpinnerColumn, TaskProgressColumn, TextColumn
from rich.table import Table

from algorithms.cli.outcome import Outcome

Show = Callable[[int], None]
"""Called with the timestep that all runs have reached."""
COMPILING = "compiling kernels (minutes, the first time)"


def display(
    console: Console, title: str, timesteps: int, outcome: Outcome
) -> AbstractContextManager[Show]:
    """The display that suits the console."""
    chosen = live_display if console.is_terminal else line_display
    return chosen(console, title, timesteps, outcome)


@contextmanager
def live_display(console: Console, title: str, timesteps: int, outcome: Outcome) -> Iterator[Show]:
    """A bar, the time left and the mean return."""
    bar = Progress(
        SpinnerColumn(),
        TextColumn("{task.description}", markup=False),
        BarColumn(bar_width=24),
        TaskProgressColumn(),
        TextColumn("{task.fields[left]}"),
        TextColumn("{task.fields[standing]}"),
        console=console,
    )
    clock = Clock(timesteps)
    with bar:
        task = bar.add_task(f"{title}: {COMPILING}", total=timesteps, left="", standing="")

        def show(timestep: int) -> None:
            bar.update(
                task, description=title, completed=timestep,
                left=clock.left_text(timestep), standing=outcome.mean_text,
            )  # fmt: skip

        yield show


@contextmanager
def line_display(console: Console, title: str, timesteps: int, outcome: Outcome) -> Iterator[Show]:
    """Plain lines, one for every tenth of the way."""
    clock, shown = Clock(timesteps), 0

    def say(text: str) -> None:
        console.print(f"{title}: {text}", markup=False, highlight=False, soft_wrap=True)

    def show(timestep: int) -> None:
        nonlocal shown
        tenth, left = 10 * timestep // timesteps, clock.left_text(timestep)
        if tenth > shown:
            shown = tenth
            say(", ".join(part for part in (f"{10 * tenth} %", outcome.mean_text, left) if part))

    say(COMPILING)
    yield show


class Clock:
    """Estimates the time left, from the pace since the first report, when kernels are compiled.

    Attributes:
        now: a clock in seconds, with any origin.
    """

    now = staticmethod(time.monotonic)

    def __init__(self, timesteps: int) -> None:
        """Wait for the first report of progress."""
        self._timesteps = timesteps
        self._begun: tuple[float, int] | None = None

    def left_text(self, timestep: int) -> str:
        """`ETA 1:23`; empty while it is not known."""
        now = self.now()
        if self._begun is None:
            self._begun = now, timestep
        start, first = self._begun
        if timestep <= first:
            return ""
        seconds = round((now - start) * (self._timesteps - timestep) / (timestep - first))
        minutes, seconds = divmod(seconds, 60)
        hours, minutes = divmod(minutes, 60)
        return f"ETA {hours}:{minutes:02}:{seconds:02}" if hours else f"ETA {minutes}:{seconds:02}"


def summary(outcome: Outcome) -> Table:
    """A row for each run, and the mean of all measured runs."""
    table = Table("seed", "timestep", "return_mean", "return_history", "seconds", "", box=None)
    for seed in outcome.seeds:
        early = outcome.ended.get(seed)
        end = "" if early is None else early.reason
        if seed not in outcome.latest:
            table.add_row(str(seed), "-", "-", "-", "-", end or "not measured")
            continue
        m = outcome.latest[seed]
        table.add_row(
            str(seed), f"{m.timestep:,}", f"{m.return_mean:,.2f}", f"{m.return_history:,.2f}",
            f"{m.seconds:.1f}", end,
        )  # fmt: skip
    if outcome.latest:
        means = [f"{np.mean(outcome.returns(n)):,.2f}" for n in ("return_mean", "return_history")]
        table.add_row("mean", "", *means, "", "", style="bold")
    return table
