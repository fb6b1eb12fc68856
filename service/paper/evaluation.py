"""The evaluation: the paper's comparison, and the learners of today beside it, as sweeps.

Settings and timesteps are the presets' (algorithms.presets). Seeds 0 ... n - 1 were not used to
choose them (service.paper.search). No run belongs to two sweeps: figure 7, of all learners in ten
tasks, takes what the paper's figures show already from the sweeps of those.
"""

from collections.abc import Mapping
from typing import Any

from algorithms.presets import form
from service.analysis.figures.paper_figure import FigureNumber

SEEDS = 32
"""Of the paper's comparison."""

FEWER_SEEDS = 16
"""Of every other sweep: most of their learners cost two to four times what ddpg costs."""

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
"""Acrobot's reward is constant until the end: gradient descent and MPC have no gradient there."""

SOFT_TASKS = ["CartPole", "CartPoleSwingUp", "Pendulum", "MountainCar", "RollingDie"]
"""The five tasks of figure 6 (appendix A.2)."""

MORE_TASKS = ["Hopper", "Walker2d", "BallWall"]
"""Tasks that the paper does not have."""

COMPARISON: Mapping[str, Any] = {
    "name": "paper: all methods in all tasks",
    "algorithms": [
        {"name": "ddpg"},
        {"name": "hybrid-ddpg-robust"},
        {"name": "hybrid-ddpg"},
        {"name": "hybrid-ddpg-cosine"},
        {"name": "gd", "environments": SMOOTH_TASKS},
        {"name": "mpc", "environments": SMOOTH_TASKS},
    ],
    "environments": TASKS,
    "seeds": SEEDS,
}
"""Sections 5.2 and A.1, and the robust hybrid, which the paper does not have.

The paper leaves MPC out of CartPole, Pendulum and MountainCar.
"""

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
    "seeds": FEWER_SEEDS,
}
"""Section 3.3: 75 epochs of 800 timesteps."""

TWIN: Mapping[str, Any] = {
    "name": "today: twin critics",
    "algorithms": [{"name": "td3"}, {"name": "hybrid-td3"}],
    "environments": TASKS,
    "seeds": FEWER_SEEDS,
}

MORE_TWIN: Mapping[str, Any] = {
    **TWIN,
    "name": "today: twin critics in three more tasks",
    "environments": MORE_TASKS,
}

ON_POLICY: Mapping[str, Any] = {
    "name": "today: learning on policy",
    "algorithms": [{"name": "ppo"}, {"name": "shac"}],
    "environments": [*TASKS, *MORE_TASKS],
    "seeds": FEWER_SEEDS,
}

MORE: Mapping[str, Any] = {
    "name": "today: the comparison in three more tasks",
    "algorithms": [
        {key: value for key, value in algorithm.items() if key != "environments"}
        for algorithm in COMPARISON["algorithms"]
    ],
    "environments": MORE_TASKS,
    "seeds": FEWER_SEEDS,
}

SOFT: Mapping[str, Any] = {
    "name": "paper: soft actor-critic",
    "algorithms": [{"name": "sac"}, {"name": "hybrid-sac"}],
    "environments": SOFT_TASKS,
    "seeds": FEWER_SEEDS,
}
"""Section A.2."""

OTHER_SOFT: Mapping[str, Any] = {
    **SOFT,
    "name": "today: soft actor-critic in the paper's other tasks",
    "environments": [task for task in TASKS if task not in SOFT_TASKS],
}

MORE_SOFT: Mapping[str, Any] = {
    **SOFT,
    "name": "today: soft actor-critic in three more tasks",
    "environments": MORE_TASKS,
}

LEARNED: Mapping[str, Any] = {
    "name": "today: soft actor-critic with a learned temperature",
    "algorithms": [
        {
            "name": "sac",
            "label": "sac with learned temperature",
            "config": {"temperature": "learned"},
        },
    ],
    "environments": TASKS,
    "seeds": FEWER_SEEDS,
}

MORE_LEARNED: Mapping[str, Any] = {
    **LEARNED,
    "name": "today: a learned temperature in three more tasks",
    "environments": MORE_TASKS,
}

SWEEPS = (
    *(COMPARISON, CRITIC, TWIN, MORE_TWIN, ON_POLICY, MORE),
    *(SOFT, OTHER_SOFT, MORE_SOFT, LEARNED, MORE_LEARNED),
)
"""In order of importance: a partial evaluation has the paper's comparison first. None takes more
than a few core-hours: results are kept by the sweep (service.paper.former)."""

FIGURES: Mapping[str, tuple[FigureNumber, ...]] = {
    COMPARISON["name"]: ("3", "4", "5"),
    CRITIC["name"]: ("2",),
    SOFT["name"]: ("6",),
}
"""The figures that the service draws, by the sweep that it draws them from."""


def evaluation(seeds: int = SEEDS, scale: float = 1.0) -> list[dict[str, Any]]:
    """The sweeps to submit, each for at most so many seeds and for that share of the timesteps."""
    return [
        {**sweep, "seeds": min(seeds, sweep["seeds"]), "scale": scale, "priority": -place}
        for place, sweep in enumerate(SWEEPS)
    ]


def row(algorithm: str, config: Mapping[str, Any]) -> str:
    """The name of a learner in files and figures: its algorithm, and its form if it has one."""
    stated = form(algorithm, config)
    return f"{algorithm} with {stated.name}" if stated else algorithm
