"""A sample's mean, with its confidence interval by Student's t: 95 % unless said otherwise.

mean -+ t s / sqrt(n)        s^2 = 1/(n - 1) sum_i (y_i - mean)^2

y  the finite values    n  how many there are
t  the quantile of Student's distribution with n - 1 degrees of freedom, 97.5 % for 95 %
"""

import math
from dataclasses import dataclass

import numpy as np
from scipy.special import stdtrit

from service.analysis.curves import Floats


@dataclass(frozen=True)
class Sample:
    """NaN where a number is not defined: the mean of no values, a deviation of one."""

    n: int
    mean: float
    std: float
    low: float
    high: float


def sample(values: Floats, confidence: float = 0.95) -> Sample:
    """Summarise the finite ones of values [k]."""
    finite = values[np.isfinite(values)]
    n = len(finite)
    mean = float(finite.mean()) if n else math.nan
    if n < 2:
        return Sample(n, mean, math.nan, math.nan, math.nan)
    std = float(finite.std(ddof=1))
    reach = float(stdtrit(n - 1, (1 + confidence) / 2)) * std / math.sqrt(n)
    return Sample(n, mean, std, mean - reach, mean + reach)
