"""What the service knows of an environment: its declared constants, never its dynamics."""

from contextlib import suppress
from dataclasses import dataclass, fields
from functools import cache
from typing import TYPE_CHECKING, Self

import physics

if TYPE_CHECKING:
    from physics.environment import Environment


@dataclass(frozen=True)
class EnvironmentFacts:
    """Constants of an environment. `best_return` is max_reward * horizon."""

    name: str
    version: int
    state_size: int
    action_size: int
    feature_size: int
    horizon: int
    max_reward: float
    reward_is_differentiable: bool
    regimes: tuple[str, ...]
    """The kinds of step that its gradient audit reports apart."""

    @classmethod
    def of(cls, environment: "Environment") -> Self:
        """Read them off an environment."""
        return cls(**{field.name: getattr(environment, field.name) for field in fields(cls)})

    @property
    def best_return(self) -> float:
        """The one of the normalised scale."""
        return self.max_reward * self.horizon


@cache
def environment_facts(name: str) -> EnvironmentFacts:
    """Return the facts of an environment.

    Raises:
        ValueError: for an unknown name, and for an installed task that cannot be made.
    """
    return EnvironmentFacts.of(physics.make(name))


def known_environments() -> list[EnvironmentFacts]:
    """Return the facts of all environments but installed ones that cannot be made.

    Whoever names one of those is told why.
    """
    known = []
    for name in physics.names():
        with suppress(ValueError):
            known.append(environment_facts(name))
    return known


def best_return(name: str) -> float:
    """Return the one of an environment's normalised scale. Raises ValueError as above."""
    return environment_facts(name).best_return
