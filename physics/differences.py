"""Differences: a task's derivatives from its steps alone, to hold the exact ones against.

Fourth-order central differences at a ladder of widths h, each a quarter of the one before:

    D(h) = (8 [f(x + h) - f(x - h)] - [f(x + 2h) - f(x - 2h)]) / 12h

A width counts only where all of x, x +- h, x +- 2h lie in the task's domain and on one smooth
piece of the map (see `Environment.pieces`): a difference across a kink is no derivative of
anything. Of the widths that count, the one that agrees best with the width before it is taken,
entry by entry (Ridders 1982 chooses so). Where no two neighbouring widths count, or none agree to
DOUBT of what they measure, the state lies at a kink: a width narrow enough to fit there tells the
derivative no more. A quarter of the width makes the fourth order 256 times better: errors stay far
below DOUBT.

Glossary: `x` is state and action together, [batch, n + m]; `y` is next state and reward together.
"""

from typing import NamedTuple

import numpy as np

from physics.environment import BoolArray, Environment, FloatArray, Linearization

WIDTHS = tuple(2e-3 / 4**k for k in range(8))
_STENCIL = np.array([1.0, -1.0, 2.0, -2.0])
_WEIGHTS = np.array([8.0, -8.0, -1.0, 1.0]) / 12.0

ROUNDING = 1e-15  # of a step's numbers, which are of order 1 to 10

# Below this size a derivative is compared absolutely: rounding has no relative meaning there.
SMALLEST_SCALE = 1e-3

# How far two widths may disagree, relative to the largest entry of the matrix that they measure.
DOUBT = 1e-4


class Differences(NamedTuple):
    """Total derivatives of a step: the reward's include its way through the next state."""

    jacobian: FloatArray
    """[batch, n, n + m], of the next state in (s, a)."""
    reward_gradient: FloatArray
    """[batch, n + m], of the reward in (s, a)."""
    smooth: BoolArray
    """[batch]; where False the state lies at a kink and its row above means nothing."""


def differences(environment: Environment, states: FloatArray, actions: FloatArray) -> Differences:
    """The derivatives of each row by central differences."""
    n = environment.state_size
    best = np.full((len(states), n + 1, n + environment.action_size), np.nan)
    least_doubt = np.full_like(best, np.inf)
    before = best.copy()
    for width in WIDTHS:
        now = _at_width(environment, states, actions, width)
        # Two narrow widths may agree by chance: rounding alone speaks against them.
        doubt = np.abs(now - before) + ROUNDING / width
        better = doubt < least_doubt  # never where either is NaN
        best[better], least_doubt[better] = now[better], doubt[better]
        before = now
    smooth = np.ones(len(states), np.bool_)
    for near, doubt in zip(_matrices(best, n), _matrices(least_doubt, n), strict=True):
        smooth &= doubt.max(axis=(1, 2)) <= DOUBT * _scale(near)  # never where either is NaN
    return Differences(best[:, :n], best[:, n], smooth)


def relative_errors(linearization: Linearization, reference: Differences) -> FloatArray:
    """The worst relative error of each row's derivatives [batch], meaningless at a kink.

    Relative to the largest entry of the matrix that the entry stands in: state Jacobian, action
    Jacobian, the reward's gradient in the state and in the action, each by itself.
    """
    n = linearization.state_jacobian.shape[1]
    through = linearization.reward_next_state_gradient[:, None]
    by_state = linearization.reward_state_gradient[:, None] + through @ linearization.state_jacobian
    by_action = (
        linearization.reward_action_gradient[:, None] + through @ linearization.action_jacobian
    )
    exact = linearization.state_jacobian, linearization.action_jacobian, by_state, by_action
    together = np.concatenate([reference.jacobian, reference.reward_gradient[:, None]], axis=1)
    errors = [
        np.abs(matrix - near).max(axis=(1, 2)) / _scale(matrix)
        for matrix, near in zip(exact, _matrices(together, n), strict=True)
    ]
    worst: FloatArray = np.max(errors, axis=0)
    return worst


def _matrices(together: FloatArray, n: int) -> tuple[FloatArray, ...]:
    """The four judged apart, of [batch, n + 1, n + m]: next state and reward, by s and by a."""
    following, reward = together[:, :n], together[:, n:]
    return following[..., :n], following[..., n:], reward[..., :n], reward[..., n:]


def _scale(matrix: FloatArray) -> FloatArray:
    """What an error in a matrix [batch, ...] is relative to [batch]."""
    largest: FloatArray = np.maximum(np.abs(matrix).max(axis=(1, 2)), SMALLEST_SCALE)
    return largest


def _at_width(
    environment: Environment, states: FloatArray, actions: FloatArray, width: float
) -> FloatArray:
    """D(width) [batch, n + 1, n + m], NaN where a stencil leaves its piece or the domain."""
    n = environment.state_size
    x = np.concatenate([states, actions], axis=1)
    batch, inputs = x.shape
    # [batch, inputs, 4, inputs]: every input moved by itself to the four points of the stencil.
    points = x[:, None, None, :] + width * np.einsum("k,ij->ikj", _STENCIL, np.eye(inputs))
    flat = points.reshape(-1, inputs)
    s, a = np.ascontiguousarray(flat[:, :n]), np.ascontiguousarray(flat[:, n:])
    outside = environment.outside(s)
    s[outside] = np.repeat(states, inputs * len(_STENCIL), axis=0)[outside]
    transition = environment.step(s, a)
    y = np.concatenate([transition.next_state, transition.reward[:, None]], axis=1)
    slope: FloatArray = (
        np.einsum("k,bikj->bji", _WEIGHTS, y.reshape(batch, inputs, 4, n + 1)) / width
    )
    centre = environment.pieces(states, actions).piece
    around = environment.pieces(s, a).piece.reshape(batch, inputs, 4, -1)
    crossing = (around != centre[:, None, None]).any(axis=(2, 3))
    crossing |= outside.reshape(batch, inputs, -1).any(axis=2)
    slope[np.broadcast_to(crossing[:, None], slope.shape)] = np.nan
    return slope
