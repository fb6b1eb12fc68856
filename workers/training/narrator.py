"""Log of a worker's cohort: a line for each change, none while training goes on."""

import logging
import time
from collections.abc import Callable, Iterable

from workers.messages.progress import Activity, Progress
from workers.messages.work import Work

log = logging.getLogger("d3pg")


class Narrator:
    """Logs a cohort's progress in the log of its worker. The clock is for tests."""

    def __init__(self, work: Work, clock: Callable[[], float] = time.monotonic) -> None:
        """Log what will be trained."""
        self._clock = clock
        self._begun_at = clock()
        self._activity = Activity.COMPILING
        cell = work.specs[0]
        settings = "".join(f" {name}={value}" for name, value in cell.config.items())
        log.info(
            "%s w1=%g w2=%g%s in %s, %s, %d timesteps",
            *(cell.algorithm, *cell.weights, settings, cell.environment),
            *(seeds_text(spec.seed for spec in work.specs), cell.timesteps),
        )

    def tell(self, progress: Progress) -> None:
        """Log the changes."""
        for each in progress.resumed:
            if each.timestep:
                log.info("seed %d resumes at timestep %d", each.seed, each.timestep)
            if each.note:
                log.warning("seed %d: %s", each.seed, each.note)
        if progress.activity is not self._activity:
            self._activity = progress.activity
            log.info("training, after %.1f s of preparation", self._clock() - self._begun_at)
        for checkpoint in progress.checkpoints:
            if checkpoint.problem:
                log.warning("seed %d: %s", checkpoint.seed, checkpoint.problem)
        for divergence in progress.diverged:
            log.warning(
                "seed %d diverged at timestep %d: %s stopped being finite",
                *(divergence.seed, divergence.timestep, divergence.quantity),
            )
        for failure in progress.failed:
            log.error("seed %d failed at timestep %d", failure.seed, failure.timestep)
        if progress.dropped:
            log.info("%s stopped on demand", seeds_text(progress.dropped))
        if progress.finished:
            log.info("%s reached the end", seeds_text(progress.finished))


def seeds_text(seeds: Iterable[int]) -> str:
    """Return `seed 3`, or `seeds 0, 1, 2`."""
    named = sorted(seeds)
    return f"seed{'s' * (len(named) > 1)} {', '.join(map(str, named))}"
