"""Diagnoses as they are shown: medians over the seeds of a cell, figures, remarks.

The numbers, and how they are found: `algorithms.diagnostics.diagnose`.
"""

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Literal

from algorithms.diagnostics.medians import Medians, medians
from service.analysis.comparison import grouped
from service.model.diagnosis import Diagnosis
from service.model.environment import environment_facts
from service.model.run import Run

FigureName = Literal["smoothing", "growth", "critic", "loss"]


@dataclass(frozen=True)
class FigureText:
    """A figure's title, what it shows, and what that says."""

    title: str
    definition: str
    reading: str


FIGURES: Mapping[FigureName, FigureText] = {
    "smoothing": FigureText(
        "Bias and variance of the exact gradient",
        "The exact gradient of the return of H noisy steps: its bias over the gradient of the "
        "smoothed return (hollow: these samples cannot tell it from 0), and its standard deviation "
        "over that of an estimate from returns alone.",
        "The exact gradient cannot help where its bias comes near 1. It helps where its standard "
        "deviation is below 1: there the estimate from returns alone is the noisier one.",
    ),
    "growth": FigureText(
        "Growth of gradients through time",
        "The norm of d s(t+H) / d s(t) along the policy's episodes: the median, and up to the "
        "highest tenth.",
        "If it grows with each doubling of H, gradients of long rollouts have a large variance, "
        "and a target that bootstraps after one step is the better use of a derivative. If it "
        "falls, gradients through time vanish.",
    ),
    "critic": FigureText(
        "The critic's gradient beside the rollout's",
        "The mean cosine between the critic's gradient and that of the policy's discounted return, "
        "cut after H steps.",
        "1 is the same direction. Near 0 or below, the critic misleads the actor, which follows "
        "its gradient in the action. A small H leaves out what is earned later.",
    ),
    "loss": FigureText(
        "Share of the gradient loss in 1 % of the rows",
        "What the largest hundredth of 1,024 rows is of the L2 gradient loss.",
        "Without outliers it is a few per cent. If it is near 1, an L2 hybrid learns from a few "
        "rows alone, and a bounded loss (hybrid-ddpg-robust) is called for.",
    ),
}


@dataclass(frozen=True)
class DiagnosedCell:
    """The runs of a cell that have findings, and the medians of those."""

    label: str
    algorithm: str
    environment: str
    seeds: tuple[int, ...]
    medians: Medians

    def has(self, diagnostic: str) -> bool:
        """Whether it has findings of a diagnostic."""
        return any(name[0] == diagnostic for name in self.medians)


def diagnosed_cells(
    diagnoses: Sequence[Diagnosis], label: Callable[[Run], str]
) -> list[DiagnosedCell]:
    """Return the cells of those diagnoses that have findings; `label` names the entry of a run."""
    made = [each for each in diagnoses if each.findings is not None]
    cells = grouped(made, lambda each: (each.run.spec.environment, label(each.run)))
    return [_cell(name, members) for (_, name), members in cells.items()]


def _cell(label: str, members: Sequence[Diagnosis]) -> DiagnosedCell:
    spec = members[0].run.spec
    return DiagnosedCell(
        label,
        spec.algorithm,
        spec.environment,
        tuple(each.run.spec.seed for each in members),
        medians(each.findings or () for each in members),
    )


def figures_of(cells: Sequence[DiagnosedCell]) -> dict[FigureName, FigureText]:
    """Return the figures that have something to show."""
    return {name: text for name, text in FIGURES.items() if any(cell.has(name) for cell in cells)}


def remarks(cells: Sequence[DiagnosedCell]) -> Iterator[str]:
    """Say what the figures of these cells cannot show."""
    without_critic = dict.fromkeys(cell.label for cell in cells if not cell.has("critic"))
    if without_critic:
        yield (f"No critic, so nothing about a critic's gradient: {', '.join(without_critic)}.")
    for environment in dict.fromkeys(cell.environment for cell in cells):
        if not environment_facts(environment).reward_is_differentiable:
            yield (
                f"The reward of {environment} is piecewise constant: its exact gradient is 0, so "
                "its bias is the whole gradient of the smoothed return, and no cosine to a "
                "rollout's gradient exists."
            )
