"""The unit of Q follows its targets, without changing Q (PopArt); Adam's moments are converted.

With r = std / std_new, the output layer of a network that returns a normalised Q becomes

    weight <- weight r,   bias <- bias r + (mean - mean_new) / std_new

The squared loss of that network is in units of std^2, so that its gradient in the new unit is r
times the old one for the output layer, and r^2 times for the layers before it. Adam's moments
become those that they would be if every gradient so far had been computed in the new unit:

    output layer       m <- m r,     v <- v r^2
    hidden layers      m <- m r^2,   v <- v r^4

Without that, second moments in a unit that was too small would keep the network from changing for
the thousand updates that Adam remembers. Two parts of a critic's gradient do not change with the
unit: those of weight decay and of the cosine loss. They are small compared with the squared loss
when the unit changes much.

Source: van Hasselt et al. (2016). Differences: Adam's moments follow; the standard deviation is
taken about the previous mean, so that a Q that drifts does not make it vanish.
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from algorithms.early_end import NotFiniteQuantityError
from algorithms.networks.optimizer import Learned
from algorithms.networks.parameters import Parameters, output_layer
from algorithms.networks.scaling import Statistics
from algorithms.networks.shape import Shape


class UnitChange(NamedTuple):
    """A change of the unit of Q: a normalised value q is now `q ratio + shift`."""

    ratio: float
    """r, old unit / new unit."""
    shift: float


def move_value_scale(
    statistics: Statistics, target_mean: float, target_square: float
) -> UnitChange:
    """Set the unit of Q to the targets' moments, once rewards have shown one.

    Args:
        statistics: those of the run; its value scale is changed.
        target_mean: mean of the targets, in the unit so far.
        target_square: mean of their squares, in the unit so far.
    """
    if not statistics.has_unit:
        return UnitChange(1.0, 0.0)
    mean, std = statistics.value_mean, statistics.value_std
    statistics.set_value_scale(mean + std * target_mean, std * float(np.sqrt(target_square)))
    return UnitChange(
        std / statistics.value_std, (mean - statistics.value_mean) / statistics.value_std
    )


def rewrite_fit(fitted: Learned, shape: Shape, change: UnitChange) -> None:
    """Rewrite a network in training, and its target, to return the same Q in the new unit.

    Args:
        fitted: a network trained on a squared loss in that unit.
        shape: its sizes.
        change: the change of the unit.
    """
    ratio, shift = np.float32(change.ratio), np.float32(change.shift)
    for theta in (fitted.theta, fitted.target):
        if theta.size:
            last = output_layer(Parameters(theta, shape))
            last.weight[:] *= ratio
            last.bias[:] = last.bias * ratio + shift
    by_parameter = np.full(fitted.theta.size, ratio**2)
    last = output_layer(Parameters(by_parameter, shape))
    last.weight[:] = last.bias[:] = ratio
    rescale_moments(fitted, by_parameter)


def rescale_moments(trained: Learned, factor: NDArray[np.float32] | np.float32) -> None:
    """Rescale Adam's moments as if all gradients had been multiplied by `factor`, one or [P].

    Raises:
        NotFiniteQuantityError: if moments overflow float32.
    """
    with np.errstate(over="ignore", invalid="ignore", under="ignore"):
        trained.m[:] *= factor
        trained.v[:] *= factor**2
    if not np.isfinite(trained.v).all():
        raise NotFiniteQuantityError("moments of Adam")
