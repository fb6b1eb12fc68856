"""Learned: what a run has learned, asked of the process beside the service."""

from typing import Any

from service.api.problems import ImpossibleMove, ServiceBusy
from service.api.side_process import BusyError, Side, TooSlowError
from service.model.environment import environment_facts
from service.model.run import Run
from service.task_shelf import TaskShelf
from workers.checkpoints.folder import UnavailableError
from workers.checkpoints.place import Place
from workers.checkpoints.sealed_file import DamagedError


def learned(
    side: Side, function: str, checkpoints: Place, run: Run, shelf: TaskShelf, *arguments: Any
) -> Any:
    """What a function of `(checkpoints, run id, spec, file, *arguments)` makes of it.

    `file` is the text of the run's task where the task is of a file, else None.

    Raises:
        ImpossibleMove: while the run has learned nothing that was written, where that cannot be
            read, and where the service has no or another version of the run's task.
        ServiceBusy: where it cannot be done now.
    """
    file = shelf.file_of(run.spec.environment, run.environment_version)
    if file is None:
        _refuse_another_version(run)
    try:
        answer = side.call(function, checkpoints, run.id, run.spec, file, *arguments)
    except UnavailableError as trouble:
        raise ServiceBusy(
            f"What run {run.id} learned cannot be read now: {trouble.strerror}."
        ) from trouble
    except DamagedError as damage:
        raise ImpossibleMove(f"What run {run.id} learned cannot be read: {damage}.") from damage
    except (BusyError, TooSlowError, EOFError) as error:
        raise ServiceBusy(f"The policy of run {run.id} cannot be had now: {error}.") from error
    if answer is None:
        raise ImpossibleMove(
            f"Run {run.id} ({run.status}) has no policy: one is written with every checkpoint and "
            "at the end, and mpc, which plans, learns none."
        )
    return answer


def _refuse_another_version(run: Run) -> None:
    try:
        now = environment_facts(run.spec.environment).version
    except ValueError as error:
        raise ImpossibleMove(
            f"The task of run {run.id} cannot be made by this service: {error}."
        ) from error
    if now != run.environment_version:
        raise ImpossibleMove(
            f"Run {run.id} learned in version {run.environment_version} of {run.spec.environment}; "
            f"this service has version {now}."
        )
