"""Catalogue: the algorithms by name.

An installed package adds an algorithm through the entry-point group `d3pg.algorithms`, with the
algorithm's name and `module:object` of an `Algorithm`. The project's own are listed here; their
code is loaded on first use.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from difflib import get_close_matches
from importlib.metadata import entry_points
from pkgutil import resolve_name
from typing import Any

GROUP = "d3pg.algorithms"


@dataclass(frozen=True)
class Algorithm:
    """The description of an algorithm, available without loading its code.

    Attributes:
        name: as users write it.
        summary: one line.
        builder: "module:function" of `(environment, seeds, weights, timesteps, config) -> Learner`.
        config: "module:class" of its settings, a frozen pydantic dataclass.
        uses_weights: whether it uses the weights w1 and w2.
        needs_reward_gradient: whether it refuses tasks whose reward is not differentiable.
        memory: "module:function" of `(environment, weights, timesteps, config) -> bytes` that a run
            fills; empty if that is negligible.
        can_go_on: whether a run of more timesteps has, up to the end of a shorter one, the bits of
            that, so that it can be taken up there; not so where a step size is annealed.
        extends: the algorithm that it equals, bit for bit, with weights (0, 0); empty for none.
        core_seconds: core-seconds of 1,000 timesteps under the preset, by task; used for estimates
            until runs have finished.
    """

    name: str
    summary: str
    builder: str
    config: str
    uses_weights: bool = False
    needs_reward_gradient: bool = False
    memory: str = ""
    can_go_on: bool = False
    extends: str = ""
    core_seconds: Mapping[str, float] = field(default_factory=dict)

    def config_class(self) -> type[Any]:
        """The class of its settings."""
        loaded: type[Any] = resolve_name(self.config)
        return loaded

    def load(self) -> Callable[..., Any]:
        """The function that builds its learner."""
        loaded: Callable[..., Any] = resolve_name(self.builder)
        return loaded

    def load_memory(self) -> Callable[..., int] | None:
        """The function that says how much memory a run fills, if there is one."""
        loaded: Callable[..., int] | None = resolve_name(self.memory) if self.memory else None
        return loaded


def hybrid(
    baseline: Algorithm,
    name: str,
    summary: str,
    *,
    core_seconds: Mapping[str, float],
    builder: str = "",
) -> Algorithm:
    """A baseline that also matches gradients; `builder` where it is not the baseline's."""
    return replace(
        baseline,
        name=name,
        summary=summary,
        builder=builder or baseline.builder,
        uses_weights=True,
        extends=baseline.name,
        core_seconds=core_seconds,
    )


# Core-seconds (w1 = 1 where a hybrid has no preset): process time, evaluation included, between
# timesteps 1,200 and 2,800 of one run, of gd up to 12,000, of shac and ppo over 4,000 and of mpc up
# to 60,000, on one thread of a shared AMD EPYC core in November 2026. Good to a factor of two or so
# elsewhere. What ends before its timesteps, as gd on a plateau and mpc with its episode, costs less
# than they say.
DDPG = Algorithm(
    "ddpg",
    "Deep deterministic policy gradients with parameter noise",
    builder="algorithms.actor_critic.ddpg:build",
    config="algorithms.settings:DDPGConfig",
    memory="algorithms.memory:of_replay",
    can_go_on=True,
    core_seconds={
        "MassPoint": 0.11, "CartPole": 0.09, "CartPoleSwingUp": 0.1, "Pendulum": 0.08,
        "MountainCar": 0.1, "Acrobot": 0.1, "RollingDie": 0.08, "HalfCheetah": 0.11,
        "Hopper": 0.12, "Walker2d": 0.15, "BallWall": 0.09,
    },
)  # fmt: skip
TD3 = Algorithm(
    "td3",
    "Twin delayed deterministic policy gradients",
    builder="algorithms.actor_critic.td3:build",
    config="algorithms.settings:TD3Config",
    memory="algorithms.memory:of_replay",
    can_go_on=True,
    core_seconds={
        "MassPoint": 0.15, "CartPole": 0.15, "CartPoleSwingUp": 0.15, "Pendulum": 0.15,
        "MountainCar": 0.15, "Acrobot": 0.16, "RollingDie": 0.16, "HalfCheetah": 0.18,
        "Hopper": 0.18, "Walker2d": 0.2, "BallWall": 0.16,
    },
)  # fmt: skip
SAC = Algorithm(
    "sac",
    "Soft actor-critic with a fixed temperature",
    builder="algorithms.actor_critic.sac:build",
    config="algorithms.settings:SACConfig",
    memory="algorithms.memory:of_replay",
    can_go_on=True,
    core_seconds={
        "MassPoint": 0.22, "CartPole": 0.22, "CartPoleSwingUp": 0.22, "Pendulum": 0.21,
        "MountainCar": 0.21, "Acrobot": 0.22, "RollingDie": 0.22, "HalfCheetah": 0.25,
        "Hopper": 0.23, "Walker2d": 0.26, "BallWall": 0.22,
    },
)  # fmt: skip

_ALL = (
    DDPG,
    hybrid(
        DDPG,
        "hybrid-ddpg",
        "DDPG whose critic also fits the simulator's gradients (L2)",
        core_seconds={
            "MassPoint": 0.12, "CartPole": 0.15, "CartPoleSwingUp": 0.14, "Pendulum": 0.13,
            "MountainCar": 0.13, "Acrobot": 0.21, "RollingDie": 0.18, "HalfCheetah": 0.18,
            "Hopper": 0.19, "Walker2d": 0.23, "BallWall": 0.14,
        },
    ),
    hybrid(
        DDPG,
        "hybrid-ddpg-cosine",
        "DDPG whose critic also fits the direction of the simulator's gradients",
        builder="algorithms.actor_critic.ddpg:build_cosine",
        core_seconds={
            "MassPoint": 0.14, "CartPole": 0.16, "CartPoleSwingUp": 0.13, "Pendulum": 0.14,
            "MountainCar": 0.13, "Acrobot": 0.14, "RollingDie": 0.13, "HalfCheetah": 0.18,
            "Hopper": 0.19, "Walker2d": 0.23, "BallWall": 0.14,
        },
    ),
    hybrid(
        DDPG,
        "hybrid-ddpg-robust",
        "DDPG whose critic also fits the simulator's gradients, within bounds",
        builder="algorithms.actor_critic.ddpg:build_robust",
        core_seconds={
            "MassPoint": 0.14, "CartPole": 0.16, "CartPoleSwingUp": 0.13, "Pendulum": 0.14,
            "MountainCar": 0.13, "Acrobot": 0.17, "RollingDie": 0.15, "HalfCheetah": 0.18,
            "Hopper": 0.23, "Walker2d": 0.28, "BallWall": 0.13,
        },
    ),
    TD3,
    hybrid(
        TD3,
        "hybrid-td3",
        "TD3 whose critics also fit the simulator's gradients, within bounds",
        core_seconds={
            "MassPoint": 0.25, "CartPole": 0.25, "CartPoleSwingUp": 0.25, "Pendulum": 0.25,
            "MountainCar": 0.25, "Acrobot": 0.27, "RollingDie": 0.27, "HalfCheetah": 0.3,
            "Hopper": 0.32, "Walker2d": 0.35, "BallWall": 0.28,
        },
    ),
    SAC,
    hybrid(
        SAC,
        "hybrid-sac",
        "Soft actor-critic whose critics also fit the simulator's gradients (L2)",
        core_seconds={
            "MassPoint": 0.3, "CartPole": 0.31, "CartPoleSwingUp": 0.31, "Pendulum": 0.31,
            "MountainCar": 0.31, "Acrobot": 0.33, "RollingDie": 0.32, "HalfCheetah": 0.38,
            "Hopper": 0.34, "Walker2d": 0.4, "BallWall": 0.3,
        },
    ),
    Algorithm(
        "gd",
        "Gradient ascent of the actor on whole episodes' returns, through the simulator",
        builder="algorithms.ascent.gd:build",
        config="algorithms.settings:GDConfig",
        needs_reward_gradient=True,
        memory="algorithms.memory:of_episodes",
        core_seconds={
            "MassPoint": 0.034, "CartPole": 0.035, "CartPoleSwingUp": 0.039, "Pendulum": 0.035,
            "MountainCar": 0.036, "RollingDie": 0.04, "HalfCheetah": 0.057,
            "Hopper": 0.05, "Walker2d": 0.05, "BallWall": 0.037,
        },
    ),
    Algorithm(
        "shac",
        "Short-horizon actor-critic: windows through the simulator, a value at their end",
        builder="algorithms.ascent.shac:build",
        config="algorithms.settings:SHACConfig",
        memory="algorithms.memory:of_linearized_window",
        core_seconds={
            "MassPoint": 0.025, "CartPole": 0.023, "CartPoleSwingUp": 0.013, "Pendulum": 0.025,
            "MountainCar": 0.021, "Acrobot": 0.023, "RollingDie": 0.015, "HalfCheetah": 0.034,
            "Hopper": 0.028, "Walker2d": 0.054, "BallWall": 0.023,
        },
    ),
    Algorithm(
        "ppo",
        "Proximal policy optimisation, from environment steps alone",
        builder="algorithms.policy_gradient.ppo:build",
        config="algorithms.settings:PPOConfig",
        memory="algorithms.memory:of_window",
        core_seconds={
            "MassPoint": 0.026, "CartPole": 0.029, "CartPoleSwingUp": 0.017, "Pendulum": 0.029,
            "MountainCar": 0.028, "Acrobot": 0.033, "RollingDie": 0.029, "HalfCheetah": 0.035,
            "Hopper": 0.032, "Walker2d": 0.047, "BallWall": 0.029,
        },
    ),
    Algorithm(
        "mpc",
        "Model-predictive control: iLQR with control limits in a receding horizon",
        builder="algorithms.planning.mpc:build",
        config="algorithms.settings:MPCConfig",
        needs_reward_gradient=True,
        memory="algorithms.memory:of_plan",
        core_seconds={
            "MassPoint": 0.0015, "CartPole": 0.0034, "CartPoleSwingUp": 0.0019, "Pendulum": 0.0058,
            "MountainCar": 0.0026, "RollingDie": 0.0023, "HalfCheetah": 0.01,
            "Hopper": 0.006, "Walker2d": 0.015, "BallWall": 0.0042,
        },
    ),
)  # fmt: skip
OWN = {algorithm.name: algorithm for algorithm in _ALL}


def names() -> list[str]:
    """Every algorithm's name: the project's own, then those of installed packages."""
    others = {entry.name for entry in entry_points(group=GROUP)} - set(OWN)
    return [*OWN, *sorted(others)]


def find(name: str) -> Algorithm:
    """The algorithm of that name.

    Raises:
        ValueError: for an unknown name; it names the nearest known one.
    """
    if name in OWN:
        return OWN[name]
    for entry in entry_points(group=GROUP):
        if entry.name == name:
            algorithm: Algorithm = entry.load()
            return algorithm
    near = get_close_matches(str(name).lower(), names(), n=1, cutoff=0.5)
    hint = f"; did you mean {near[0]!r}?" if near else ""
    raise ValueError(f"unknown algorithm {name!r}{hint} (known: {', '.join(names())})")


def known(name: str) -> Algorithm | None:
    """The algorithm of that name; None for an unknown one, such as one no longer installed."""
    try:
        return find(name)
    except ValueError:
        return None


def baseline(name: str) -> str:
    """The algorithm that this one extends, by name; empty for none and for an unknown name."""
    algorithm = known(name)
    return algorithm.extends if algorithm else ""
