"""Catalogue: the algorithms by name.

An installed package adds an algorithm through the entry-point group `d3pg.algorithms`, with the
algorithm's name and `module:object` of an `Algorithm`. The project's own are listed here; their
code is loaded on first use.
"""

import ast
import tomllib
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from difflib import get_close_matches
from functools import cache
from importlib.metadata import entry_points
from importlib.util import find_spec
from pathlib import Path
from pkgutil import resolve_name
from typing import Any

GROUP = "d3pg.algorithms"
CORE_SECONDS: Mapping[str, Mapping[str, float]] = tomllib.loads(
    Path(__file__).with_name("costs.toml").read_text(encoding="utf-8")
)
"""Core-seconds of 1,000 timesteps, by learner and task."""


@dataclass(frozen=True)
class Algorithm:
    """The description of an algorithm, available without loading its code.

    Attributes:
        name: the name that users write.
        summary: a summary in one line.
        builder: "module:function" of `(environment, seeds, weights, timesteps, config) -> Learner`.
        config: "module:class" of its settings, a frozen pydantic dataclass.
        uses_weights: whether it uses the weights w1 and w2.
        needs_reward_gradient: whether it refuses tasks whose reward is not differentiable.
        memory: "module:function" of `(environment, weights, timesteps, config) -> bytes` that a run
            fills; empty if that is negligible.
        can_go_on: whether a longer run equals a shorter one, bit for bit, up to the shorter one's
            end, so that it can continue from there; False where a step size is annealed.
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

    def description(self) -> str:
        """The docstring of the module that builds its learner; the module is not run."""
        return _docstring_of(self.builder.partition(":")[0])

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


@cache
def _docstring_of(module: str) -> str:
    """The docstring of a module, which is not run; empty if it has no source."""
    found = find_spec(module)
    if found is None or found.origin is None:
        return ""
    source = Path(found.origin).read_text(encoding="utf-8")
    return ast.get_docstring(ast.parse(source)) or ""


def hybrid(
    baseline: Algorithm,
    name: str,
    summary: str,
    builder: str = "",
) -> Algorithm:
    """A baseline that also matches gradients; `builder` if it is not the baseline's."""
    return replace(
        baseline,
        name=name,
        summary=summary,
        builder=builder or baseline.builder,
        uses_weights=True,
        extends=baseline.name,
        core_seconds=CORE_SECONDS[name],
    )


DDPG = Algorithm(
    "ddpg",
    "Deep deterministic policy gradients with parameter noise",
    builder="algorithms.actor_critic.ddpg:build",
    config="algorithms.settings:DDPGConfig",
    memory="algorithms.memory:of_replay",
    can_go_on=True,
    core_seconds=CORE_SECONDS["ddpg"],
)
TD3 = Algorithm(
    "td3",
    "Twin delayed deterministic policy gradients",
    builder="algorithms.actor_critic.td3:build",
    config="algorithms.settings:TD3Config",
    memory="algorithms.memory:of_replay",
    can_go_on=True,
    core_seconds=CORE_SECONDS["td3"],
)
SAC = Algorithm(
    "sac",
    "Soft actor-critic with a fixed temperature",
    builder="algorithms.actor_critic.sac:build",
    config="algorithms.settings:SACConfig",
    memory="algorithms.memory:of_replay",
    can_go_on=True,
    core_seconds=CORE_SECONDS["sac"],
)

_ALL = (
    DDPG,
    hybrid(
        DDPG,
        "hybrid-ddpg",
        "DDPG whose critic also fits the simulator's gradients (L2)",
    ),
    hybrid(
        DDPG,
        "hybrid-ddpg-cosine",
        "DDPG whose critic also fits the direction of the simulator's gradients",
        builder="algorithms.actor_critic.ddpg:build_cosine",
    ),
    hybrid(
        DDPG,
        "hybrid-ddpg-robust",
        "DDPG whose critic also fits the simulator's gradients, within bounds",
        builder="algorithms.actor_critic.ddpg:build_robust",
    ),
    TD3,
    hybrid(
        TD3,
        "hybrid-td3",
        "TD3 whose critics also fit the simulator's gradients, within bounds",
    ),
    SAC,
    hybrid(
        SAC,
        "hybrid-sac",
        "Soft actor-critic whose critics also fit the simulator's gradients (L2)",
    ),
    Algorithm(
        "gd",
        "Gradient ascent of the actor on whole episodes' returns, through the simulator",
        builder="algorithms.ascent.gd:build",
        config="algorithms.settings:GDConfig",
        needs_reward_gradient=True,
        memory="algorithms.memory:of_episodes",
        core_seconds=CORE_SECONDS["gd"],
    ),
    Algorithm(
        "shac",
        "Short-horizon actor-critic: windows through the simulator, a value at their end",
        builder="algorithms.ascent.shac:build",
        config="algorithms.settings:SHACConfig",
        memory="algorithms.memory:of_linearized_window",
        core_seconds=CORE_SECONDS["shac"],
    ),
    Algorithm(
        "ppo",
        "Proximal policy optimisation, from environment steps alone",
        builder="algorithms.policy_gradient.ppo:build",
        config="algorithms.settings:PPOConfig",
        memory="algorithms.memory:of_window",
        core_seconds=CORE_SECONDS["ppo"],
    ),
    Algorithm(
        "mpc",
        "Model-predictive control: iLQR with control limits in a receding horizon",
        builder="algorithms.planning.mpc:build",
        config="algorithms.settings:MPCConfig",
        needs_reward_gradient=True,
        memory="algorithms.memory:of_plan",
        core_seconds=CORE_SECONDS["mpc"],
    ),
)
OWN = {algorithm.name: algorithm for algorithm in _ALL}


def names() -> list[str]:
    """Every algorithm's name: the project's own, then those of installed packages."""
    others = {entry.name for entry in entry_points(group=GROUP)} - set(OWN)
    return [*OWN, *sorted(others)]


def find(name: str | Algorithm) -> Algorithm:
    """The algorithm of that name; an `Algorithm` is returned as it is.

    Raises:
        ValueError: for an unknown name; the message names the nearest known one.
    """
    if isinstance(name, Algorithm):
        return name
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
