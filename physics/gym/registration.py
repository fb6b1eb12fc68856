"""Gymnasium's registry: every task as `d3pg/<Name>-v0`, from the moment Gymnasium is imported.

A slash in a task's name becomes a hyphen, since an id's slash follows the namespace:
`d3pg/mujoco-Hopper-v0`.

No simulator is loaded before a task is made: a task's module may take seconds to load, may be in an
installed package that fails to load, or may be the one that is being imported.
"""

from dataclasses import asdict
from functools import cached_property
from typing import TYPE_CHECKING

import gymnasium
from gymnasium.envs.registration import EnvSpec

from physics.catalogue import as_task, names

if TYPE_CHECKING:
    from physics.environment import Environment


class TaskSpec(EnvSpec):
    """The spec of a task, which looks up the task's horizon on first use."""

    def __post_init__(self) -> None:
        """Remove the time limit if none was given: the property below looks it up.

        The task is stored outside `kwargs`, which `gymnasium.make_vec` empties before it reads the
        time limit.
        """
        super().__post_init__()
        self._task = self.kwargs.get("task", self.name)
        if self.max_episode_steps is None:
            del self.max_episode_steps

    @cached_property
    def max_episode_steps(self) -> int | None:  # type: ignore[override]
        """The task's horizon."""
        return as_task(self._task).horizon

    def __eq__(self, other: object) -> bool:
        """Whether the other spec is equal, be it a `TaskSpec` or an `EnvSpec`."""
        return isinstance(other, EnvSpec) and asdict(self) == asdict(other)

    __hash__ = None  # type: ignore[assignment] # as every EnvSpec


def identifier(task: str) -> str:
    """Gymnasium's id of the task of that name."""
    return f"d3pg/{_word(task)}-v0"


def _word(task: str) -> str:
    """A task's name without its slash."""
    return task.replace("/", "-")


def spec_of(task: "str | Environment | type[Environment]") -> TaskSpec:
    """Gymnasium's spec of a task that is not in its registry, for `gymnasium.make` and `make_vec`.

    Args:
        task: as `physics.as_task` takes it, such as "my_tasks.py:Arm".

    Raises:
        ValueError: for a task that cannot be made.
    """
    return _spec(identifier(as_task(task).name), task)


def register() -> None:
    """Register every task of `physics.names()` that is not registered yet."""
    for name in names():
        own = identifier(name)
        if own in gymnasium.registry:
            continue
        try:
            gymnasium.registry[own] = _spec(own, name)
        except gymnasium.error.Error as refusal:
            gymnasium.logger.warn(f"d3pg: the task {name!r} is not registered: {refusal}")


def _spec(own: str, task: "str | Environment | type[Environment]") -> TaskSpec:
    """The spec of a task, under its id."""
    return TaskSpec(
        own,
        entry_point="physics.gym.env:GymnasiumEnvironment",
        vector_entry_point="physics.gym.vector_env:GymnasiumVectorEnvironment",
        kwargs={"task": task},
    )
