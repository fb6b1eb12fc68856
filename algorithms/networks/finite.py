"""Whether numbers are finite, in kernels that may reorder sums (`compiled_fast`).

`numpy.isfinite(x)` compiles to a test of `x - x` for NaN, and where sums may be reordered, `x - x`
is 0 for every x: the test is compiled to True. A comparison cannot be reordered.
"""

from typing import Any

import numpy as np

from physics.kernels.compiled import compiled_fast

INFINITY = np.inf


@compiled_fast
def is_finite(x: Any) -> Any:
    """Whether x is neither NaN nor an infinity."""
    return abs(x) < INFINITY


@compiled_fast
def first_not_finite(values: Any) -> int:
    """The index of the first of a tuple of numbers of one type that is not finite, or -1."""
    for i in range(len(values)):
        if not is_finite(values[i]):
            return i
    return -1
