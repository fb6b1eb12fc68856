"""The task that a run learned."""

import physics
from physics.environment import Environment
from physics.task_file import TaskFile
from workers.messages.run_spec import RunSpec


def task_of(spec: RunSpec, file: TaskFile | None) -> Environment:
    """Make it: of its file's text where it comes from a file, else of the catalogue."""
    return physics.make(file.reference(spec.environment) if file else spec.environment)
