"""The scale of a figure's y axis, and the smoothing of what is drawn on it.

web/static/charts/y_scale.js and limits.js do the same on the screen.
"""

import math
from dataclasses import dataclass
from typing import Literal

import numpy as np

from service.analysis.curves import Floats

OUTLIERS = 0.02
"""The share of the values at either end that a robust range leaves out."""


@dataclass(frozen=True)
class YScale:
    """A scale; `linear_within` says how far from zero an asinh axis is linear."""

    kind: Literal["linear", "log", "asinh"] = "linear"
    linear_within: float = 1.0
    floor: float = -math.inf
    """No band goes below it: half of the least value on a logarithmic axis."""

    def smooth(self, values: Floats, weight: float) -> Floats:
        """Return the debiased exponential average of values [p] as the axis shows them.

        m_k = b m_{k-1} + (1 - b) f(v_k), s_k = f^-1(m_k / (1 - b^k)), k counting finite values.
        """
        average = total = 0.0
        smoothed = np.full(len(values), np.nan)
        for place, value in enumerate(self._onto(values)):
            if np.isfinite(value):
                average = weight * average + (1.0 - weight) * float(value)
                total = weight * total + (1.0 - weight)
                smoothed[place] = average / total
        return self._back(smoothed)

    def _onto(self, values: Floats) -> Floats:
        if self.kind == "log":
            return np.log(values)
        return np.arcsinh(values / self.linear_within) if self.kind == "asinh" else values

    def _back(self, places: Floats) -> Floats:
        if self.kind == "log":
            return np.exp(places)
        return self.linear_within * np.sinh(places) if self.kind == "asinh" else places


def y_scale(values: Floats, *, is_log: bool) -> YScale:
    """Return the scale for the values of lines: positive ones alone can stand on a log axis."""
    if not is_log or not len(values):
        return YScale()
    if (least := float(values.min())) > 0:
        return YScale("log", floor=least / 2)
    largest = float(np.abs(values).max()) or 1.0
    return YScale("asinh", 10.0 ** (math.floor(math.log10(largest) - 1)))


def robust_range(values: Floats) -> tuple[float, float]:
    """Return the least and the greatest of values that are no outliers; there is at least one."""
    ordered = np.sort(values)
    left = int(OUTLIERS * (len(ordered) - 1))
    return float(ordered[left]), float(ordered[len(ordered) - 1 - left])
