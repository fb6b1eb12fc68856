"""Presets: the settings the evaluation uses, per algorithm and task.

A submission that names no setting gets these; the settings that it names replace them. A task
without chosen settings, such as one of your own, has those of "other": a hybrid matches gradients
there too. presets.toml has the settings that a search chose, and docs/presets.md explains how.
"""

import tomllib
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from algorithms import catalogue
from physics.parameter import name_of

NO_WEIGHTS = (0.0, 0.0)
SMALLEST_WEIGHT, LARGEST_WEIGHT = 1e-30, 1e30
"""Limits of weights other than 0: beyond, they are 0 or infinite in float32."""
USUAL_TIMESTEPS = 40_000

CHOSEN: Mapping[str, Mapping[str, Mapping[str, Any]]] = tomllib.loads(
    Path(__file__).with_name("presets.toml").read_text(encoding="utf-8")
)
"""By learner or form of a learner: "settings" and "weights" by task."""


@dataclass(frozen=True)
class Preset:
    """The settings of one algorithm on one task.

    Attributes:
        weights: (w1, w2), the weights of the action and state gradient terms.
        timesteps: environment steps of a run.
        config: settings other than the algorithm's defaults.
    """

    weights: tuple[float, float] = NO_WEIGHTS
    timesteps: int = USUAL_TIMESTEPS
    config: Mapping[str, Any] = field(default_factory=dict)


TIMESTEPS = {
    "MassPoint": 12_000,
    "CartPole": 60_000,
    "CartPoleSwingUp": 160_000,
    "Pendulum": 20_000,
    "MountainCar": 40_000,
    "Acrobot": 80_000,
    "RollingDie": 60_000,
    "HalfCheetah": 200_000,
    "Hopper": 200_000,
    "Walker2d": 200_000,
    "BallWall": 60_000,
}
"""Timesteps of the learners with a value function: enough for ddpg to converge."""

ASCENT_TIMESTEPS = {"MassPoint": 12_000}
"""Timesteps of gd, which stops at a plateau."""


def planned(horizon: int, timesteps: int, iterations: int = 1) -> Preset:
    """A preset of mpc, with more timesteps than an episode takes: all are planned to their end."""
    return Preset(timesteps=timesteps, config={"horizon": horizon, "iterations": iterations})


PLANS = {
    "MassPoint": planned(horizon=60, timesteps=120_000),
    "CartPole": planned(horizon=50, timesteps=100_000),
    "CartPoleSwingUp": planned(horizon=100, iterations=3, timesteps=1_488_000),
    "Pendulum": planned(horizon=30, timesteps=64_000),
    "MountainCar": planned(horizon=100, timesteps=168_000),
    "RollingDie": planned(horizon=100, timesteps=112_000),
    "HalfCheetah": planned(horizon=30, iterations=12, timesteps=736_000),
    "Hopper": planned(horizon=60, timesteps=1_600_000),
    "Walker2d": planned(horizon=60, timesteps=1_600_000),
    "BallWall": planned(horizon=60, timesteps=112_000),
}
"""Presets of mpc, chosen by hand."""


@dataclass(frozen=True)
class Form:
    """A form of a learner, and of its hybrids, with settings of its own in presets.toml.

    Attributes:
        name: the name in tables.
        stated: the settings that define a run of this form.
        row: its name in presets.toml.
    """

    name: str
    stated: Mapping[str, Any]
    row: str


FORMS: Mapping[str, tuple[Form, ...]] = {
    "sac": (
        Form("learned temperature", {"temperature": "learned"}, "sac with learned temperature"),
    ),
}


def preset(algorithm: str, environment: str) -> Preset:
    """The preset of an algorithm on a task, also on a task without chosen settings.

    Values of the task's parameters, as in `Pendulum(gravity=9.81)`, are ignored. A hybrid has its
    baseline's timesteps, and its baseline's settings unless it has its own.
    """
    task = name_of(environment)
    if algorithm == "mpc":
        return PLANS.get(task, Preset())
    own = CHOSEN.get(algorithm, {})
    owner = algorithm if "settings" in own else catalogue.baseline(algorithm)
    if owner not in CHOSEN:
        return Preset()
    lengths = ASCENT_TIMESTEPS if algorithm == "gd" else TIMESTEPS
    return Preset(
        weights=tuple(_on(own["weights"], task)) if "weights" in own else NO_WEIGHTS,
        timesteps=lengths.get(task, USUAL_TIMESTEPS),
        config=_on(CHOSEN[owner]["settings"], task),
    )


def _on(rows: Mapping[str, Any], task: str) -> Any:
    return rows.get(task, rows["other"])


def form(algorithm: str, config: Mapping[str, Any]) -> Form | None:
    """The form that settings state; None for the algorithm's own."""
    forms = FORMS.get(catalogue.baseline(algorithm) or algorithm, ())
    return next((one for one in forms if one.stated.items() <= config.items()), None)


def completed(algorithm: str, environment: str, config: Mapping[str, Any]) -> dict[str, Any]:
    """The settings of a run: those of the preset, or of the form given, replaced by those given."""
    stated = form(algorithm, config)
    if stated is None:
        return {**preset(algorithm, environment).config, **config}
    return {**_on(CHOSEN[stated.row]["settings"], name_of(environment)), **config}
