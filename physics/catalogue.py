"""Catalogue: the tasks by name.

An installed package adds a task of its own through the entry-point group `d3pg.environments`, with
the task's name and `module:Class`. The project's own tasks are declared the same way, and loaded
when they are made: listing names loads no simulator. Tasks that need the package of an extra are
listed where it is installed.

A task without an entry point is named by its file, `my_tasks.py:Arm`, or given as an object.
"""

from collections.abc import Iterable, Iterator, Sequence
from difflib import get_close_matches
from importlib.metadata import EntryPoint, entry_points
from importlib.util import find_spec
from typing import TYPE_CHECKING, Any

from physics import parameter
from physics.task_check import CheckedWhenMade
from physics.task_file import Reference, make_task

if TYPE_CHECKING:
    from physics.environment import Environment

GROUP = "d3pg.environments"

OWN = {
    "MassPoint": "physics.tasks.mass_point:MassPoint",
    "CartPole": "physics.tasks.cart_pole:CartPole",
    "CartPoleSwingUp": "physics.tasks.cart_pole_swing_up:CartPoleSwingUp",
    "Pendulum": "physics.tasks.pendulum:Pendulum",
    "MountainCar": "physics.tasks.mountain_car:MountainCar",
    "Acrobot": "physics.tasks.acrobot:Acrobot",
    "RollingDie": "physics.tasks.rolling_die:RollingDie",
    "HalfCheetah": "physics.tasks.half_cheetah:HalfCheetah",
    "Hopper": "physics.tasks.hopper:Hopper",
    "Walker2d": "physics.tasks.walker2d:Walker2d",
    "BallWall": "physics.tasks.ball_wall:BallWall",
}
EXTRAS = {
    "mujoco": {
        "mujoco/HalfCheetah": "physics.mujoco.gymnasium.running:HalfCheetah",
        "mujoco/Hopper": "physics.mujoco.gymnasium.running:Hopper",
        "mujoco/Walker2d": "physics.mujoco.gymnasium.running:Walker2d",
        "mujoco/Swimmer": "physics.mujoco.gymnasium.running:Swimmer",
        "mujoco/InvertedDoublePendulum": (
            "physics.mujoco.gymnasium.inverted_double_pendulum:InvertedDoublePendulum"
        ),
        "mujoco/Reacher": "physics.mujoco.gymnasium.reacher:Reacher",
    },
}
"""Package -> tasks that need it."""


def names() -> list[str]:
    """The names of all tasks: the project's own, then those of installed packages."""
    ours = [*OWN, *(name for name, package in _needed().items() if find_spec(package))]
    others = (entry.name for entry in entry_points(group=GROUP))
    return [*ours, *sorted(name for name in others if name not in {*OWN, *_needed()})]


def _needed() -> dict[str, str]:
    """The package that each task of an extra needs."""
    return {name: package for package, tasks in EXTRAS.items() for name in tasks}


def make(name: str, /, **parameters: float) -> "Environment":
    """Make the task of that name.

    Args:
        name: a name that `names()` lists; or a file and a task in it, `my_tasks.py:Arm` (without
            the task where the file has one). Values of parameters may follow the name, as in
            `Pendulum(gravity=9.81)`.
        parameters: values of the task's physical parameters; all others have their defaults.

    Raises:
        ValueError: for an unknown name, with the nearest known one; for an installed task that
            cannot be made, with all its mistakes, or whose name differs from its entry point's;
            for a file that cannot be loaded, with the line; for an unknown parameter, and a value
            out of its range.
    """
    plain, values = parameter.parse(name)
    reference = Reference.parse(plain)
    task = _installed(plain) if reference is None else make_task(reference)
    values |= parameters
    return task.with_parameters(**values) if values else task


def as_task(task: "str | Environment | type[Environment]") -> "Environment":
    """The task itself, whether it is given by name (see `make`), as a class or as an instance.

    Raises:
        ValueError: as `make`, and for anything else.
    """
    if isinstance(task, str):
        return make(task)
    made: Any = task() if isinstance(task, CheckedWhenMade) else task
    if isinstance(type(made), CheckedWhenMade):
        environment: Environment = made
        return environment
    raise ValueError(
        "a task is a name that physics.names() lists, a file such as 'my_tasks.py:Arm', or a class "
        f"or an instance of Environment, not {task!r}"
    )


def _installed(name: str) -> "Environment":
    """Make the task of an entry point. For errors see `make`."""
    entry = _entry(name)
    try:
        environment: Environment = entry.load()()
    except ValueError:
        raise
    except Exception as error:
        raise ValueError(
            f"{name} ({entry.value}) cannot be made: {type(error).__name__}: {error}"
        ) from error
    if getattr(environment, "name", None) != name:
        raise ValueError(
            f"entry point {name!r} makes {environment!r}, which is not a task of that name"
        )
    return environment


def compile_kernels(names: Iterable[str]) -> Iterator[tuple[str, float]]:
    """Compile the kernels of these tasks one after the other, yielding (name, seconds) of each.

    The first use on a machine takes seconds a task; later uses load the kernels from disk. A
    program can call this ahead, and show progress.

    Raises:
        ValueError: as `make`.
    """
    for name in names:
        yield name, make(name).compile()


def _entry(name: str) -> EntryPoint:
    """The entry point of the task of that name."""
    for ours in (OWN, *EXTRAS.values()):
        if name in ours:
            return EntryPoint(name, ours[name], GROUP)
    for entry in entry_points(group=GROUP):
        if entry.name == name:
            return entry
    raise ValueError(unknown_task(name, names()))


def unknown_task(name: str, known: Sequence[str]) -> str:
    """The error message for a name that is not a known task."""
    folded = {each.casefold(): each for each in known}
    near = get_close_matches(str(name).casefold(), folded, n=1, cutoff=0.5)
    hint = f"; did you mean {folded[near[0]]!r}?" if near else ""
    return f"unknown environment {name!r}{hint} (known: {', '.join(known)})"
