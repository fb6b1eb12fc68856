"""Task: that of a run, installed here or of a file that comes with it."""

import physics
from physics.environment import Environment
from physics.task_file import TaskFile, reference
from workers.messages.run_spec import RunSpec


def task_of(spec: RunSpec, file: TaskFile | None) -> Environment:
    """The task that a run learned in. Raises ValueError where it cannot be made."""
    return physics.make(reference(spec.environment, file))
