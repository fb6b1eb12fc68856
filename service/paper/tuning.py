"""How the presets were chosen: sweeps over the paper's search set, two rounds a task.

1. The settings. DDPG with each noise and each decay of its critic; SAC with each reward scale.
2. The weights. Hybrid DDPG with each pair (w1, w2) of the paper's {1, 0.1, 0.01}, and with one of
   the two terms alone; the other two hybrids, for want of time, with equal weights and with one
   term alone. Settings are those that round 1 found best for the algorithm that the hybrid extends:
   the baseline has the first choice.

What is best has the largest mean, over runs, of the area under the normalised learning curve (the
mean of its return_mean); of equals the first. A cell of which a run did not reach its end is not
chosen. Gradient descent and MPC, which have no gradient
terms, were tuned before this service could run them; `algorithms.presets` has what they reached.

Seeds are none of the evaluation's. A cell whose outcome is known already is not run again: the
search outlives the database and the machine that began it by its table, tuning.csv.
"""

from collections.abc import Collection, Iterable, Mapping, Sequence
from dataclasses import dataclass
from itertools import product, starmap
from typing import Any

import numpy as np

from algorithms import catalogue
from service.analysis.statistics.score import final_score
from service.api.schemas.curves_answer import CurveAnswer, CurvesAnswer
from workers.messages.run_spec import NO_WEIGHTS, Weights

SEEDS = [100, 101, 102, 103]

TIMESTEPS = {
    "CartPole": 40_000,
    "CartPoleSwingUp": 60_000,
    "Pendulum": 20_000,
    "MountainCar": 40_000,
    "Acrobot": 40_000,
    "RollingDie": 40_000,
    "HalfCheetah": 80_000,
    "MassPoint": 12_000,
}
"""Long enough to tell good settings from bad ones; the evaluation is longer."""

SOFT_TASKS = ["CartPole", "CartPoleSwingUp", "Pendulum", "MountainCar", "RollingDie"]
"""The five tasks of the paper's figure 6 (appendix A.2)."""

SETTINGS: Mapping[str, Mapping[str, tuple[Any, ...]]] = {
    "ddpg": {"noise": (0.2, 0.4, 0.6), "critic_decay": (0.01, 0.0)},
    "sac": {"reward_scale": (0.1, 0.3, 1.0, 3.0, 10.0)},
}
FIXED: Mapping[str, Mapping[str, Any]] = {"HalfCheetah": {"cycle_updates": 100}}
"""Settings of all DDPG runs in a task, found by hand."""

SIZES = (1.0, 0.1, 0.01)
ALONE = [*(Weights(w, 0.0) for w in SIZES), *(Weights(0.0, w) for w in SIZES)]
ALIKE = [Weights(w, w) for w in SIZES]
PAIRS: Mapping[str, Sequence[Weights]] = {
    "hybrid-ddpg": [*starmap(Weights, product(SIZES, SIZES)), *ALONE],
    "hybrid-sac": [*ALIKE, *ALONE],
    "hybrid-ddpg-cosine": [*ALIKE, *ALONE],
}
"""The weights searched of each hybrid, in the order of the searches."""


@dataclass(frozen=True)
class Outcome:
    """What one cell of a tuning sweep reached.

    config     of the searched settings
    area, end  mean over runs of the mean, and of the last tenth, of the normalised return_mean;
               minus infinity where a run did not reach its end
    runs       how many did, or diverged, as they would again
    sweep      the sweep's id
    """

    environment: str
    algorithm: str
    weights: Weights
    config: Mapping[str, Any]
    area: float
    end: float
    runs: int
    sweep: str


def baseline(algorithm: str) -> str:
    """The algorithm whose settings it takes: what it extends, or itself."""
    return catalogue.baseline(algorithm) or algorithm


def tasks(algorithm: str) -> list[str]:
    """The tasks in which an algorithm, or what it extends, is tuned."""
    return SOFT_TASKS if baseline(algorithm) == "sac" else list(TIMESTEPS)


def settings_sweep(
    environment: str, algorithm: str, known: Collection[Outcome] = ()
) -> dict[str, Any] | None:
    """Round 1: an algorithm without gradient terms, with each of its settings.

    None where every outcome is known; else without the cells whose outcome is.
    """
    grid = SETTINGS[algorithm]
    configs = [
        {**_fixed(environment, algorithm), **dict(zip(grid, values, strict=True))}
        for values in product(*grid.values())
    ]
    return _sweep(
        f"tuning: settings of {algorithm}, {environment}",
        environment,
        [
            {"name": algorithm, "config": config}
            for config in configs
            if not _is_known(known, environment, algorithm, NO_WEIGHTS, config)
        ],
    )


def weights_sweep(
    environment: str, hybrid: str, config: Mapping[str, Any], known: Collection[Outcome] = ()
) -> dict[str, Any] | None:
    """Round 2: a hybrid, with each pair of weights, under the best settings of what it extends.

    None where every outcome is known; else without the cells whose outcome is.
    """
    pairs = [
        weights._asdict()
        for weights in PAIRS[hybrid]
        if not _is_known(known, environment, hybrid, weights, config)
    ]
    return _sweep(
        f"tuning: weights of {hybrid}, {environment}",
        environment,
        [{"name": hybrid, "weights": pairs, "config": dict(config)}] if pairs else [],
    )


def _is_known(
    known: Collection[Outcome],
    environment: str,
    algorithm: str,
    weights: Weights,
    config: Mapping[str, Any],
) -> bool:
    cell = (environment, algorithm, weights, dict(config))
    return any(
        row.runs == len(SEEDS)
        and cell == (row.environment, row.algorithm, row.weights, dict(row.config))
        for row in known
    )


def _fixed(environment: str, algorithm: str) -> Mapping[str, Any]:
    return FIXED.get(environment, {}) if algorithm == "ddpg" else {}


def _sweep(name: str, environment: str, algorithms: list[dict[str, Any]]) -> dict[str, Any] | None:
    if not algorithms:
        return None
    return {
        "name": name,
        "algorithms": algorithms,
        "environments": [environment],
        "seeds": SEEDS,
        "timesteps": TIMESTEPS[environment],
    }


def outcomes(curves: CurvesAnswer) -> list[Outcome]:
    """What each cell of a sweep reached, from its normalised `return_mean`, seeds left out."""
    return [
        Outcome(
            panel.environment,
            curve.algorithm,
            curve.weights.pair,
            _searched(panel.environment, curve.algorithm, curve.config),
            *_reached(curve, TIMESTEPS[panel.environment]),
            _decided(curve),
            curves.sweep,
        )
        for panel in curves.panels
        for curve in panel.curves
    ]


def _reached(curve: CurveAnswer, timesteps: int) -> tuple[float, float]:
    """Area and end of a curve; minus infinity for one that is not to be chosen."""
    means = np.array(curve.mean, np.float64)  # None becomes NaN
    if curve.unfinished or not np.isfinite(means).all() or not means.size:
        return -np.inf, -np.inf
    return float(means.mean()), final_score(np.array(curve.x), means, timesteps)


def _decided(curve: CurveAnswer) -> int:
    undecided = sum(curve.unfinished.values()) - curve.unfinished.get("diverged", 0)
    return curve.runs - undecided


def _searched(environment: str, algorithm: str, config: Mapping[str, Any]) -> dict[str, Any]:
    """The settings that round 1 gave to its runs; the others are the algorithm's defaults."""
    searched = baseline(algorithm)
    return {name: config[name] for name in (*SETTINGS[searched], *_fixed(environment, searched))}


def best(rows: Iterable[Outcome], environment: str, algorithm: str) -> Outcome:
    """The cell of an algorithm with the largest area; raises ValueError where there is none."""
    cells = (row for row in rows if (row.environment, row.algorithm) == (environment, algorithm))
    return max(cells, key=lambda row: row.area)
