"""Normalisation: the inputs of the networks, and the units in which gradients are matched.

    xhat_i = clip((f_i - mean_i) / std_i, -5, 5)          features f of a state
    Qhat   = (Q - mean_Q) / std_Q                         the critic's output
    shat_j = s_j / std_j                                  coordinates, for gradients only

Means and standard deviations of features are those of all states the run has seen, including those
that its replay has dropped. `mean_Q` and `std_Q`, the unit of Q, start at the first rewards that
are not 0, as

    mean_Q = mean(r),   std_Q = max(std(r), |mean(r)|)

so that rewards which hardly vary, such as Acrobot's -1 per step, do not make the first targets very
large. They then follow the targets (algorithms.networks.value_scale). `std_Q` is never lower than
the root mean square of all rewards so far: the targets of a constant reward become nearly constant,
which would make the unit vanish and the first other reward very large. So learning does not depend
on a constant factor of the rewards, except for rounding.

A gradient with respect to the normalised coordinates, of a quantity whose gradient in normalised
features is g, is

    sum over features i of coordinate j:   g_i  std_j / std_i  slope_i        (0 where clipped)

The spread of an angle theta with features (cos k theta, sin k theta) is that of its point on the
circle, in radians: `std^2 = (var cos + var sin) / k^2`. It equals the angle's own standard
deviation where that is small, does not depend on turns or wraps, and is never above 1/k.

Standard deviations of features have a floor of 0.001, ten times below that of MountainCar's
velocity under a random policy (Baselines' floor is 0.1).
"""

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from algorithms.networks.layer import Array
from algorithms.state import State, fill
from physics.environment import Environment
from physics.kernels.compiled import compiled, compiled_fast

CLIP = np.float32(5)
STD_FLOOR = 1e-3


class Coordinates(NamedTuple):
    """How the features of a task depend on the coordinates that networks see (C of n)."""

    seen: NDArray[np.int64]
    """[C], the coordinates that have a feature."""
    source: NDArray[np.int64]
    """[F], index into `seen` of the one coordinate that a feature depends on."""
    partner: NDArray[np.int64]
    """[F]"""
    factor: NDArray[np.float32]
    """[F], `slope_i = factor_i f_partner(i) + offset_i`."""
    offset: NDArray[np.float32]
    """[F]"""
    limit: NDArray[np.float32]
    """[F], the size at which a feature is clipped, with slope 0 from there on."""


class Scaling(NamedTuple):
    """The normalisation at one moment, in the form that kernels take."""

    mean: Array
    """[F], the means of the features."""
    inverse: Array
    """[F], 1 / std of the features."""
    unit: Array
    """[C + m], the standard deviation of each seen coordinate, then 1 for each action."""
    value_mean: Any
    value_std: Any


def coordinates_of(environment: Environment) -> Coordinates:
    """Lay out the seen coordinates of a task."""
    features = environment.feature_map
    seen, source = np.unique(features.sources, return_inverse=True)
    return Coordinates(
        seen.astype(np.int64),
        source.astype(np.int64),
        features.partners,
        features.factors.astype(np.float32),
        features.offsets.astype(np.float32),
        features.limits.astype(np.float32),
    )


class Statistics:
    """Running mean and variance of the features of one run, and the scale of its Q.

    Attributes:
        count: how many states have been seen.
        mean, squares: float64 [F], mean and sum of squared deviations of the features.
        reward_count, reward_sum, reward_squares: how many rewards were seen, their sum, and that of
            their squares.
        value_mean, value_std: the unit of Q; 0 and 1 until a reward other than 0 was seen.
    """

    def __init__(self, coordinates: Coordinates, action_size: int) -> None:
        """Start with mean 0 and standard deviation 1."""
        size = coordinates.source.size
        self.coordinates = coordinates
        self.action_size = action_size
        self.count = 0
        self.mean = np.zeros(size)
        self.squares = np.zeros(size)
        self.reward_count = 0
        self.reward_sum = 0.0
        self.reward_squares = 0.0
        self.value_mean = 0.0
        self.value_std = 1.0

    @property
    def has_unit(self) -> bool:
        """Whether rewards have set the unit of Q."""
        return self.reward_squares > 0

    def observe(self, features: NDArray[np.float32]) -> None:
        """Add states' features [b, F] to the statistics."""
        self.count = observe_rows(features, self.count, self.mean, self.squares)

    def observe_rewards(self, rewards: NDArray[np.float64]) -> None:
        """Add rewards [b] to the statistics; the first that are not all 0 set the unit of Q."""
        had_unit = self.has_unit
        self.reward_count += len(rewards)
        self.reward_sum += float(rewards.sum())
        self.reward_squares += float(np.square(rewards).sum())
        if self.has_unit and not had_unit:
            mean, square = self.reward_sum / self.reward_count, self._reward_square
            std = np.sqrt(max(square - mean**2, 0.0))
            self.value_mean, self.value_std = mean, float(max(std, abs(mean)))

    def set_value_scale(self, mean: float, std: float) -> None:
        """Set the unit of Q, its standard deviation no lower than the rewards' size."""
        self.value_mean, self.value_std = mean, max(std, float(np.sqrt(self._reward_square)))

    @property
    def _reward_square(self) -> float:
        return self.reward_squares / max(self.reward_count, 1)

    def state(self) -> State:
        """The statistics and the scale of Q."""
        return {
            "count": np.array(self.count),
            "mean": self.mean,
            "squares": self.squares,
            "rewards": np.array([self.reward_count, self.reward_sum, self.reward_squares]),
            "value_mean": np.array(self.value_mean),
            "value_std": np.array(self.value_std),
        }

    def restore(self, state: State) -> None:
        """Restore what `state` returned."""
        self.count = int(state["count"])
        fill(self.mean, state["mean"])
        fill(self.squares, state["squares"])
        count, self.reward_sum, self.reward_squares = state["rewards"].tolist()
        self.reward_count = int(count)
        self.value_mean = float(state["value_mean"])
        self.value_std = float(state["value_std"])

    def scaling(self) -> Scaling:
        """The present normalisation."""
        c = self.coordinates
        variance = self.squares / self.count if self.count else np.ones_like(self.mean)
        std = np.maximum(np.sqrt(variance), STD_FLOOR)
        unit = np.ones(c.seen.size + self.action_size, np.float32)
        unit[: c.seen.size] = coordinate_stds(variance, c)
        return Scaling(
            self.mean.astype(np.float32),
            (1.0 / std).astype(np.float32),
            unit,
            np.float32(self.value_mean),
            np.float32(self.value_std),
        )


def coordinate_stds(variance: NDArray[np.float64], c: Coordinates) -> NDArray[np.float64]:
    """The spread [C] of each seen coordinate, from the variance [F] of its features."""
    speed = np.maximum(np.abs(c.factor.astype(np.float64)), 1.0)
    sums = np.zeros(c.seen.size)
    np.add.at(sums, c.source, variance / speed**2)
    spread: NDArray[np.float64] = np.maximum(np.sqrt(sums), STD_FLOOR)
    return spread


@compiled
def observe_rows(
    features: NDArray[np.float32],
    count: int,
    mean: NDArray[np.float64],
    squares: NDArray[np.float64],
) -> int:
    """Welford's update of mean and squares, row by row; return the new count."""
    for row in range(features.shape[0]):
        count += 1
        for i in range(mean.size):
            difference = features[row, i] - mean[i]
            mean[i] += difference / count
            squares[i] += difference * (features[row, i] - mean[i])
    return count


@compiled_fast
def normalise(feature: Any, mean: Any, inverse: Any) -> Any:
    """One normalised feature."""
    return min(max((feature - mean) * inverse, -CLIP), CLIP)


@compiled_fast
def coordinate_slopes(
    features: Array, x: Array, c: Coordinates, scaling: Scaling, result: Array
) -> None:
    """`d xhat_i / d shat_source(i)` [F] of one state; 0 where the feature is clipped."""
    real = features.dtype.type
    for i in range(features.size):
        slope = c.factor[i] * features[c.partner[i]] + c.offset[i]
        slope *= scaling.inverse[i] * scaling.unit[c.source[i]]
        result[i] = slope if abs(x[i]) < CLIP else real(0)


@compiled_fast
def forget_clipped(features: Array, c: Coordinates, slopes: Array) -> None:
    """Set the slopes [F] of features that are clipped to 0, after `coordinate_slopes`.

    It has its own loop: a further condition in that one would be compiled to other roundings.
    """
    for i in range(features.size):
        if abs(features[i]) >= c.limit[i]:
            slopes[i] = slopes.dtype.type(0)
