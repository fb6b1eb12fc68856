"""iLQR: the iterative linear-quadratic regulator with control limits, for a cohort of plans.

One iteration, of every plan that has not converged yet:

    expansion   dynamics to first order, cost to second, around the plan     (expansion)
    backward    a better action at every step, and its feedback              (backward, box_qp)
    search      how far to follow it, tried in parallel                      (search)

A plan has converged when the backward pass hardly changes any action (mean `|d| / (|a| + 1)` below
1e-4 while lambda is below 1e-5), when an iteration gained less than 1e-7, or when no regularisation
improves it.

A plan covers a window of its episode, steps start to stop - 1. The steps before the window have
been taken; the plan ignores those after it. An episode that the task ends within the window has no
cost after its end, and its value is 0 there.

Source: Tassa, Mansard and Todorov (2014) and their code.
"""

import numpy as np
from numpy.typing import NDArray

from algorithms.early_end import NotFiniteQuantityError
from algorithms.failing_rows import Failures, call_rows, failures_of
from algorithms.planning.backward import (
    LARGEST,
    Gains,
    Regularisation,
    backward,
    lower_level,
    new_gains,
    new_regularisation,
    new_work,
    raise_level,
)
from algorithms.planning.episodes import Episodes
from algorithms.planning.expansion import Expansion, curved_directions, expand, new_expansion
from algorithms.planning.search import ALPHAS, search
from algorithms.state import State, fill
from physics.environment import Environment
from physics.kernels.compiled import compiled

Floats = NDArray[np.float64]
Integers = NDArray[np.int64]

SMALL_CHANGE = 1e-4
SMALL_LEVEL = 1e-5
SMALL_GAIN = 1e-7

COUNTS = ("is_active", "iterations", "jacobians", "simulated", "_expanded_to")
"""The arrays of a Planner for each plan, beside its trajectory and regularisation."""


class Planner:
    """Plans of P runs on one task, each improved independently; their bits do not depend on P.

    Attributes:
        episodes: the trajectories, which iterations improve in place.
        is_active: bool [P], whether a plan has not converged.
        iterations: int [P], iterations so far.
        jacobians: int [P], Jacobians of a step computed so far.
        simulated: int [P], steps that line searches have simulated so far.
        failures: the errors of plans that cannot continue, by index; others are not affected.
    """

    def __init__(self, environment: Environment, episodes: Episodes) -> None:
        """Use the episodes' trajectories as first plans."""
        plans = len(episodes.ends)
        self.episodes = episodes
        self.is_active = np.zeros(plans, np.bool_)
        self.iterations = np.zeros(plans, np.int64)
        self.jacobians = np.zeros(plans, np.int64)
        self.simulated = np.zeros(plans, np.int64)
        self.failures: Failures = {}
        self.regularisation = new_regularisation(plans)
        self.gains = new_gains(environment, plans)
        self._environment = environment
        self._directions = curved_directions(environment)
        self._expansion = new_expansion(environment, plans)
        self._expanded_to = np.zeros(plans, np.int64)
        self._work = new_work(environment)

    @property
    def bytes_per_plan(self) -> int:
        """Memory that each plan fills."""
        parts = (*self.episodes, *self.gains, *self._expansion)
        return sum(part.nbytes for part in parts) // max(len(self.is_active), 1)

    def begin(self, plans: Integers) -> None:
        """Mark these plans as not converged, whatever their state was before.

        Regularisation continues from its last value; if none was enough, it starts again.
        """
        self.is_active[plans] = True
        spent = plans[self.regularisation.level[plans] > LARGEST]
        self.regularisation.level[spent] = 1.0
        self.regularisation.growth[spent] = 1.0

    def has_moved(self, plans: Integers, start: int) -> None:
        """Note that the states of these plans have changed from step `start` on."""
        self._expanded_to[plans] = np.minimum(self._expanded_to[plans], start)

    def keep(self, rows: list[int]) -> None:
        """Keep these plans only."""
        self.failures = failures_of(self.failures, rows)
        for name in COUNTS:
            setattr(self, name, getattr(self, name)[rows])
        for name in ("episodes", "regularisation", "gains", "_expansion"):
            parts = getattr(self, name)
            setattr(self, name, type(parts)._make(part[rows] for part in parts))

    def iterate(self, start: int, stop: int, plans: Integers) -> None:
        """Do one iteration of steps start to stop - 1 of these plans, all of them active.

        Plans in which something raises, or whose derivatives or gains are not finite, are noted in
        `failures`.
        """
        self._expand(start, stop, plans)
        self._check(plans, start, stop, self._expansion, "derivative")
        plans = self._intact(plans)
        is_possible = np.ones(len(self.is_active), np.bool_)
        backward(
            plans, start, stop, self.episodes, self._expansion, self.regularisation,
            self.gains, self._work, is_possible,
        )  # fmt: skip
        self._check(plans, start, stop, self.gains, "gain")
        plans = self._intact(plans)
        level, size = self.regularisation.level, self.gains.size
        is_flat = (size < SMALL_CHANGE) & (level < SMALL_LEVEL)
        self.is_active[plans] = (is_possible & ~is_flat)[plans]
        self.iterations[plans] += 1
        plans = plans[self.is_active[plans]]
        if plans.size:
            gain = search(self._environment, plans, (start, stop), self.episodes, self.gains)
            self.simulated[plans] += (stop - start) * len(ALPHAS)
            self._expanded_to[plans[gain > 0.0]] = start
            adapt(plans, gain, self.regularisation, self.is_active)

    def state(self, p: int) -> State:
        """All values on which the next bits of plan p depend; its expansion is recomputed."""
        own = {name: getattr(self, name)[p] for name in COUNTS}
        parts = self.episodes._asdict() | self.regularisation._asdict()
        return {name: np.asarray(array) for name, array in own.items()} | {
            name: np.asarray(array[p]) for name, array in parts.items()
        }

    def restore(self, p: int, start: int, state: State) -> None:
        """Restore what `state` returned, for a plan whose window begins at step `start`.

        Raises:
            KeyError, ValueError: for a state that is not of this task.
        """
        parts = self.episodes._asdict() | self.regularisation._asdict()
        parts |= {name: getattr(self, name) for name in COUNTS}
        for name, array in parts.items():
            fill(array[p : p + 1], state[name][None])
        stop = int(self._expanded_to[p])
        if start < stop:
            expand(
                self._environment, self.episodes, np.array([p]), (start, stop),
                self._directions, self._expansion,
            )  # fmt: skip

    def _expand(self, start: int, stop: int, plans: Integers) -> None:
        """Bring the expansion of the window up to date."""
        for first in np.unique(np.clip(self._expanded_to[plans], start, stop)):
            if first < stop:
                chosen = plans[np.clip(self._expanded_to[plans], start, stop) == first]
                self.jacobians[chosen] += self._expand_from(int(first), stop, chosen)
        self._expanded_to[plans] = stop

    def _expand_from(self, first: int, stop: int, plans: Integers) -> int:
        """Fill in the expansion of these steps; return the number of Jacobians of each plan."""
        count, failures = call_rows(
            lambda chosen: expand(
                self._environment, self.episodes, chosen, (first, stop),
                self._directions, self._expansion,
            ),
            plans,
        )  # fmt: skip
        self.failures |= {int(plans[k]): error for k, error in failures.items()}
        return count or 0

    def _check(
        self, plans: Integers, start: int, stop: int, parts: Expansion | Gains, quantity: str
    ) -> None:
        """Record plans that have a NaN or an infinity in one of the parts, up to their end."""
        for p in plans:
            end = min(stop, self.episodes.ends[p])
            numbers = (part[p, start:end] if part.ndim > 1 else part[p] for part in parts)
            if not all(np.isfinite(each).all() for each in numbers):
                self.failures.setdefault(int(p), NotFiniteQuantityError(quantity))

    def _intact(self, plans: Integers) -> Integers:
        return np.array([p for p in plans if p not in self.failures], np.int64)


@compiled
def adapt(
    plans: Integers, gain: Floats, regularisation: Regularisation, is_active: NDArray[np.bool_]
) -> None:
    """Adapt each plan's regularisation to the gain of its search, and check for convergence."""
    for k in range(plans.size):
        p = plans[k]
        if gain[k] > 0.0:
            lower_level(regularisation, p)
            is_active[p] = gain[k] >= SMALL_GAIN
        else:
            is_active[p] = raise_level(regularisation, p)
