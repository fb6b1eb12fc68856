"""What the service knows of an environment: its declared constants, never its dynamics."""

import inspect
import sys
from collections.abc import Iterable, Mapping
from contextlib import suppress
from dataclasses import dataclass, replace
from functools import lru_cache
from pathlib import Path
from typing import TYPE_CHECKING, Self

import physics
from physics import noise
from physics.catalogue import EXTRAS, OWN, unknown_task
from physics.parameter import Parameter, checked, declared, label, parse
from physics.task_file import Reference, make_all

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
    feature_sources: tuple[int, ...]
    horizon: int
    max_reward: float
    reward_is_differentiable: bool
    regimes: tuple[str, ...]
    """The kinds of step that its gradient audit reports apart."""
    parameters: tuple[Parameter, ...]
    """Its physical parameters, as it declares them; all have those of noise beside."""
    file: str = ""
    """The name of the task file that it comes from; empty for an installed task."""
    description: str = ""
    """Markdown: what the task's class and its module say of it."""

    @classmethod
    def of(cls, environment: "Environment") -> Self:
        """Read them off an environment."""
        return cls(
            name=environment.name,
            version=environment.version,
            state_size=environment.state_size,
            action_size=environment.action_size,
            feature_size=environment.feature_size,
            feature_sources=tuple(environment.feature_sources.tolist()),
            horizon=environment.horizon,
            max_reward=environment.max_reward,
            reward_is_differentiable=environment.reward_is_differentiable,
            regimes=environment.regimes,
            parameters=tuple(declared(type(environment)).values()),
            description=description_of(type(environment)),
        )

    @property
    def best_return(self) -> float:
        """The one of the normalised scale."""
        return self.max_reward * self.horizon


def description_of(task: "type[Environment]") -> str:
    """Return the docstrings of a task's class and of the module that defines it."""
    module = sys.modules.get(task.__module__)
    texts = (task.__doc__, module and module.__doc__)
    return "\n\n".join(inspect.cleandoc(text) for text in texts if text)


class _Told:
    """Facts of tasks from other processes; this process does not run the code of these tasks."""

    of_files: Mapping[str, EnvironmentFacts] = {}
    served: frozenset[str] = frozenset()
    """Those of files that can be submitted."""
    of_packages: Mapping[str, EnvironmentFacts | str] = {}
    """Installed tasks; a text says why one cannot be used."""


def know_tasks_of_files(known: Iterable[EnvironmentFacts], served: Iterable[str]) -> None:
    """Replace the tasks of files that are known; `served` can be submitted."""
    _Told.of_files = {facts.name: facts for facts in known}
    _Told.served = frozenset(served)


def know_tasks_of_packages(told: Mapping[str, EnvironmentFacts | str]) -> None:
    """Replace the tasks of installed packages that are known; their code is not run."""
    _Told.of_packages = dict(told)


def tasks_of_packages() -> list[str]:
    """Return the names of the tasks that installed packages add."""
    ours = set(OWN).union(*EXTRAS.values())
    return [name for name in physics.names() if name not in ours]


def facts_of_package(name: str) -> EnvironmentFacts:
    """Make a task of an installed package and return its facts: not for the service's own process.

    Raises:
        ValueError: where it cannot be made.
    """
    return EnvironmentFacts.of(physics.make(name))


def facts_of_file(path: Path) -> list[EnvironmentFacts]:
    """Run a task file and return the facts of its tasks: not for the service's own process.

    Raises:
        ValueError: for a file or a task that cannot be used; it says why, with the line.
    """
    return [replace(EnvironmentFacts.of(task), file=path.name) for task in make_all(path)]


def environment_facts(environment: str) -> EnvironmentFacts:
    """Return the facts of an environment, which may state values of parameters after its name.

    Raises:
        ValueError: for an unknown name or parameter, a value out of its range, and an installed
            task that cannot be made.
    """
    name, values = parse(environment)
    facts = _Told.of_files.get(name) or _installed_facts(name)
    if noise.is_noisy(checked(name, (*facts.parameters, *noise.PARAMETERS), values)):
        return replace(facts, state_size=facts.state_size + noise.PLACE)
    return facts


def submittable_facts(environment: str) -> EnvironmentFacts:
    """Return the facts of an environment in which runs can be submitted.

    Raises:
        ValueError: as above, and for a task of a file that is not served now.
    """
    facts = environment_facts(environment)
    if facts.file and facts.name not in _Told.served:
        raise ValueError(
            f"{facts.name} is a task of {facts.file}, which this service was not given: start it "
            f"with --tasks {facts.file}"
        )
    return facts


def without_defaults(environment: str) -> str:
    """Return the environment without the values that are its defaults: the same task, if known."""
    try:
        known = (*environment_facts(environment).parameters, *noise.PARAMETERS)
    except ValueError:
        return environment
    defaults = {each.name: each.default for each in known}
    name, values = parse(environment)
    return label(name, {each: value for each, value in values.items() if value != defaults[each]})


def known_environments() -> list[EnvironmentFacts]:
    """Return the facts of all environments but installed ones that cannot be made.

    Naming one of those raises an error that says why. Of task files, those that are served count.
    """
    known = []
    for name in physics.names():
        with suppress(ValueError):
            known.append(_installed_facts(name))
    return known + [_Told.of_files[name] for name in sorted(_Told.served)]


def best_return(environment: str) -> float:
    """Return the one of an environment's normalised scale. Raises ValueError as above."""
    return environment_facts(environment).best_return


def _installed_facts(name: str) -> EnvironmentFacts:
    """Return the facts of an installed task. Raises ValueError for another name."""
    if (reference := Reference.parse(name)) is not None:
        raise ValueError(
            f"a task of a file goes by its own name, such as {reference.task or 'Arm'!r}, in a "
            f"service that was started with --tasks {reference.path.name}"
        )
    told = _Told.of_packages.get(name)
    if told is None and name not in OWN:  # listing what is installed takes milliseconds
        installed = physics.names()
        if name not in installed:
            raise ValueError(unknown_task(name, [*installed, *sorted(_Told.served)]))
    if isinstance(told, str):
        raise ValueError(told)
    return told or _made_facts(name)


@lru_cache(maxsize=1024)  # a name may state any values of parameters
def _made_facts(name: str) -> EnvironmentFacts:
    return EnvironmentFacts.of(physics.make(name))
