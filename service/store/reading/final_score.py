"""The final score of a run, as SQL: what `service.analysis.statistics.score.final_score` says."""

from typing import Any

from sqlalchemy import ScalarSelect, case, func, or_, select

from service.store.tables import measurements, runs


def final_score() -> ScalarSelect[Any]:
    """Return the mean of return_mean in the last tenth of a run's timesteps, at least the last.

    NULL, which is NaN, where a value in that window is not a number. It goes with rows of `runs`.
    """
    of_run = measurements.c.run_number == runs.c.number
    last = select(func.max(measurements.c.timestep)).where(of_run).correlate(runs)
    at_end = or_(
        10 * measurements.c.timestep > 9 * runs.c.timesteps,
        measurements.c.timestep == last.scalar_subquery(),
    )
    value = measurements.c.return_mean
    mean = case((func.count() == func.count(value), func.avg(value)))
    return select(mean).where(of_run, at_end).correlate(runs).scalar_subquery()
