"""How the presets were chosen: searches over the same number of cells for every learner.

1. The settings: six cells a task for each learner that has one pair of weights, or none, on all
   tasks (`SPACES`): the learners without gradient terms, and the hybrids with bounded losses.
2. The weights: six pairs (w1, w2) a task for each hybrid of the paper's losses, under the settings
   that round 1 found best for the algorithm that it extends (`PAIRS`). So these have twelve cells,
   six of them from what they extend.

MPC, which does not learn, is not searched.

What is best has the largest mean, over runs, of the area under the normalised learning curve (the
mean of its return_mean); of equals the first. A cell of which a run did not reach its end is not
chosen. A search of the service (service/model/inquiry/search.py) trains them; its only rung has all
cells, so that a cell costs the same number of seeds and timesteps for every learner, and its seeds
count in no question. A search whose outcomes are all known is not made again: tuning.csv keeps them
independently of the database and the machine that found them.
"""

import json
from collections.abc import Collection, Iterable, Mapping, Sequence
from dataclasses import dataclass
from itertools import product
from typing import Any

import numpy as np

import physics
from algorithms import catalogue
from service.analysis.statistics.score import final_score
from service.api.schemas.curves_answer import CurveAnswer, CurvesAnswer
from workers.messages.run_spec import NO_WEIGHTS, Weights

SEEDS = [100, 101, 102, 103]

TIMESTEPS = {
    "CartPole": 30_000,
    "CartPoleSwingUp": 60_000,
    "Pendulum": 20_000,
    "MountainCar": 20_000,
    "Acrobot": 40_000,
    "RollingDie": 30_000,
    "HalfCheetah": 60_000,
    "BallWall": 30_000,
    "MassPoint": 12_000,
}
"""Long enough to tell good settings from bad ones; the evaluation is longer."""

AS_ON: Mapping[str, str] = {"Hopper": "HalfCheetah", "Walker2d": "HalfCheetah"}
"""Tasks that are not searched, which would take half of the whole search's time: every learner has
there what was best on another task."""


@dataclass(frozen=True)
class Space:
    """The settings searched for one learner.

    Attributes:
        algorithm: its name.
        configs: settings to try, in the order of the search.
        fixed: settings of every cell on a task, found by hand.
        weights: of a hybrid, in every cell.
    """

    algorithm: str
    configs: Sequence[Mapping[str, Any]]
    fixed: Mapping[str, Mapping[str, Any]]
    weights: Weights = NO_WEIGHTS

    def on(self, environment: str) -> list[dict[str, Any]]:
        """The settings of its cells on a task."""
        return [{**self.fixed.get(environment, {}), **config} for config in self.configs]

    def tasks(self) -> list[str]:
        """The tasks that its algorithm can be trained on."""
        if not catalogue.find(self.algorithm).needs_reward_gradient:
            return list(TIMESTEPS)
        return [task for task in TIMESTEPS if physics.make(task).reward_is_differentiable]


def grid(**values: Sequence[Any]) -> list[dict[str, Any]]:
    """Each combination of the values of some settings."""
    return [dict(zip(values, chosen, strict=True)) for chosen in product(*values.values())]


UPDATES_A_STEP = {"HalfCheetah": {"cycle_updates": 100}}
DETERMINISTIC = {"critic_decay": (0.0,), "noise": (0.3, 0.6), "actor_rate": (1e-4, 3e-4, 1e-3)}
"""No weight decay: of six cells with and without it, DDPG had its best without on eight of eleven
tasks, and lost at most 0.02 on the others."""
ONE_PAIR = Weights(1.0, 0.1)
"""Of the hybrids with bounded losses, on all tasks; results/trials.csv has what was tried."""
STARTS = (1_000, 5_000)
"""Uniform actions at the beginning of TD3 and its hybrid. Their first search, whose rows tuning.csv
keeps, had none: it tried more noises instead, of which the useful are left."""
TWIN = [
    {"uniform_steps": start, "noise": noise, "actor_rate": rate}
    for start in STARTS
    for noise, rate in ((0.3, 1e-3), (0.3, 1e-4), (0.6, 1e-4))
]
EVERY_SECOND = {"match_every": 2}
"""Of the hybrids with bounded losses: all but a few hundredths of the gain of matching at every
update, at about half the time that it takes."""
BOLD = {"critic_rate": 0.005, "noise": 1.0}
SPACES: Mapping[str, Space] = {
    "ddpg": Space("ddpg", grid(**DETERMINISTIC), UPDATES_A_STEP),
    "hybrid-ddpg-robust": Space(
        "hybrid-ddpg-robust",
        [{**EVERY_SECOND, **cell} for cell in grid(**DETERMINISTIC)],
        UPDATES_A_STEP,
        ONE_PAIR,
    ),
    "td3": Space("td3", TWIN, {}),
    "hybrid-td3": Space("hybrid-td3", [{**EVERY_SECOND, **cell} for cell in TWIN], {}, ONE_PAIR),
    "ppo": Space(
        "ppo",
        [
            {"environments": environments, "window": window, "rate": rate}
            for environments, window in ((4, 128), (8, 256))
            for rate in (3e-4, 1e-3, 3e-3)
        ],
        {},
    ),
    "shac": Space(
        "shac",
        [
            {"environments": n, "window": window, "actor_rate": rate, **critic}
            for n, window, rate, critic in (
                (8, 16, 0.005, {"critic_rate": 0.002, "noise": 0.37}),
                (8, 16, 0.005, BOLD),
                (4, 32, 0.01, {"critic_rate": 0.002, "noise": 0.37}),
                (4, 32, 0.002, {"critic_rate": 0.002, "noise": 0.37}),
                (16, 32, 0.01, {"critic_rate": 0.002, "noise": 0.37}),
                (16, 32, 0.005, BOLD),
            )
        ],
        {},
    ),
    "sac": Space(
        "sac", grid(temperature=("fixed",), reward_scale=(0.3, 1.0, 3.0, 10.0, 30.0, 100.0)), {}
    ),
    "gd": Space("gd", grid(rate=(0.0001, 0.0003, 0.001, 0.003, 0.01, 0.03)), {}),
    "sac with learned temperature": Space(
        "sac", grid(temperature=("learned",), rate=(3e-4, 1e-3, 3e-3), tau=(0.005, 0.01)), {}
    ),
}
"""What is searched in round 1, by the name of the row in tables."""

L2_PAIRS = [
    Weights(1.0, 0.0),
    Weights(0.1, 0.0),
    Weights(1.0, 1.0),
    Weights(0.1, 0.1),
    Weights(0.01, 0.01),
    Weights(1.0, 0.01),
]
COSINE_PAIRS = [
    Weights(0.01, 0.01),
    Weights(0.1, 0.1),
    Weights(1.0, 1.0),
    Weights(0.01, 0.0),
    Weights(0.0, 0.01),
    Weights(0.1, 0.0),
]
PAIRS: Mapping[str, Sequence[Weights]] = {
    "hybrid-ddpg": L2_PAIRS,
    "hybrid-ddpg-cosine": COSINE_PAIRS,
    "hybrid-sac": L2_PAIRS,
}
"""The weights searched of each hybrid, in the order of the searches."""


Cell = tuple[str, str, Weights, str]
"""A task, an algorithm, its weights, its settings as text."""


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

    @property
    def cell(self) -> Cell:
        """The key of a cell, which is in a table once."""
        return cell_of(self.environment, self.algorithm, self.weights, self.config)


def cell_of(environment: str, algorithm: str, weights: Weights, config: Mapping[str, Any]) -> Cell:
    """Return the key of a cell."""
    return environment, algorithm, weights, json.dumps(config, sort_keys=True)


def space_of(algorithm: str) -> Space:
    """The source of the settings of an algorithm, or of what it extends."""
    return SPACES.get(algorithm) or SPACES[catalogue.baseline(algorithm)]


def settings_search(
    environment: str, name: str, known: Collection[Outcome] = ()
) -> dict[str, Any] | None:
    """Round 1: a learner with each of its settings, and its weights where it has any.

    None where every outcome is known.
    """
    space = SPACES[name]
    cells = [(space.weights, config) for config in space.on(environment)]
    name = f"tuning: settings of {name}, {environment}"
    return _search(name, environment, space.algorithm, cells, known)


def weights_search(
    environment: str, hybrid: str, config: Mapping[str, Any], known: Collection[Outcome] = ()
) -> dict[str, Any] | None:
    """Round 2: a hybrid, with each pair of weights, under the best settings of what it extends.

    None where every outcome is known.
    """
    cells = [(weights, config) for weights in PAIRS[hybrid]]
    name = f"tuning: weights of {hybrid}, {environment}"
    return _search(name, environment, hybrid, cells, known)


def _search(
    name: str,
    environment: str,
    algorithm: str,
    cells: Sequence[tuple[Weights, Mapping[str, Any]]],
    known: Collection[Outcome],
) -> dict[str, Any] | None:
    """Return the request of a search with one rung; None if it would find nothing new."""
    there = {row.cell for row in known if row.runs == len(SEEDS)}
    wanted = {cell_of(environment, algorithm, *cell) for cell in cells}
    if wanted <= there:
        return None
    timesteps = TIMESTEPS[environment]
    return {
        "name": name,
        "algorithms": [
            {"name": algorithm, "weights": weights._asdict(), "config": dict(config)}
            for weights, config in cells
        ],
        "environments": [environment],
        "seeds": SEEDS,
        "timesteps": timesteps,
        "search": {
            "budget": len(cells) * len(SEEDS) * timesteps,
            "reduction": len(cells),
            "score": "area",
        },
    }


def outcomes(curves: CurvesAnswer) -> list[Outcome]:
    """What each cell of a sweep reached, from its normalised `return_mean`, seeds left out."""
    return [
        Outcome(
            panel.environment,
            curve.algorithm,
            curve.weights.pair,
            _searched(panel.environment, curve),
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


def _searched(environment: str, curve: CurveAnswer) -> dict[str, Any]:
    """The settings that round 1 gave to its runs; the others are the algorithm's defaults."""
    algorithm = space_of(curve.algorithm).algorithm
    return next(
        config
        for space in SPACES.values()
        for config in space.on(environment)
        if space.algorithm == algorithm and config.items() <= curve.config.items()
    )


def best(rows: Iterable[Outcome], environment: str, name: str) -> Outcome:
    """The cell of a hybrid or of a space with the largest area; ValueError where there is none."""
    return max(searched_cells(rows, environment, name), key=lambda row: row.area)


def searched_cells(rows: Iterable[Outcome], environment: str, name: str) -> list[Outcome]:
    """The cells of a hybrid or of a space on a task; rows of an earlier space are none of them."""
    space = space_of(name)
    algorithm = name if name in PAIRS else space.algorithm
    configs = space.on(environment)
    return [
        row
        for row in rows
        if (row.environment, row.algorithm) == (environment, algorithm) and row.config in configs
    ]


def all_searches() -> list[tuple[str, str]]:
    """The name and the task of every search."""
    settings = [(name, task) for name, space in SPACES.items() for task in space.tasks()]
    return settings + [(name, task) for name in PAIRS for task in TIMESTEPS]


def is_whole(rows: Iterable[Outcome], environment: str, name: str) -> bool:
    """Whether every cell of a hybrid or of a space has an outcome on a task."""
    rows = [row for row in rows if row.runs == len(SEEDS)]
    if name in PAIRS:
        known = {row.weights for row in searched_cells(rows, environment, name)}
        return known >= set(PAIRS[name])
    return settings_search(environment, name, rows) is None
