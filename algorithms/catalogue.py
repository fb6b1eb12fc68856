"""Catalogue: the algorithms by name.

An installed package adds one of its own through the entry-point group `d3pg.algorithms`: the name,
and `module:object` of an `Algorithm`. The project's own are listed here; their code is loaded when
one is asked for.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace
from difflib import get_close_matches
from importlib.metadata import entry_points
from pkgutil import resolve_name
from typing import Any

GROUP = "d3pg.algorithms"


@dataclass(frozen=True)
class Algorithm:
    """What is known of an algorithm before its code is loaded.

    Attributes:
        name: as users write it.
        summary: one line.
        builder: "module:function" of `(environment, seeds, weights, timesteps, config) -> Learner`.
        config: "module:class" of its settings, a frozen pydantic dataclass.
        uses_weights: whether w1 and w2 mean something to it.
        needs_reward_gradient: whether it refuses tasks whose reward is not differentiable.
        memory: "module:function" of `(environment, weights, timesteps, config) -> bytes` that a run
            comes to fill; empty where that is next to nothing.
        extends: name of the algorithm that it is, bit for bit, with weights (0, 0); empty for none.
    """

    name: str
    summary: str
    builder: str
    config: str
    uses_weights: bool = False
    needs_reward_gradient: bool = False
    memory: str = ""
    extends: str = ""

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


def hybrid(baseline: Algorithm, name: str, summary: str, builder: str = "") -> Algorithm:
    """A baseline that also matches gradients; `builder` where it is not the baseline's."""
    return replace(
        baseline,
        name=name,
        summary=summary,
        builder=builder or baseline.builder,
        uses_weights=True,
        extends=baseline.name,
    )


DDPG = Algorithm(
    "ddpg",
    "Deep deterministic policy gradients with parameter noise",
    builder="algorithms.actor_critic.ddpg:build",
    config="algorithms.settings:DDPGConfig",
    memory="algorithms.memory:of_replay",
)
SAC = Algorithm(
    "sac",
    "Soft actor-critic with a fixed temperature",
    builder="algorithms.actor_critic.sac:build",
    config="algorithms.settings:SACConfig",
    memory="algorithms.memory:of_replay",
)

_ALL = (
    DDPG,
    hybrid(DDPG, "hybrid-ddpg", "DDPG whose critic also fits the simulator's gradients (L2)"),
    hybrid(
        DDPG,
        "hybrid-ddpg-cosine",
        "DDPG whose critic also fits the direction of the simulator's gradients",
        builder="algorithms.actor_critic.ddpg:build_cosine",
    ),
    SAC,
    hybrid(
        SAC, "hybrid-sac", "Soft actor-critic whose critics also fit the simulator's gradients (L2)"
    ),
    Algorithm(
        "gd",
        "Gradient ascent of the actor on whole episodes' returns, through the simulator",
        builder="algorithms.ascent.learner:build",
        config="algorithms.settings:GDConfig",
        needs_reward_gradient=True,
        memory="algorithms.memory:of_episodes",
    ),
    Algorithm(
        "mpc",
        "Model-predictive control: iLQR with control limits in a receding horizon",
        builder="algorithms.planning.mpc:build",
        config="algorithms.settings:MPCConfig",
        needs_reward_gradient=True,
        memory="algorithms.memory:of_plan",
    ),
)
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


def baseline(name: str) -> str:
    """The algorithm that this one extends, by name; empty for none and for an unknown name."""
    try:
        return find(name).extends
    except ValueError:
        return ""
