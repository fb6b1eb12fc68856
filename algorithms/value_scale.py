"""The unit of Q follows its targets, and Q stays what it is (PopArt).

    weight <- weight std / std_new,   bias <- (bias std + mean - mean_new) / std_new

Source: van Hasselt et al. (2016). The standard deviation is taken about the previous mean, so that
a Q that drifts does not make it vanish.
"""

from collections.abc import Iterable

import numpy as np

from algorithms.network import Parameters
from algorithms.scaling import Statistics


def move_value_scale(
    statistics: Statistics, target_mean: float, target_square: float, networks: Iterable[Parameters]
) -> None:
    """Set the unit of Q to the targets' moments, and change the networks that return it.

    Args:
        statistics: of the run; its value scale is moved.
        target_mean: mean of the targets, in the unit so far.
        target_square: mean of their squares, in the unit so far.
        networks: all whose output is in that unit.
    """
    mean, std = statistics.value_mean, statistics.value_std
    statistics.set_value_scale(mean + std * target_mean, std * float(np.sqrt(target_square)))
    ratio = np.float32(std / statistics.value_std)
    shift = np.float32((mean - statistics.value_mean) / statistics.value_std)
    for network in networks:
        network.weight[:] *= ratio
        network.bias[:] = network.bias * ratio + shift
