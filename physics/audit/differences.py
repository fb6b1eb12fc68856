"""Differences: a task's derivatives from its steps alone, to compare the exact ones with.

Central differences of fourth order at several widths h, each a quarter of the one before:

    D(h) = (8 [f(x + h) - f(x - h)] - [f(x + 2h) - f(x - 2h)]) / 12h

A width counts only where all of x, x +- h, x +- 2h lie in the task's domain and on one smooth
piece of the map (see `Environment.pieces`): a difference across a kink is not the derivative of
anything. The width must also be large enough for the task's own rounding
(`Environment.rounding`). For each entry, the width that agrees best with the width before it is
chosen among those that count, as in Ridders (1982). Where no two neighbouring widths count, or no
two agree to DOUBT of what they measure, the state lies at a kink: a width that is narrow enough
to fit there is too narrow to give the derivative. A quarter of the width reduces the error of
fourth order by a factor of 256, so that errors stay far below DOUBT.

Glossary: `x` is state and action together, [batch, n + m]; `y` is next state and reward together.
"""

from itertools import pairwise
from typing import NamedTuple

import numpy as np

from physics.environment import (
    BoolArray,
    Environment,
    FloatArray,
    Linearization,
    NotFiniteError,
)

WIDTHS = tuple(2e-3 / 4**k for k in range(8))
_STENCIL = np.array([1.0, -1.0, 2.0, -2.0])
_WEIGHTS = np.array([8.0, -8.0, -1.0, 1.0]) / 12.0

# A width at which rounding alone may move a difference by more than this does not count.
NOISE = 2e-7

# Below this size a derivative is compared absolutely: rounding has no relative meaning there.
SMALLEST_SCALE = 1e-3

# How far two widths may disagree, relative to the largest entry of the matrix that they measure.
DOUBT = 1e-4

# An error that falls by less than a factor of 8 from one width to the next, or by more than
# 100,000, is that of a kink.
STAYS, VANISHES = 1 / 8, 1e-5

# At this width, 8e-6, the one-sided slopes of a smooth map differ by f'' h, and at the next by a
# quarter of that. Where the difference stays, the centre is a corner, and D is the mean of its two
# slopes. A task whose rounding forbids these widths is judged by the two narrowest that it allows.
CORNER = 4


class Differences(NamedTuple):
    """Total derivatives of a step: those of the reward include its dependence on the next state."""

    jacobian: FloatArray
    """[batch, n, n + m], of the next state in (s, a)."""
    reward_gradient: FloatArray
    """[batch, n + m], of the reward in (s, a)."""
    smooth: BoolArray
    """[batch]; where False, the state lies at a kink and its row above is meaningless."""
    bent: BoolArray
    """[batch]; whether wide differences show a kink nearby that the task does not declare."""


def differences(environment: Environment, states: FloatArray, actions: FloatArray) -> Differences:
    """The derivatives of each row by central differences."""
    n = environment.state_size
    best = np.full((len(states), n + 1, n + environment.action_size), np.nan)
    least_doubt = np.full_like(best, np.inf)
    centre = environment.step(states, actions)
    y = np.concatenate([centre.next_state, centre.reward[:, None]], axis=1)
    slopes: list[FloatArray] = []
    bends: list[FloatArray] = []
    rounding = environment.rounding
    for width in (each for each in WIDTHS if rounding / each <= NOISE):
        slope, bend = _at_width(environment, states, actions, y, width)
        before = slopes[-1] if slopes else np.nan
        slopes.append(slope)
        bends.append(np.abs(bend))
        # Two narrow widths may agree by chance, so the doubt includes their rounding.
        doubt = np.abs(slope - before) + rounding / width
        better = doubt < least_doubt  # never where either is NaN
        best[better], least_doubt[better] = slope[better], doubt[better]
    scale = _scales(best, n)
    narrow = min(CORNER + 1, len(bends) - 1)
    corner = _is_any((bends[narrow] > bends[narrow - 1] / 2) & (bends[narrow] > DOUBT * scale))
    smooth = ~corner & ~_is_any(~(least_doubt <= DOUBT * scale))  # never where either is NaN
    fits = ~np.isnan(slopes[-2:]).any(axis=(0, 2, 3))
    bent = fits & (~smooth | _jumps([np.abs(slope - best) / scale for slope in slopes]))
    return Differences(best[:, :n], best[:, n], smooth, bent)


def _is_any(entries: BoolArray) -> BoolArray:
    """Whether any entry of a row's matrix is True [batch]."""
    rows: BoolArray = np.any(entries, axis=(1, 2))
    return rows


def _jumps(errors: list[FloatArray]) -> BoolArray:
    """Whether a row's errors [batch, ...], width by width, show a kink within reach of some widths.

    The errors of a smooth map fall by a factor of 256 from one width to the next. Those of a kink
    stay as they are, and vanish from the first width that does not reach it.
    """
    jumps = np.zeros(len(errors[0]), np.bool_)
    for wide, narrow in pairwise(errors):
        like_a_kink = (narrow > STAYS * wide) | (narrow < VANISHES * wide)
        jumps |= _is_any((wide > DOUBT) & like_a_kink)  # never where either is NaN
    return jumps


def relative_errors(linearization: Linearization, reference: Differences) -> FloatArray:
    """The worst relative error of each row's derivatives [batch], meaningless at a kink.

    An entry's error is relative to the largest entry of the matrix that it belongs to: the state
    Jacobian, the action Jacobian, or the reward's gradient in the state or in the action. It is
    infinite where a derivative is not finite.
    """
    n = linearization.state_jacobian.shape[1]
    wrong = ~np.all([_is_finite(field) for field in linearization[1:]], axis=0)
    jacobian, by_action_jacobian, by_state, by_action, by_next = (
        np.nan_to_num(field, nan=0.0, posinf=0.0, neginf=0.0) for field in linearization[1:]
    )
    through = by_next[:, None]
    exact = (
        jacobian,
        by_action_jacobian,
        by_state[:, None] + through @ jacobian,
        by_action[:, None] + through @ by_action_jacobian,
    )
    together = np.concatenate([reference.jacobian, reference.reward_gradient[:, None]], axis=1)
    errors = [
        np.abs(matrix - near).max(axis=(1, 2)) / _scale(matrix)
        for matrix, near in zip(exact, _matrices(together, n), strict=True)
    ]
    return np.where(wrong, np.inf, np.max(errors, axis=0))


def _is_finite(field: FloatArray) -> BoolArray:
    """Whether all of a row's numbers are finite [batch]."""
    rows: BoolArray = np.all(np.isfinite(field), axis=tuple(range(1, field.ndim)))
    return rows


def _outcomes(
    environment: Environment, states: FloatArray, actions: FloatArray
) -> tuple[FloatArray, BoolArray]:
    """Next states and rewards in one array [rows, n + 1], and which rows are not finite."""
    unknown = np.zeros(len(states), np.bool_)
    try:
        following, reward, _ = environment.step(states, actions)
    except NotFiniteError as error:
        unknown[list(error.rows)] = True
        following, reward = np.zeros_like(states), np.zeros(len(states))
        following[~unknown], reward[~unknown], _ = environment.step(
            states[~unknown], actions[~unknown]
        )
    return np.concatenate([following, reward[:, None]], axis=1), unknown


def _matrices(together: FloatArray, n: int) -> tuple[FloatArray, ...]:
    """The four matrices that are judged separately: next state and reward, by s and by a.

    They are parts of `together` [batch, n + 1, n + m].
    """
    following, reward = together[:, :n], together[:, n:]
    return following[..., :n], following[..., n:], reward[..., :n], reward[..., n:]


def _scale(matrix: FloatArray) -> FloatArray:
    """The scale of relative errors in a matrix [batch, ...]: [batch]."""
    largest: FloatArray = np.maximum(np.abs(matrix).max(axis=(1, 2)), SMALLEST_SCALE)
    return largest


def _scales(together: FloatArray, n: int) -> FloatArray:
    """`_scale` of the matrix that each entry belongs to [batch, n + 1, n + m]."""
    scales = np.empty_like(together)
    for part, matrix in zip(_matrices(scales, n), _matrices(together, n), strict=True):
        part[:] = _scale(matrix)[:, None, None]
    return scales


def _at_width(
    environment: Environment, states: FloatArray, actions: FloatArray, y: FloatArray, width: float
) -> tuple[FloatArray, FloatArray]:
    """D(width), and the forward minus the backward difference, each [batch, n + 1, n + m].

    NaN where a stencil leaves its piece or the domain; `y` [batch, n + 1] is y at the centre.
    """
    n = environment.state_size
    x = np.concatenate([states, actions], axis=1)
    batch, inputs = x.shape
    # [batch, inputs, 4, inputs]: each input alone moved to the four points of the stencil.
    points = x[:, None, None, :] + width * np.einsum("k,ij->ikj", _STENCIL, np.eye(inputs))
    flat = points.reshape(-1, inputs)
    s, a = np.ascontiguousarray(flat[:, :n]), np.ascontiguousarray(flat[:, n:])
    outside = environment.outside(s)
    s[outside] = np.repeat(states, inputs * len(_STENCIL), axis=0)[outside]  # any state will do
    around, unknown = _outcomes(environment, s, a)
    around = around.reshape(batch, inputs, 4, n + 1)
    slope: FloatArray = np.einsum("k,bikj->bji", _WEIGHTS, around) / width
    bend: FloatArray = (around[:, :, :2].sum(axis=2).swapaxes(1, 2) - 2.0 * y[..., None]) / width
    centre = environment.pieces(states, actions).piece
    pieces = environment.pieces(s, a).piece.reshape(batch, inputs, 4, centre.shape[1])
    crossing = (pieces != centre[:, None, None]).any(axis=(2, 3))
    crossing |= (outside | unknown).reshape(batch, inputs, 4).any(axis=2)
    for each in (slope, bend):
        each[np.broadcast_to(crossing[:, None], each.shape)] = np.nan
    return slope, bend
