"""The task shelf: the task files that a service was given, kept in its data directory.

Another process runs a file and returns the facts of its tasks. Text and facts are kept in one JSON
file for each version of each task: runs of a version are trained and played with its text, even
after the file has changed, and their curves are known when it is not served any more.
"""

import time
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from pathlib import Path
from urllib.parse import quote

from pydantic import TypeAdapter

import physics
from physics.parameter import name_of
from physics.task_file import TaskFile
from service.model.environment import EnvironmentFacts, know_tasks_of_files
from service.refusal import RefusalError

Describe = Callable[[Path], Sequence[EnvironmentFacts]]


class TaskFileError(RefusalError):
    """A task file that cannot be served."""


@dataclass(frozen=True)
class KeptTask:
    """A version of a task, and the file that it comes from."""

    facts: EnvironmentFacts
    file: TaskFile
    served_at: float


_FORMAT = TypeAdapter(KeptTask)


class TaskShelf:
    """The tasks of files, of this service and of those before it on the data directory."""

    def __init__(self, data_dir: Path) -> None:
        """Read what is kept."""
        self._folder = data_dir / "tasks"
        kept = [_FORMAT.validate_json(each.read_bytes()) for each in self._folder.glob("*.json")]
        kept.sort(key=lambda task: task.served_at)
        self._kept = {(task.facts.name, task.facts.version): task for task in kept}
        self._know(())

    def serve(self, paths: Iterable[Path], describe: Describe) -> None:
        """Serve the tasks of these files.

        Raises:
            TaskFileError: for a file that cannot be used, and for a name that is taken.
        """
        served = [task for path in paths for task in _described(path, describe)]
        _refuse_taken_names(served)
        for task in served:
            self._keep(task)
        self._know([task.facts.name for task in served])

    def file_of(self, environment: str, version: int) -> TaskFile | None:
        """Return the file of a version of an environment; None where it is of none."""
        kept = self._kept.get((name_of(environment), version))
        return None if kept is None else kept.file

    def _keep(self, task: KeptTask) -> None:
        self._folder.mkdir(parents=True, exist_ok=True)
        path = self._folder / f"{quote(task.facts.name, safe='')}-{task.facts.version}.json"
        unfinished = path.with_suffix(".unfinished")
        unfinished.write_bytes(_FORMAT.dump_json(task))
        unfinished.replace(path)
        key = task.facts.name, task.facts.version
        self._kept.pop(key, None)
        self._kept[key] = task  # the last of a name is the one that is known by it

    def _know(self, served: Iterable[str]) -> None:
        installed = set(physics.names())
        known = (task.facts for task in self._kept.values() if task.facts.name not in installed)
        know_tasks_of_files(known, served)


def _described(path: Path, describe: Describe) -> list[KeptTask]:
    try:
        file, facts = TaskFile.read(path), describe(path)
    except ValueError as error:
        raise TaskFileError(str(error)) from error
    for each in facts:
        if each.version != file.version:
            raise TaskFileError(f"{path} changed while it was loaded: start the service again")
    return [KeptTask(each, file, time.time()) for each in facts]


def _refuse_taken_names(tasks: Sequence[KeptTask]) -> None:
    taken = dict.fromkeys(physics.names(), "an installed task")
    for task in tasks:
        name = task.facts.name
        if name in taken:
            raise TaskFileError(
                f"{task.file.name}: the name {name!r} is taken by {taken[name]}: give the task "
                "another name"
            )
        taken[name] = f"another task of {task.file.name}"
