"""The paper's figures 2 to 6: which runs of a sweep each shows, and what draws it."""

from collections.abc import Collection, Mapping
from dataclasses import dataclass
from typing import Literal

from service.model.run_curve import RETURNS

FigureNumber = Literal["2", "3", "4", "5", "6"]
MAX_CURVES = 500
MAX_LEARNERS = 12


@dataclass(frozen=True)
class PaperFigure:
    """What a figure shows.

    algorithms     whose curves; the first is what it is about
    environment    in which task; empty: in each, a column a task
    metrics        of the curves that it is made from
    normalized     whether those are
    module         has `draw`, given a title, a comparison per metric and a form, and `numbers`,
                   given those comparisons
    shows_policies whether both are given the folder of the checkpoints too
    max_curves     more are refused
    """

    title: str
    algorithms: tuple[str, ...]
    environment: str = ""
    metrics: tuple[str, ...] = RETURNS
    normalized: bool = True
    module: str = "service.analysis.figures.plot"
    shows_policies: bool = False
    max_curves: int = MAX_CURVES

    def has_runs(self, environments: Mapping[str, Collection[str]]) -> bool:
        """Whether there are runs of what it is about, in a sweep of those (by algorithm)."""
        where = environments.get(self.algorithms[0], ())
        return self.environment in where if self.environment else bool(where)


PAPER: Mapping[FigureNumber, PaperFigure] = {
    "2": PaperFigure(
        "the critic of the mass point",
        ("hybrid-ddpg", "ddpg"),
        environment="MassPoint",
        metrics=("return_mean",),
        module="service.analysis.figures.critic_figure",
        shows_policies=True,
        max_curves=MAX_LEARNERS,
    ),
    "3": PaperFigure(
        "the die's way to the target",
        ("hybrid-ddpg", "hybrid-ddpg-robust", "ddpg"),
        environment="RollingDie",
        metrics=("return_history",),
        normalized=False,
        module="service.analysis.figures.die_figure",
        shows_policies=True,
        max_curves=MAX_LEARNERS,
    ),
    "4": PaperFigure(
        "the hybrids and what they are measured by",
        ("hybrid-ddpg", "hybrid-ddpg-robust", "ddpg", "mpc", "gd"),
        module="service.analysis.figures.learning_figure",
    ),
    "5": PaperFigure("the cosine loss", ("hybrid-ddpg-cosine", "ddpg")),
    "6": PaperFigure("soft actor-critic", ("hybrid-sac", "sac")),
}
