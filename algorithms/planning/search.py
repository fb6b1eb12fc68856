"""The line search: how far to follow the backward pass, tried in parallel.

    a_t = clip(abar_t + alpha d_t + G_t (s_t - sbar_t), -1, 1),     s_{t+1} = f(s_t, a_t)

for eleven alphas from 1 to 0.001, with all alphas and all plans in one batch of each simulator
step. The best candidate becomes the plan, if its return is higher and an improvement was expected;
no plan ever gets worse.

A candidate that the task ends has no further rewards, and that counts in the comparison, although
no derivative shows it. A candidate beyond 1e8, or with a step that raises, is discarded.

Source: Tassa, Mansard and Todorov (2014) and their code (z_min = 0).
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from algorithms.failing_rows import call_rows
from algorithms.planning.backward import Gains
from algorithms.planning.episodes import Episodes, window_return
from physics.environment import BoolArray, Environment
from physics.kernels.compiled import compiled

Floats = NDArray[np.float64]
Integers = NDArray[np.int64]

ALPHAS = 10.0 ** np.linspace(0.0, -3.0, 11)
BOUND = 1e8


class Candidates(NamedTuple):
    """Trajectories of every plan under every alpha, one row each (P A), time first."""

    states: Floats
    """[steps + 1, P A, n]"""
    actions: Floats
    """[steps, P A, m]"""
    rewards: Floats
    """[steps, P A]"""
    ends: Integers
    """[P A], steps of the window after which the task has ended the episode; T if it has not."""
    is_out: BoolArray
    """[P A], whether a candidate is discarded."""


def search(
    environment: Environment,
    plans: Integers,
    window: tuple[int, int],
    episodes: Episodes,
    gains: Gains,
) -> Floats:
    """Improve these plans where possible; return the gain in return of each [len(plans)], or 0.

    Only the window's own steps are updated; the steps after it belong to the old plan.
    """
    candidates = try_alphas(environment, plans, window, episodes, gains)
    gain = np.zeros(len(plans))
    keep_best(plans, window[0], window[1], episodes, gains, ALPHAS, candidates, gain)
    return gain


def try_alphas(
    environment: Environment,
    plans: Integers,
    window: tuple[int, int],
    episodes: Episodes,
    gains: Gains,
) -> Candidates:
    """Roll out every candidate."""
    start, stop = window
    steps, rows = stop - start, len(plans) * len(ALPHAS)
    candidates = Candidates(
        np.empty((steps + 1, rows, environment.state_size)),
        np.empty((steps, rows, environment.action_size)),
        np.empty((steps, rows)),
        np.full(rows, environment.horizon),
        np.zeros(rows, np.bool_),
    )
    candidates.states[0] = np.repeat(episodes.states[plans, start], len(ALPHAS), axis=0)
    for i in range(steps):
        choose(plans, start, i, episodes, gains, ALPHAS, candidates)
        transition, failed = call_rows(
            environment.step, candidates.states[i], candidates.actions[i]
        )
        if transition is None:
            candidates.is_out[:] = True
            break
        is_unsolved = np.zeros(rows, np.bool_)
        is_unsolved[list(failed)] = True
        note(i, *transition, is_unsolved, candidates)
    return candidates


@compiled
def choose(
    plans: Integers,
    start: int,
    i: int,
    episodes: Episodes,
    gains: Gains,
    alphas: Floats,
    candidates: Candidates,
) -> None:
    """Fill in the candidates' actions at step i of the window."""
    t = start + i
    for row in range(candidates.ends.size):
        p, alpha = plans[row // alphas.size], alphas[row % alphas.size]
        s, sbar, G = candidates.states[i, row], episodes.states[p, t], gains.feedback[p, t]
        for k in range(candidates.actions.shape[2]):
            a = episodes.actions[p, t, k] + alpha * gains.change[p, t, k]
            for j in range(s.size):
                a += G[k, j] * (s[j] - sbar[j])
            candidates.is_out[row] |= np.isnan(a)
            candidates.actions[i, row, k] = 0.0 if np.isnan(a) else min(max(a, -1.0), 1.0)


@compiled
def note(
    i: int,
    next_states: Floats,
    rewards: Floats,
    terminated: BoolArray,
    is_unsolved: BoolArray,
    candidates: Candidates,
) -> None:
    """Store the results of step i of the window; a candidate that is over or discarded stays."""
    for row in range(candidates.ends.size):
        is_out = is_unsolved[row]
        for j in range(next_states.shape[1]):
            is_out |= not abs(next_states[row, j]) < BOUND
        is_running = not candidates.is_out[row] and candidates.ends[row] > i
        goes_on = is_running and not is_out
        candidates.is_out[row] |= is_running and is_out
        for j in range(next_states.shape[1]):
            here = candidates.states[i, row, j]
            candidates.states[i + 1, row, j] = next_states[row, j] if goes_on else here
        candidates.rewards[i, row] = rewards[row] if goes_on else 0.0
        if goes_on and terminated[row]:
            candidates.ends[row] = i + 1


@compiled
def keep_best(
    plans: Integers,
    start: int,
    stop: int,
    episodes: Episodes,
    gains: Gains,
    alphas: Floats,
    candidates: Candidates,
    gain: Floats,
) -> None:
    """Replace each plan by its best candidate, if that is better; store the gain."""
    for k in range(plans.size):
        p = plans[k]
        before = window_return(episodes, p, start, stop)
        best = -1
        for a in range(alphas.size):
            row = k * alphas.size + a
            expected = -alphas[a] * (gains.slope[p] + alphas[a] * gains.bend[p])
            more = candidate_return(candidates, row) - before
            if not candidates.is_out[row] and expected > 0.0 and more > gain[k]:
                best, gain[k] = row, more
        if best >= 0:
            adopt(p, start, stop, episodes, candidates, best)


@compiled
def adopt(
    p: int, start: int, stop: int, episodes: Episodes, candidates: Candidates, row: int
) -> None:
    """Replace a plan by a candidate."""
    for t in range(start, stop):
        i = t - start
        episodes.rewards[p, t] = candidates.rewards[i, row]
        for k in range(episodes.actions.shape[2]):
            episodes.actions[p, t, k] = candidates.actions[i, row, k]
        for j in range(episodes.states.shape[2]):
            episodes.states[p, t + 1, j] = candidates.states[i + 1, row, j]
    episodes.ends[p] = min(start + candidates.ends[row], episodes.rewards.shape[1])


@compiled
def candidate_return(candidates: Candidates, row: int) -> float:
    """The rewards of one candidate, added in their order."""
    total = 0.0
    for i in range(candidates.rewards.shape[0]):
        total += candidates.rewards[i, row]
    return total
