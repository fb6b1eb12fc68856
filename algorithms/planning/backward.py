"""The backward pass: the best small change of every action, and its feedback on the state.

From the last step to the first, with V(s) the cost to go, J = df/dx, x = (s, a):

    Q_x  = c_x + J' V_s'              Q_xx = c_xx + J' V_s's' J
    d    = argmin  d' (Q_aa + lambda I) d / 2 + Q_a' d    with  -1 <= a + d <= 1
    G    = -(Q_aa + lambda I)^-1 Q_as    on free actions, 0 on clamped ones
    V_s  = Q_s + G' Q_aa d + G' Q_a + Q_sa d
    V_ss = Q_ss + G' Q_aa G + G' Q_as + Q_sa G

The value uses the unregularised Q, so that it is the cost to go of the policy `a + d + G ds`
itself. A change of `alpha d` is expected to lower the cost by `-(alpha slope + alpha^2 bend)`,
where slope is the sum of `Q_a' d` and bend that of `d' Q_aa d / 2`.

Regularisation. A box program that is not convex, or a plan that does not improve, raises lambda; a
better plan lowers it. Each successive increase (or decrease) is larger than the one before it:

    raise:  growth = max(growth, 1) 1.6,      lambda = max(lambda growth, 1e-6)
    lower:  growth = min(growth, 1) / 1.6,    lambda = lambda growth, 0 below 1e-6

Source: Tassa, Mansard and Todorov (2014) and their code, control-space regularisation.
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from algorithms.planning.box_qp import NOT_CONVEX, BoxWork, new_box_work, solve, solve_free
from algorithms.planning.episodes import Episodes
from algorithms.planning.expansion import Expansion
from physics.environment import Environment
from physics.kernels.compiled import compiled

Floats = NDArray[np.float64]
Integers = NDArray[np.int64]

FACTOR = 1.6
SMALLEST = 1e-6
LARGEST = 1e10


class Regularisation(NamedTuple):
    """The regularisation of each plan."""

    level: Floats
    """[P], lambda."""
    growth: Floats
    """[P], the factor that lambda was last changed by."""


def new_regularisation(plans: int) -> Regularisation:
    """Start at lambda = 1."""
    return Regularisation(np.ones(plans), np.ones(plans))


class Gains(NamedTuple):
    """The results of a backward pass, for every step of every plan."""

    change: Floats
    """[P, T, m], d."""
    feedback: Floats
    """[P, T, m, n], G."""
    slope: Floats
    """[P], the slope of the expected cost, below 0."""
    bend: Floats
    """[P]"""
    size: Floats
    """[P], mean over the steps of the largest `|d| / (|a| + 1)`."""


class Work(NamedTuple):
    """Arrays of one step."""

    V_s: Floats
    """[n]"""
    V_ss: Floats
    """[n, n]"""
    Q_x: Floats
    """[n + m]"""
    Q_xx: Floats
    """[n + m, n + m]"""
    VJ: Floats
    """[n, n + m]"""
    H: Floats
    """[m, m], regularised."""
    lower: Floats
    """[m]"""
    upper: Floats
    """[m]"""
    d: Floats
    """[m], kept as the first guess for the step before."""
    box: BoxWork


def new_gains(environment: Environment, plans: int) -> Gains:
    """Arrays for the whole episodes of that many plans."""
    n, m, horizon = environment.state_size, environment.action_size, environment.horizon
    return Gains(
        np.zeros((plans, horizon, m)),
        np.zeros((plans, horizon, m, n)),
        np.zeros(plans),
        np.zeros(plans),
        np.zeros(plans),
    )


def new_work(environment: Environment) -> Work:
    """Arrays for one step."""
    n, m = environment.state_size, environment.action_size
    return Work(
        np.empty(n), np.empty((n, n)), np.empty(n + m), np.empty((n + m, n + m)),
        np.empty((n, n + m)), np.empty((m, m)),
        np.empty(m), np.empty(m), np.empty(m), new_box_work(m),
    )  # fmt: skip


@compiled
def raise_level(regularisation: Regularisation, p: int) -> bool:
    """Regularise plan p more; False if lambda exceeds its limit."""
    growth = max(regularisation.growth[p], 1.0) * FACTOR
    regularisation.growth[p] = growth
    regularisation.level[p] = max(regularisation.level[p] * growth, SMALLEST)
    return bool(regularisation.level[p] <= LARGEST)


@compiled
def lower_level(regularisation: Regularisation, p: int) -> None:
    """Regularise plan p less."""
    growth = min(regularisation.growth[p], 1.0) / FACTOR
    level = regularisation.level[p] * growth
    regularisation.growth[p] = growth
    regularisation.level[p] = level if level >= SMALLEST else 0.0


@compiled
def backward(
    plans: Integers,
    start: int,
    stop: int,
    episodes: Episodes,
    expansion: Expansion,
    regularisation: Regularisation,
    gains: Gains,
    work: Work,
    is_possible: NDArray[np.bool_],
) -> None:
    """Fill the gains of these plans from step start to stop - 1, regularising until that succeeds.

    `is_possible [P]` is set to False for a plan that no regularisation makes convex.
    """
    for p in plans:
        end = min(stop, episodes.ends[p])
        # After the plan's end its actions stay the same, for candidates with longer episodes.
        gains.change[p, end:stop] = 0.0
        gains.feedback[p, end:stop] = 0.0
        is_possible[p] = True
        while not sweep(p, start, end, episodes, expansion, regularisation.level[p], gains, work):
            if not raise_level(regularisation, p):
                is_possible[p] = False
                break


@compiled
def sweep(
    p: int,
    start: int,
    end: int,
    episodes: Episodes,
    expansion: Expansion,
    level: float,
    gains: Gains,
    work: Work,
) -> bool:
    """One pass over the steps of plan p; False at a box program that is not convex."""
    work.V_s[:] = 0.0
    work.V_ss[:] = 0.0
    work.d[:] = 0.0
    slope, bend, size = 0.0, 0.0, 0.0
    for t in range(end - 1, start - 1, -1):
        action_value(expansion, p, t, work)
        if not improve_action(episodes.actions[p, t], level, work, gains.feedback[p, t]):
            return False
        for i in range(work.d.size):
            gains.change[p, t, i] = work.d[i]
        step_slope, step_bend = value(gains.feedback[p, t], work)
        slope += step_slope
        bend += step_bend
        size += relative_size(work.d, episodes.actions[p, t])
    gains.slope[p], gains.bend[p] = slope, bend
    gains.size[p] = size / max(end - start, 1)
    return True


@compiled
def action_value(expansion: Expansion, p: int, t: int, work: Work) -> None:
    """Fill Q from the value of the next state."""
    J, c_x, c_xx = expansion.jacobian[p, t], expansion.gradient[p, t], expansion.curvature[p, t]
    VJ, V_s, V_ss, Q_x, Q_xx = work.VJ, work.V_s, work.V_ss, work.Q_x, work.Q_xx
    n, size = J.shape
    VJ[:] = 0.0
    for i in range(n):
        for k in range(n):
            for j in range(size):
                VJ[i, j] += V_ss[i, k] * J[k, j]
    for i in range(size):
        Q_x[i] = c_x[i]
        for j in range(size):
            Q_xx[i, j] = c_xx[i, j]
    for k in range(n):
        for i in range(size):
            Q_x[i] += J[k, i] * V_s[k]
            for j in range(size):
                Q_xx[i, j] += J[k, i] * VJ[k, j]


@compiled
def improve_action(action: Floats, level: float, work: Work, feedback: Floats) -> bool:
    """Fill d and the feedback of one step; False if its box program is not convex."""
    m, n = feedback.shape
    for i in range(m):
        for j in range(m):
            work.H[i, j] = work.Q_xx[n + i, n + j] + (level if i == j else 0.0)
        work.lower[i] = -1.0 - action[i]
        work.upper[i] = 1.0 - action[i]
    free = solve(work.H, work.Q_x[n:], work.lower, work.upper, work.d, work.box)
    if free == NOT_CONVEX:
        return False
    feedback[:] = 0.0
    answer = work.box.newton
    for j in range(n):
        for k in range(free):
            answer[k] = -work.Q_xx[n + work.box.free[k], j]
        solve_free(free, work.box, answer)
        for k in range(free):
            feedback[work.box.free[k], j] = answer[k]
    return True


@compiled
def value(G: Floats, work: Work) -> tuple[float, float]:
    """Fill V of the state before the step; return its slope and its bend in alpha."""
    m, n = G.shape
    d, V_s, V_ss, Q_x, Q_xx = work.d, work.V_s, work.V_ss, work.Q_x, work.Q_xx
    slope, bend = 0.0, 0.0
    for k in range(n):
        V_s[k] = Q_x[k]
        for h in range(n):
            V_ss[k, h] = Q_xx[k, h]
    for i in range(m):
        pull = 0.0
        for j in range(m):
            pull += Q_xx[n + i, n + j] * d[j]
        slope += Q_x[n + i] * d[i]
        bend += d[i] * pull / 2.0
        for k in range(n):
            V_s[k] += G[i, k] * (pull + Q_x[n + i]) + Q_xx[n + i, k] * d[i]
    for i in range(m):
        for k in range(n):
            # (Q_aa G + Q_as)_ik belongs to G', Q_sa G stands by itself.
            both = Q_xx[n + i, k]
            for j in range(m):
                both += Q_xx[n + i, n + j] * G[j, k]
            for h in range(n):
                V_ss[h, k] += G[i, h] * both + Q_xx[h, n + i] * G[i, k]
    for k in range(n):
        for h in range(k):
            V_ss[h, k] = V_ss[k, h] = (V_ss[h, k] + V_ss[k, h]) / 2.0
    return slope, bend


@compiled
def relative_size(d: Floats, action: Floats) -> float:
    """The largest `|d| / (|a| + 1)` of one step."""
    largest = 0.0
    for i in range(d.size):
        largest = max(largest, abs(d[i]) / (abs(action[i]) + 1.0))
    return largest
