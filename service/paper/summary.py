"""What the measurements say to the evaluation's questions, in Markdown.

Is a hybrid better than what it extends, at equal timesteps and at equal processor time, in the
paper's seven tasks? Which learner goes farthest on HalfCheetah? Why? As far as runs have ended.
"""

from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path

import numpy as np

from service.analysis.comparison import grouped
from service.analysis.statistics.sample import sample
from service.analysis.statistics.score import area, final_score
from service.paper import markdown
from service.paper.differences import Gain, gains
from service.paper.evaluation import TASKS
from service.paper.explained import explained
from service.paper.measured import ENDED, MeasuredRun, Scale, read_runs, read_scales
from service.paper.search import tuning_file
from service.paper.search.searched import searched
from service.paper.speeds import slowness
from service.paper.today import told

COST_TEXT = {"timesteps": "equal timesteps", "seconds": "equal processor time"}
VERDICTS = ("better", "behind", "not told apart", "not known")
ROBOT = "HalfCheetah"


def summarized(folder: Path) -> str:
    """Return the summary of a folder's measurements."""
    runs, scales = read_runs(folder), read_scales(folder)
    hybrids = grouped(gains(runs, scales), lambda gain: gain.algorithm)
    parts = [part for hybrid, found in hybrids.items() for part in _of_hybrid(hybrid, found)]
    parts += [
        *told(runs, scales, slowness(folder)),
        "",
        *_of_robot(runs, scales),
        "",
        *explained(folder),
    ]
    known = tuning_file.read(folder)
    return "\n".join([*parts, "", *searched(known)] if known else parts)


def _of_hybrid(hybrid: str, found: Sequence[Gain]) -> Iterator[str]:
    """Yield a hybrid's counts of verdicts, and its table."""
    yield f"## {hybrid} minus its baseline\n"
    for cost, text in COST_TEXT.items():
        yield f"- {text}: {_counted([gain for gain in found if gain.cost == cost])}"
    yield ""
    yield from markdown.head("task", *COST_TEXT.values())
    for environment, cells in grouped(found, lambda gain: gain.environment).items():
        by_cost = {gain.cost: gain for gain in cells}
        yield markdown.line([environment, *(_cell(by_cost[cost]) for cost in COST_TEXT)])
    yield ""


def _counted(found: Sequence[Gain]) -> str:
    """`better on 5, behind on 0, not told apart on 2, not known on 0 of the paper's 7 tasks`."""
    verdicts = Counter(gain.verdict for gain in found if gain.environment in TASKS and gain.n)
    verdicts["not known"] = len(TASKS) - verdicts.total()
    numbers = [f"{word} on {verdicts[word]}" for word in VERDICTS]
    return f"{', '.join(numbers)} of the paper's {len(TASKS)} tasks"


def _cell(gain: Gain) -> str:
    """`**+0.191** [0.151, 0.230], p 0.0002, 32 of 32, better`: interval of the task, Holm's p."""
    if not gain.n:
        return f"no pair ended ({gain.failed} failed)"
    mean = f"{gain.mean.value:+.3f}"
    shown = mean if gain.verdict == "not told apart" else f"**{mean}**"
    interval = f"[{gain.mean.low:.3f}, {gain.mean.high:.3f}]"
    failed = f", {gain.failed} failed" if gain.failed else ""
    p = f"p {gain.corrected_p:.2g}"
    return f"{shown} {interval}, {p}, {gain.wins} of {gain.n}{failed}, {gain.verdict}"


def _of_robot(runs: Sequence[MeasuredRun], scales: Mapping[str, Scale]) -> Iterator[str]:
    """Yield the learners on HalfCheetah, the best first."""
    there = [run for run in runs if run.environment == ROBOT and ROBOT in scales]
    yield f"## {ROBOT}, normalised\n"
    yield from markdown.head("learner", "last tenth", "area", "runs")
    rows = [_row(row, own, scales[ROBOT]) for row, own in grouped(there, lambda r: r.row).items()]
    for _, text in sorted(rows, reverse=True):
        yield text


def _row(row: str, runs: Sequence[MeasuredRun], scale: Scale) -> tuple[float, str]:
    """The mean final score, and a line with it."""
    ended = [run for run in runs if run.status == ENDED]
    finals = [
        final_score(run.columns["timestep"], run.columns["return_mean"], run.timesteps)
        for run in ended
    ]
    areas = [area(run.columns["timestep"], run.columns["return_mean"]) for run in ended]
    final, under = (
        sample((np.array(scores) - scale.random) / scale.unit) for scores in (finals, areas)
    )
    counted = f"{final.n} of {len(runs)}"
    if not final.n:
        return -np.inf, markdown.line([row, "-", "-", counted])
    shown = f"{final.mean:.3f} [{final.low:.3f}, {final.high:.3f}]"
    return final.mean, markdown.line([row, shown, f"{under.mean:.3f}", counted])
