"""The paper's evaluation: three sweeps, each with the figures that it holds.

Settings and timesteps are the presets' (algorithms.presets). Seeds 0 ... n - 1 took no part in
choosing them (service.paper.tuning).
"""

from collections.abc import Mapping
from typing import Any

from service.analysis.figures.paper_figure import FigureNumber
from service.paper.tuning import SOFT_TASKS

SEEDS = 16

TASKS = [
    "CartPole",
    "CartPoleSwingUp",
    "Pendulum",
    "MountainCar",
    "Acrobot",
    "RollingDie",
    "HalfCheetah",
]
"""Section 5.2, in the order of table 1."""

SMOOTH_TASKS = [task for task in TASKS if task != "Acrobot"]
"""Acrobot's reward is a constant until the end: gradient descent and MPC have nothing to go by."""

CRITIC: Mapping[str, Any] = {
    "name": "paper: the critic of the mass point",
    "algorithms": [
        {"name": "ddpg"},
        {
            "name": "hybrid-ddpg",
            "weights": [{"w1": 0, "w2": 1}, {"w1": 1, "w2": 0}, {"w1": 1, "w2": 1}],
        },
    ],
    "environments": ["MassPoint"],
    "timesteps": 75 * 800,
    "priority": 1,
}
"""Section 3.3: 75 epochs of 800 timesteps."""

COMPARISON: Mapping[str, Any] = {
    "name": "paper: all methods in all tasks",
    "algorithms": [
        {"name": "ddpg"},
        {"name": "hybrid-ddpg"},
        {"name": "gd", "environments": SMOOTH_TASKS},
        {"name": "mpc", "environments": SMOOTH_TASKS},
        {"name": "hybrid-ddpg-cosine"},
    ],
    "environments": TASKS,
    "priority": 2,
}
"""Sections 5.2 and A.1. The paper leaves MPC out of CartPole, Pendulum and MountainCar."""

SOFT: Mapping[str, Any] = {
    "name": "paper: soft actor-critic",
    "algorithms": [{"name": "sac"}, {"name": "hybrid-sac"}],
    "environments": SOFT_TASKS,
}
"""Section A.2."""

FIGURES: Mapping[str, tuple[FigureNumber, ...]] = {
    CRITIC["name"]: ("2",),
    COMPARISON["name"]: ("3", "4", "5"),
    SOFT["name"]: ("6",),
}


def evaluation(seeds: int = SEEDS, scale: float = 1.0) -> list[dict[str, Any]]:
    """The sweeps to submit, for so many seeds and that share of the timesteps."""
    return [{**sweep, "seeds": seeds, "scale": scale} for sweep in (COMPARISON, CRITIC, SOFT)]
