"""Expansion: dynamics to first order and cost to second order, around a trajectory.

With x = (s, a), s' = f(x), J = df/dx and the cost c(x) = -r(s, a, f(x)):

    dc/dx   = -(r_x + J' r_s')
    d2c/dx2 ~ -[I J'] G,      G = d(r_x, r_s')/dx   along the dynamics

The term `r_s' d2f/dx2` is left out: iLQR does not use second derivatives of the dynamics (unlike
DDP), and this is its Gauss-Newton approximation for a reward of the next state. G comes from
forward differences of the exact reward gradients, in one batched call: it is exact, except for
rounding, where the reward is quadratic. An action is moved towards 0, so never beyond its bounds,
where derivatives vanish. Directions along which the gradients never change (`curved_directions`)
are left out: in HalfCheetah all those of the state. The curvature is then made positive
semi-definite.

Steps after the end of an episode cost nothing, and their expansion is never read.
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from algorithms.failing_rows import call_rows
from algorithms.planning.episodes import Episodes
from algorithms.planning.semidefinite import make_semidefinite
from physics.environment import Environment, Linearization
from physics.kernels.compiled import compiled
from physics.randomness import generator

Floats = NDArray[np.float64]
Integers = NDArray[np.int64]

WIDTH = 1e-5
"""Width of the differences. Rounding is 1e-11 of a gradient, curvature changes over about 1."""
PROBES = 128
SAME = 1e-12
"""Smaller differences of gradients, relative to the largest, are rounding."""


class Expansion(NamedTuple):
    """Derivatives at every step of every plan."""

    jacobian: Floats
    """[P, T, n, n + m], J."""
    gradient: Floats
    """[P, T, n + m], dc/dx."""
    curvature: Floats
    """[P, T, n + m, n + m], d2c/dx2."""


def new_expansion(environment: Environment, plans: int) -> Expansion:
    """Arrays for the whole episodes of that many plans."""
    n, m, shape = environment.state_size, environment.action_size, (plans, environment.horizon)
    return Expansion(
        np.zeros((*shape, n, n + m)),
        np.zeros((*shape, n + m)),
        np.zeros((*shape, n + m, n + m)),
    )


def curved_directions(environment: Environment) -> Integers:
    """The coordinates of x along which the reward's gradients change anywhere, by probing.

    All of them if a probe raises, since that is not an error of any run.
    """
    every = np.arange(environment.state_size + environment.action_size)
    try:
        states, actions = environment.sample(generator(0, "curved directions"), PROBES)
        steps, _ = differentiate_around(environment, states, np.clip(actions, -1.0, 1.0), every)
    except Exception:
        return every
    gradients = np.concatenate([steps.reward_state_gradient, steps.reward_action_gradient,
                                steps.reward_next_state_gradient], axis=1)  # fmt: skip
    gradients = gradients.reshape(1 + len(every), PROBES, -1)
    change = np.abs(gradients[1:] - gradients[0]).max(axis=(1, 2))
    curved: Integers = every[change > SAME * np.abs(gradients).max()]
    return curved


def expand(
    environment: Environment,
    episodes: Episodes,
    plans: Integers,
    window: tuple[int, int],
    directions: Integers,
    expansion: Expansion,
) -> int:
    """Fill the expansion of these plans from step start to stop - 1.

    Returns:
        The number of Jacobians that were computed.

    Raises:
        Exception: as `Environment.differentiate`, at the trajectory itself.
    """
    start, stop = window
    n, m = environment.state_size, environment.action_size
    states = episodes.states[plans, start:stop].reshape(-1, n)
    actions = episodes.actions[plans, start:stop].reshape(-1, m)
    steps, widths = differentiate_around(environment, states, actions, directions)
    expand_rows(
        plans, start, directions, widths,
        steps.state_jacobian, steps.action_jacobian,
        steps.reward_state_gradient, steps.reward_action_gradient,
        steps.reward_next_state_gradient, expansion,
    )  # fmt: skip
    return (stop - start) * (1 + len(directions))


def differentiate_around(
    environment: Environment, states: Floats, actions: Floats, directions: Integers
) -> tuple[Linearization, Floats]:
    """Derivatives at rows [B] and at their neighbours along D directions, and the widths [D, B].

    The neighbours follow the rows, direction by direction: (1 + D) B rows in all. A neighbour that
    raises is replaced by the row itself, as if the gradients did not change that way.
    """
    n = environment.state_size
    x = np.concatenate([states, actions], axis=1)
    points = np.repeat(x[None], 1 + len(directions), axis=0)
    widths = np.full((len(directions), len(x)), WIDTH)
    for d, i in enumerate(directions):
        if i >= n:
            widths[d, x[:, i] > 0.0] = -WIDTH
        points[1 + d, :, i] += widths[d]
    flat = points.reshape(-1, x.shape[1])

    themselves = np.tile(np.arange(len(x)), 1 + len(directions))
    steps, _ = call_rows(
        environment.differentiate, flat[:, :n], flat[:, n:], substitutes=themselves
    )
    return steps, widths


@compiled
def expand_rows(
    plans: Integers,
    start: int,
    directions: Integers,
    widths: Floats,
    state_jacobians: Floats,
    action_jacobians: Floats,
    r_state: Floats,
    r_action: Floats,
    r_next: Floats,
    expansion: Expansion,
) -> None:
    """Fill the expansion from the derivatives at B rows and at their D B neighbours."""
    curved, rows = widths.shape
    steps = rows // plans.size
    moved = np.empty(r_state.shape[1] + r_action.shape[1])
    curvature = np.empty((curved, curved))
    D, V = np.empty_like(curvature), np.empty_like(curvature)
    for row in range(rows):
        p, t = plans[row // steps], start + row % steps
        J, gradient = expansion.jacobian[p, t], expansion.gradient[p, t]
        join(state_jacobians[row], action_jacobians[row], J)
        cost_gradient(J, r_state[row], r_action[row], r_next[row], gradient)
        for d in range(curved):
            k = (1 + d) * rows + row
            cost_gradient(J, r_state[k], r_action[k], r_next[k], moved)
            for e in range(curved):
                i = directions[e]
                curvature[e, d] = (moved[i] - gradient[i]) / widths[d, row]
        make_symmetric(curvature)
        make_semidefinite(curvature, D, V)
        for d in range(curved):
            for e in range(curved):
                expansion.curvature[p, t, directions[d], directions[e]] = curvature[d, e]


@compiled
def join(F: Floats, B: Floats, J: Floats) -> None:
    """Fill J with F and B side by side."""
    n, m = B.shape
    for i in range(n):
        for j in range(n):
            J[i, j] = F[i, j]
        for j in range(m):
            J[i, n + j] = B[i, j]


@compiled
def cost_gradient(
    J: Floats, r_state: Floats, r_action: Floats, r_next: Floats, gradient: Floats
) -> None:
    """Fill dc/dx [n + m], from the reward's gradients."""
    n, size = J.shape
    for i in range(n):
        gradient[i] = -r_state[i]
    for i in range(n, size):
        gradient[i] = -r_action[i - n]
    for k in range(n):
        for i in range(size):
            gradient[i] -= J[k, i] * r_next[k]


@compiled
def make_symmetric(A: Floats) -> None:
    """Replace A by the mean of A and its transpose."""
    for i in range(A.shape[0]):
        for j in range(i):
            A[i, j] = A[j, i] = (A[i, j] + A[j, i]) / 2.0
