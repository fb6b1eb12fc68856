"""Executing a cohort: specs in, progress out. Plain Python, independent of Ray.

A run's curve depends on its spec alone, so executing a run again gives the same measurements.
"""

from collections.abc import Callable, Collection, Generator, Sequence
from dataclasses import replace
from functools import partial

from algorithms.learner import Learner
from algorithms.training import build
from physics.task_file import TaskFile, reference
from workers.checkpoints.checkpoint import Checkpoints
from workers.checkpoints.place import Place
from workers.messages.assignment import Assignment
from workers.messages.progress import Activity, Progress
from workers.messages.run_spec import RunSpec, shared_cell
from workers.messages.work import REPORT_SECONDS
from workers.training.cohort_thread import CohortThread
from workers.training.fingerprint import fingerprint
from workers.training.random_play import measure_random_return as measure

BuildLearner = Callable[[Sequence[RunSpec]], Learner]


def learner_of_cohort(specs: Sequence[RunSpec], file: TaskFile | None = None) -> Learner:
    """Make the learner of a cohort, whose task may be of a file."""
    spec = specs[0]
    return build(
        spec.algorithm,
        reference(spec.environment, file),
        seeds=[spec.seed for spec in specs],
        weights=spec.weights,
        timesteps=spec.timesteps,
        config=spec.config,
    )


def execute(
    runs: Sequence[Assignment],
    checkpoints: Place,
    dropped: Callable[[], Collection[int]],
    on_abandoned: Callable[[], None],
    *,
    file: TaskFile | None = None,
    measure_random_return: bool = False,
    report_seconds: float = REPORT_SECONDS,
    build_learner: BuildLearner | None = None,
) -> Generator[Progress, None, None]:
    """Train a cohort and yield its progress every so many seconds, the last when all has ended.

    Runs that have checkpoints in that place are resumed there; the first progress that has the
    fingerprint says so. Closing the generator stops the training.

    `dropped` returns the seeds to stop training; it is called before every cycle. `on_abandoned` is
    called, on another thread, when no progress was taken for long and training has stopped.
    With `measure_random_return`, one of the first has the random return of the task. A task of a
    file needs the `file`, whose hash is part of the fingerprint.

    Raises ValueError where the specs are no cohort, and what the learner raises.
    """
    specs = {run.spec.seed: run.spec for run in runs}
    cell = shared_cell([run.spec for run in runs])
    yield Progress(0, Activity.COMPILING)
    own = fingerprint() if file is None else {**fingerprint(), "task": file.digest}
    build_learner = build_learner or partial(learner_of_cohort, file=file)
    cohort = CohortThread(
        {run.spec.seed: Checkpoints(checkpoints, run, own) for run in runs},
        lambda seeds: build_learner([specs[seed] for seed in seeds]),
        dropped,
        on_abandoned,
        partial(measure, cell.environment, file=file) if measure_random_return else None,
    )
    try:
        is_over = False
        while not is_over:
            progress, is_over = cohort.collect(report_seconds)
            yield replace(progress, fingerprint=own) if progress.resumed else progress
    finally:
        cohort.stop()
