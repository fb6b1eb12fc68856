"""Catalogue: the tasks by name.

An installed package adds a task of its own through the entry-point group `d3pg.environments`, with
the task's name and `module:Class`. The project's own are written the same way, and loaded when
made: listing names loads no simulator. Those that need a package which is an extra are listed where
it is installed.
"""

from collections.abc import Iterable, Iterator
from difflib import get_close_matches
from importlib.metadata import EntryPoint, entry_points
from importlib.util import find_spec
from typing import TYPE_CHECKING

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


def make(name: str) -> "Environment":
    """Make the task of that name.

    Args:
        name: a name that `names()` lists.

    Raises:
        ValueError: for an unknown name, naming the nearest known one; for an installed task that
            cannot be made, with all its mistakes, or whose name differs from its entry point's.
    """
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
            f"entry point {name!r} makes {environment!r}, which is no task of its name"
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
    """Where the task of that name is."""
    for ours in (OWN, *EXTRAS.values()):
        if name in ours:
            return EntryPoint(name, ours[name], GROUP)
    for entry in entry_points(group=GROUP):
        if entry.name == name:
            return entry
    known = names()
    folded = {each.casefold(): each for each in known}
    near = get_close_matches(str(name).casefold(), folded, n=1, cutoff=0.5)
    hint = f"; did you mean {folded[near[0]]!r}?" if near else ""
    raise ValueError(f"unknown environment {name!r}{hint} (known: {', '.join(known)})")
