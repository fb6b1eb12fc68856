"""What runs have learned, read and used in the side process."""

from typing import Annotated, Any

from fastapi import Depends

from physics.task_file import TaskFile
from service.api.context import TheCheckpoints, TheShelf, TheSide
from service.api.load.side_process import BusyError, TooSlowError
from service.api.refusals.problems import ImpossibleMove, ServiceBusy
from service.model.environment import environment_facts
from service.model.run import Run
from workers.checkpoints.checkpoint_folder import has_policy
from workers.checkpoints.folder import UnavailableError
from workers.checkpoints.sealed_file import DamagedError


class Learned:
    """The policies of runs, where they lie and who reads them."""

    def __init__(self, checkpoints: TheCheckpoints, side: TheSide, shelf: TheShelf) -> None:
        """Read nothing yet."""
        self._checkpoints = checkpoints
        self._side = side
        self._shelf = shelf

    def call(self, function: str, run: Run, *arguments: Any) -> Any:
        """What a function of `(checkpoints, run id, spec, task file, *arguments)` returns.

        Raises:
            ImpossibleMove: if no policy of the run was written yet, if it cannot be read, or if the
                service has no or another version of the run's task.
            ServiceBusy: where it cannot be done now.
        """
        file = self._file_of(run)
        try:
            answer = self._side.call(
                function, self._checkpoints, run.id, run.spec, file, *arguments
            )
        except UnavailableError as trouble:
            raise ServiceBusy(
                f"What run {run.id} learned cannot be read now: {trouble.strerror}."
            ) from trouble
        except DamagedError as damage:
            raise ImpossibleMove(f"What run {run.id} learned cannot be read: {damage}.") from damage
        except EOFError as death:
            raise ServiceBusy(
                f"What run {run.id} learned cannot be used now: the process that used it died."
            ) from death
        except (BusyError, TooSlowError) as error:
            raise ServiceBusy(
                f"The policy of run {run.id} is not available now: {error}."
            ) from error
        if answer is None:
            raise ImpossibleMove(_no_policy(run))
        return answer

    def refuse_missing(self, run: Run) -> None:
        """Raise what `call` would raise, as far as can be seen without reading the policy."""
        self._file_of(run)
        try:
            is_there = has_policy(self._checkpoints, run.id)
        except OSError as trouble:
            raise ServiceBusy(
                f"What run {run.id} learned cannot be read now: {trouble.strerror}."
            ) from trouble
        if not is_there:
            raise ImpossibleMove(_no_policy(run))

    def _file_of(self, run: Run) -> TaskFile | None:
        """The file that the run's task is from, if any. Raises ImpossibleMove."""
        file = self._shelf.file_of(run.spec.environment, run.environment_version)
        if file is None:
            _refuse_another_version(run)
        return file


TheLearned = Annotated[Learned, Depends()]


def _no_policy(run: Run) -> str:
    return (
        f"Run {run.id} ({run.status}) has no policy: one is written with every checkpoint and at "
        "the end, and mpc, which plans, learns none."
    )


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
