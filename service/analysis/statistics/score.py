"""Scores: one number for the result of a run.

    final           mean of return_mean over the measurements at timestep > 0.9 T, at least the last
    return_history  its latest value: the mean of the latest 100 return_mean (the paper's table 1)
    area            mean of return_mean along the run, by trapezoids over timesteps

    T  the run's timesteps, as they were asked for

`final` says what the policy earns at the end. return_history looks back over 100 measurements,
80,000 timesteps, and so over the whole of a shorter run. A run that ends before 0.9 T, as gradient
descent on a plateau, has its last measurement alone as its final score.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Literal

import numpy as np

from service.analysis.curves import Floats

Score = Literal["final", "return_history", "area"]
Scored = Callable[[Floats, Floats, int], float]


@dataclass(frozen=True)
class ScoreKind:
    """One of the scores.

    metric  what of the run's measurements it is made of
    of      (timesteps [n], the metric there [n], T) -> the score; n >= 1
    text    what it is, in words
    of_end  whether it is made of those in the last tenth of T, and the last, alone
    """

    metric: str
    of: Scored
    text: str
    of_end: bool = True


def final_score(timesteps: Floats, return_mean: Floats, asked: int) -> float:
    """Return the mean of return_mean [n] in the last tenth of the asked timesteps; n >= 1.

    NaN or infinite where a value in that window is.
    """
    at_end = 10 * timesteps > 9 * asked
    at_end[-1] = True
    with np.errstate(all="ignore"):
        return float(return_mean[at_end].mean())


def area(x: Floats, y: Floats) -> float:
    """Return the mean of y [n] along x [n], by trapezoids; n >= 1."""
    with np.errstate(all="ignore"):
        return float(np.trapezoid(y, x) / (x[-1] - x[0])) if len(x) > 1 else float(y[0])


SCORES: Mapping[Score, ScoreKind] = {
    "final": ScoreKind(
        "return_mean",
        final_score,
        "the final score (mean of return_mean over the last tenth of the run's timesteps, at least "
        "its last measurement)",
    ),
    "return_history": ScoreKind(
        "return_history",
        lambda _, history, __: float(history[-1]),
        "the latest return_history (mean of the latest 100 return_mean)",
    ),
    "area": ScoreKind(
        "return_mean",
        lambda timesteps, returns, _: area(timesteps, returns),
        "the area under the curve of return_mean over timesteps (its mean along the run, by "
        "trapezoids)",
        of_end=False,
    ),
}
