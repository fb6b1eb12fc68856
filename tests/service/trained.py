"""Training for real what is queued, as a worker does, in this process."""

from service.settings import Settings
from service.store.store import Store
from service.task_shelf import TaskShelf
from workers.training.execute import execute


def train_queued(store: Store, settings: Settings, shelf: TaskShelf | None = None) -> None:
    """Train every queued cohort to its end; tasks of files come from the shelf."""

    def never() -> None:
        raise AssertionError("it was not abandoned")

    while (claim := store.claim_cohort("worker", 60.0)) is not None:
        run = claim.runs[0]
        named = run.spec.environment, run.environment_version
        file = None if shelf is None else shelf.file_of(*named)
        for progress in execute(claim.runs, settings.checkpoint_place, tuple, never, file=file):
            store.record(claim, progress)
