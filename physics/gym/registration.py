"""Gymnasium's registry: every task as `d3pg/<Name>-v0`, from the moment Gymnasium is imported.

No simulator is loaded before it is made: a task's module may take seconds to load, may be an
installed package that fails to, or may be the very one that is being imported.
"""

from dataclasses import asdict
from functools import cached_property

import gymnasium
from gymnasium.envs.registration import EnvSpec

from physics.catalogue import make, names


class TaskSpec(EnvSpec):
    """The spec of a task, which looks up the task's horizon when first asked for it."""

    def __post_init__(self) -> None:
        """Forget the time limit if none was given: the property below finds it."""
        super().__post_init__()
        if self.max_episode_steps is None:
            del self.max_episode_steps

    @cached_property
    def max_episode_steps(self) -> int | None:  # type: ignore[override]
        """The task's horizon."""
        return make(self.name).horizon

    def __eq__(self, other: object) -> bool:
        """Whether the other spec says the same, whichever of the two classes it is of."""
        return isinstance(other, EnvSpec) and asdict(self) == asdict(other)

    __hash__ = None  # type: ignore[assignment] # as every EnvSpec


def register() -> None:
    """Register every task of `physics.names()` that is not registered yet."""
    for name in names():
        identifier = f"d3pg/{name}-v0"
        if identifier in gymnasium.registry:
            continue
        try:
            gymnasium.registry[identifier] = _spec(identifier, name)
        except gymnasium.error.Error as refusal:
            gymnasium.logger.warn(f"d3pg: the task {name!r} is not registered: {refusal}")


def _spec(identifier: str, name: str) -> TaskSpec:
    """The spec of the task of that name."""
    return TaskSpec(
        identifier,
        entry_point="physics.gym.env:GymnasiumEnvironment",
        vector_entry_point="physics.gym.vector_env:GymnasiumVectorEnvironment",
        kwargs={"task": name},
    )
