"""Diagnoses of the evaluation's runs: where the simulator's gradients can help, by task.

`diagnosis.csv` is what `d3pg diagnose SWEEP --output` writes of a sweep. What it says of a task is
taken from the runs of DDPG: bias and spread of the exact gradient of HORIZON steps under NOISE,
growth of gradients through GROWTH steps, and the share of the gradient loss in 1 % of the rows.
The cosine between the critic's gradient in the action and that of rollouts of CUT steps tells, for
each learner, how well the actor is led.
"""

import math
from collections.abc import Iterator, Mapping
from pathlib import Path

from service.paper import markdown
from service.paper.evaluation import MORE_TASKS, TASKS
from service.paper.measured import lines

FILE = "diagnosis.csv"
HORIZON, NOISE = 8, 0.2
GROWTH = 32
CUT = 64
OF_TASK = "ddpg"
COLUMNS = ("task", "bias / norm", "exact / zeroth std", "growth", "top 1 % of the loss")
LEARNERS = ("ddpg", "hybrid-ddpg-robust", "hybrid-ddpg", "hybrid-ddpg-cosine")

Cells = Mapping[tuple[str, str], Mapping[tuple[str, str, str, str], float]]
"""By task and learner: values by diagnostic, quantity, horizon and noise, as they are written."""


def explained(folder: Path) -> Iterator[str]:
    """Yield the lines of a Markdown table; none where the folder has no diagnoses."""
    if not (folder / FILE).exists():
        return
    cells = _read(folder / FILE)
    yield "## Where gradients can help\n"
    yield from markdown.head(*COLUMNS, *(f"cosine, {learner}" for learner in LEARNERS))
    for task in (*TASKS, *MORE_TASKS):
        if (task, OF_TASK) in cells:
            yield markdown.line([task, *_numbers(cells, task)])


def _numbers(cells: Cells, task: str) -> Iterator[str]:
    own = cells[task, OF_TASK]

    def smoothed(quantity: str) -> float:
        return own.get(("smoothing", quantity, str(HORIZON), str(NOISE)), math.nan)

    yield _ratio(smoothed("bias"), smoothed("norm"))
    yield _ratio(smoothed("exact_std"), smoothed("zeroth_std"))
    yield _shown(own.get(("growth", "median_norm", str(GROWTH), ""), math.nan))
    yield _shown(own.get(("loss", "action_top_share", "", str(NOISE)), math.nan))
    for learner in LEARNERS:
        found = cells.get((task, learner), {})
        yield _shown(found.get(("critic", "action_cosine", str(CUT), ""), math.nan))


def _ratio(part: float, whole: float) -> str:
    return _shown(part / whole if whole else math.nan)


def _shown(number: float) -> str:
    return f"{number:.2g}" if math.isfinite(number) else "-"


def _read(file: Path) -> Cells:
    cells: dict[tuple[str, str], dict[tuple[str, str, str, str], float]] = {}
    for row in lines(file):
        name = (row["diagnostic"], row["quantity"], row["horizon"], row["noise"])
        cell = cells.setdefault((row["environment"], row["label"]), {})
        cell[name] = float(row["value"] or "nan")
    return cells
