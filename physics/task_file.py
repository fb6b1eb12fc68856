"""Task files: tasks from one Python file that is not packaged, such as `my_tasks.py:Arm`.

The tasks of a file are the task classes that it defines and the task instances that it makes, under
the names they are bound to; names that begin with "_" are private to the file. Their version is a
number made of the file's hash, whatever they declare: a changed file is a new version.

A task file stands alone: it may import installed packages, but not the files beside it, because
only its text is sent to the workers of a service.
"""

import hashlib
import inspect
import linecache
import os
import re
import socket
import sys
import tempfile
import traceback
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cache
from importlib.util import module_from_spec, spec_from_file_location
from pathlib import Path
from types import ModuleType
from typing import TYPE_CHECKING, Any, NamedTuple, Self

from physics.task_check import CheckedWhenMade

if TYPE_CHECKING:
    from physics.environment import Environment

_REFERENCE = re.compile(r"(?P<path>.+\.py)(?::(?P<task>[\w./-]+))?")


@dataclass(frozen=True)
class TaskFile:
    """The text of a file of tasks, and the name under which it is shown."""

    name: str
    source: str

    @classmethod
    def read(cls, path: Path) -> Self:
        """Read a file.

        Raises:
            ValueError: for a file that does not exist or is not text.
        """
        try:
            return cls(path.name, path.read_bytes().decode())
        except OSError as error:
            raise ValueError(f"the task file {path} cannot be read: {error.strerror}") from error
        except UnicodeDecodeError as error:
            raise ValueError(f"the task file {path} is not UTF-8 text: {error}") from error

    @property
    def digest(self) -> str:
        """The SHA-256 of the text, 64 hexadecimal digits."""
        return hashlib.sha256(self.source.encode()).hexdigest()

    @property
    def version(self) -> int:
        """The version of its tasks: the first seven digits of the hash, as a number from 1 on."""
        return int(self.digest[:7], 16) + 1

    def reference(self, task: str) -> str:
        """The name by which `physics.make` makes a task of the file on this machine.

        The file is written into this user's cache, below its hash, unless it is already there.

        Raises:
            ValueError: if another text is there.
        """
        path = self.put(_cache())
        if (found := TaskFile.read(path).digest) != self.digest:
            raise ValueError(
                f"{path} on {socket.gethostname()} has the hash {found}, but the service's "
                f"{self.name} has {self.digest}: remove the file there, and retry the run"
            )
        return f"{path}:{task}"

    def put(self, folder: Path) -> Path:
        """Write the file into the folder, below its hash, unless it is there; return its path."""
        path = folder / self.digest / self.name
        if not path.exists():
            path.parent.mkdir(parents=True, exist_ok=True)
            handle, unfinished = tempfile.mkstemp(dir=path.parent)
            with os.fdopen(handle, "w", encoding="utf-8", newline="") as file:
                file.write(self.source)
            Path(unfinished).replace(path)
        return path


def reference(environment: str, file: TaskFile | None) -> str:
    """The name by which `physics.make` makes an environment, which is of `file` unless None.

    Raises:
        ValueError: as `TaskFile.reference`.
    """
    return environment if file is None else file.reference(environment)


def _cache() -> Path:
    """The user's folder for the files that come with a run; if not writeable, a temporary one."""
    home = Path(os.environ.get("XDG_CACHE_HOME") or "~/.cache").expanduser()
    folder = home / "d3pg" / "tasks"
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError:
        return _own_folder()
    return folder if os.access(folder, os.W_OK) else _own_folder()


@cache
def _own_folder() -> Path:
    return Path(tempfile.mkdtemp(prefix="d3pg-tasks-"))


class Reference(NamedTuple):
    """A file, and the name of a task in it; the name may be empty if the file has only one task."""

    path: Path
    task: str

    @classmethod
    def parse(cls, text: str) -> "Reference | None":
        """Parse `my_tasks.py:Arm` or `my_tasks.py`; None for text that does not name a file."""
        found = _REFERENCE.fullmatch(text)
        return cls(Path(found["path"]), found["task"] or "") if found else None


def make_task(reference: Reference) -> "Environment":
    """Make the task of a file.

    Raises:
        ValueError: for a file that cannot be loaded, with the line; for a name that is not one of
            its tasks; for a task that cannot be made, with all its mistakes.
    """
    tasks = load(reference.path)
    return _made(reference.path, _chosen(tasks, reference))


def make_all(path: Path) -> "list[Environment]":
    """Make every task of a file. Raises ValueError as `make_task`."""
    return [_made(path, task) for task in load(path).values()]


def load(path: Path) -> Mapping[str, Any]:
    """The tasks of a file by name: classes, and tasks that the file makes itself.

    The same text at the same path is run only once in a process.

    Raises:
        ValueError: for a file that raises, with the line, and for one that defines no task.
    """
    file, path = TaskFile.read(path), path.resolve()
    module = _module(file, path)
    found = {name: value for name, value in vars(module).items() if _is_task(value, module)}
    abstract = [value for value in found.values() if inspect.isabstract(value)]
    tasks = {name: value for name, value in found.items() if value not in abstract}
    if not tasks:
        lacking = "".join(
            f"; {cls.__name__} lacks {', '.join(sorted(cls.__abstractmethods__))}"
            for cls in abstract
        )
        raise ValueError(
            f"{path} defines no task: a task is a class derived from TorchEnvironment or "
            f"Environment (docs/add-a-task.md){lacking}"
        )
    for task in tasks.values():
        task.version = file.version
    return tasks


def _module(file: TaskFile, path: Path) -> ModuleType:
    """Run the file and return the module. Raises ValueError for anything that it raises."""
    place = hashlib.sha256(f"{path}\0{file.source}".encode()).hexdigest()[:16]
    name = f"task_file_{path.stem}_{place}"
    if name in sys.modules:
        return sys.modules[name]
    linecache.checkcache(str(path))
    specification = spec_from_file_location(name, path)
    if specification is None or specification.loader is None:
        raise ValueError(f"{path} is not a Python file")
    module = module_from_spec(specification)
    sys.modules[name] = module
    try:
        exec(compile(file.source, str(path), "exec"), vars(module))  # noqa: S102 - the user's own
    except (Exception, SystemExit) as error:
        del sys.modules[name]
        raise ValueError(_raised(path, error)) from error
    return module


def _raised(path: Path, error: BaseException) -> str:
    """The error that the file raised, with its line."""
    frames = traceback.extract_tb(error.__traceback__)
    lines = [frame.lineno for frame in frames if frame.filename == str(path)]
    line = error.lineno if isinstance(error, SyntaxError) else lines[-1] if lines else None
    text = error.msg if isinstance(error, SyntaxError) else str(error)
    hint = ""
    if isinstance(error, ModuleNotFoundError) and error.name:
        beside = path.with_name(f"{error.name.partition('.')[0]}.py")
        if beside.exists():
            hint = (
                f"; a task file cannot import the files beside it: move what it needs of "
                f"{beside.name} into it"
            )
    return f"{path}, line {line}: {type(error).__name__}: {text}{hint}"


def _is_task(value: Any, module: ModuleType) -> bool:
    """Whether a value of the module is one of its tasks: a class defined there, or an instance."""
    if isinstance(value, CheckedWhenMade):
        return value.__module__ == module.__name__ and not value.__name__.startswith("_")
    return isinstance(type(value), CheckedWhenMade)


def _chosen(tasks: Mapping[str, Any], reference: Reference) -> Any:
    """The task that the reference names, by its variable in the file or by its own name."""
    path, name = reference
    if not name and len(tasks) == 1:
        return next(iter(tasks.values()))
    for bound, task in tasks.items():
        if name in (bound, getattr(task, "name", bound)):
            return task
    known = ", ".join(tasks)
    if name:
        raise ValueError(f"{path} defines no task {name!r} (it defines: {known})")
    raise ValueError(
        f"{path} defines {len(tasks)} tasks ({known}): name one, such as {path}:{next(iter(tasks))}"
    )


def _made(path: Path, task: Any) -> "Environment":
    if not isinstance(task, CheckedWhenMade):
        made: Environment = task
        return made
    try:
        made = task()
    except Exception as error:
        line = inspect.getsourcelines(task)[1]
        kind = "" if isinstance(error, ValueError) else f"{type(error).__name__}: "
        raise ValueError(f"{path}, line {line}: {kind}{error}") from error
    return made
