"""Picture: a task at a start, as data to draw."""

from typing import Any

import physics
from physics.film import film
from physics.task_file import TaskFile, reference

SEED = 0


def picture(environment: str, file: TaskFile | None) -> dict[str, Any]:
    """Return the film of one state: the start that the task draws for seed 0.

    `file` is the text of the task, where the task is of one.

    Raises ValueError where the task cannot be made, or its code cannot draw it.
    """
    task = physics.make(reference(environment, file))
    try:
        return film([task.draw(task.initial_states([SEED])[0])])
    except Exception as error:
        raise ValueError(
            f"{environment} cannot be drawn: {type(error).__name__}: {error}"
        ) from error
