"""Features: what a network sees of a state.

    an angle theta of multiplicity k  ->  cos(k theta), sin(k theta)     in the angle's place
    a hidden coordinate               ->  nothing
    any other coordinate              ->  itself, clipped to [-limit, limit] where it has a limit

Each feature depends on one coordinate alone, and its slope is a linear function of the features,
but 0 where the feature is clipped:

    d cos(k theta) / d theta = -k sin(k theta),   d sin(k theta) / d theta = k cos(k theta)

so a gradient with respect to features, `G [batch, F]`, becomes one with respect to the state by
adding `G * slopes` to the columns that `sources` names.

Glossary: `n` coordinates of a state, `F` features.
"""

from collections.abc import Mapping, Sequence
from math import inf
from types import MappingProxyType
from typing import Any, TypeVar, cast

import numpy as np
from array_api_compat import array_namespace
from numpy.typing import NDArray

from physics.kernels.compiled import compiled

Array = TypeVar("Array", bound=Any)

_ITSELF, _COS, _SIN = 0, 1, 2
NOTHING: Mapping[int, float] = MappingProxyType({})


class FeatureMap:
    """The map from states to features, with its derivative.

    Attributes:
        size: F.
        sources: int64 [F], the coordinate each feature depends on.
        partners: int64 [F], the feature each slope is proportional to.
        factors, offsets: float64 [F], `slope_i = factor_i * feature_partner(i) + offset_i`.
        limits: float64 [F], infinite for a feature that is not clipped; at its limit, as beyond,
            a feature's slope is 0.
    """

    def __init__(
        self,
        state_size: int,
        angles: Mapping[int, int],
        hidden: tuple[int, ...],
        clipped: Mapping[int, float] = NOTHING,
        order: Sequence[int] = (),
    ) -> None:
        """Lay out the features of a state.

        Args:
            state_size: n.
            angles: coordinate -> multiplicity k.
            hidden: coordinates that no feature shows.
            clipped: coordinate -> the limit of its feature.
            order: the index of each feature in the order of the coordinates; empty for that order.
        """
        rows: list[tuple[int, int, int, float, float, float]] = []
        for coordinate in range(state_size):
            here = len(rows)
            if coordinate in angles:
                k = angles[coordinate]
                rows.append((coordinate, _COS, here + 1, -k, 0.0, inf))
                rows.append((coordinate, _SIN, here, k, 0.0, inf))
            elif coordinate not in hidden:
                limit = clipped.get(coordinate, inf)
                rows.append((coordinate, _ITSELF, here, 0.0, 1.0, limit))
        places = list(order) or list(range(len(rows)))
        rows = [rows[place] for place in places]
        sources, kinds, partners, factors, offsets, limits = zip(*rows, strict=True)
        self.size = len(rows)
        self.sources: NDArray[np.int64] = np.array(sources, np.int64)
        self.partners: NDArray[np.int64] = np.argsort(places)[list(partners)]
        self.factors: NDArray[np.float64] = np.array(factors, np.float64)
        self.offsets: NDArray[np.float64] = np.array(offsets, np.float64)
        self.limits: NDArray[np.float64] = np.array(limits, np.float64)
        self._kinds: NDArray[np.int64] = np.array(kinds, np.int64)
        self._state_size = state_size

    def features(self, states: Array) -> Array:
        """The features [batch, F] of states [batch, n]; torch tensors stay differentiable.

        Numpy arrays go through a compiled kernel: numpy's own vectorised cosine may round a number
        differently at another place of the array, and a row must not depend on its neighbours.
        """
        if isinstance(states, np.ndarray):
            return cast("Array", self._numpy_features(states))
        xp = array_namespace(states)
        columns = [
            self._feature(xp, i, states[..., source]) for i, source in enumerate(self.sources)
        ]
        return cast("Array", xp.stack(columns, axis=-1))

    def slopes(self, features: Array) -> Array:
        """The slopes [batch, F] of the features, each in its own source coordinate."""
        if isinstance(features, np.ndarray):
            slopes = features[..., self.partners] * self.factors + self.offsets
            return cast("Array", slopes * (np.abs(features) < self.limits.astype(features.dtype)))
        xp = array_namespace(features)
        like = {"dtype": features.dtype, "device": features.device}
        factors, offsets = xp.asarray(self.factors, **like), xp.asarray(self.offsets, **like)
        partners = xp.take(features, xp.asarray(self.partners), axis=-1)
        within = xp.abs(features) < xp.asarray(self.limits, **like)
        return cast("Array", (partners * factors + offsets) * within)

    def _feature(self, xp: Any, i: int, column: Any) -> Any:
        """Feature i of its coordinate's column."""
        if self._kinds[i] == _COS:
            return xp.cos(-self.factors[i] * column)
        if self._kinds[i] == _SIN:
            return xp.sin(self.factors[i] * column)
        limit = self.limits[i]
        return xp.clip(column, -limit, limit) if limit < inf else column

    def _numpy_features(self, states: NDArray[np.float64]) -> NDArray[np.float64]:
        if states.dtype != np.float64 or states.ndim != 2 or states.shape[1] != self._state_size:
            raise ValueError(
                f"states must be float64 [batch, {self._state_size}], "
                f"not {states.dtype} {list(states.shape)}"
            )
        if not states.flags.carray:
            states = states.copy(order="C")
        features = np.empty((len(states), self.size))
        feature_rows(states, self.sources, self._kinds, self.factors, self.limits, features)
        return features


@compiled
def feature_rows(
    states: NDArray[np.float64],
    sources: NDArray[np.int64],
    kinds: NDArray[np.int64],
    factors: NDArray[np.float64],
    limits: NDArray[np.float64],
    features: NDArray[np.float64],
) -> None:
    """Fill `features [batch, F]` from `states [batch, n]`; `|factor|` is an angle's k."""
    for row in range(states.shape[0]):
        for i in range(sources.size):
            value = states[row, sources[i]]
            if kinds[i] == _COS:
                value = np.cos(-factors[i] * value)
            elif kinds[i] == _SIN:
                value = np.sin(factors[i] * value)
            elif abs(value) > limits[i]:
                value = np.copysign(limits[i], value)
            features[row, i] = value
