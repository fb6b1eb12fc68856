"""Growth: how fast gradients grow or vanish along a policy's episodes.

    A_t = J_s + J_a dpi/ds,    P = A_{t+H-1} ... A_t = d s_{t+H} / d s_t

The norm of P bounds how much a gradient grows over H steps backwards. If the norm grows by a factor
in each step, the system is chaotic under this policy, and the variance of the exact gradient of a
long return grows by the square of that factor, however exact the derivatives are.

Source: Metz et al. (2021), "Gradients are not all you need".
"""

from collections.abc import Sequence

import numpy as np

from algorithms.diagnostics.closed_loop import Rollouts
from physics.environment import FloatArray

WINDOWS = 512
"""The largest number of norms for each horizon."""


def closed_loop_jacobians(rollouts: Rollouts, units: FloatArray) -> FloatArray:
    """A_t [T, b, C, C] in the coordinates whose `units` [n] are not 0, each in its unit."""
    jacobians = rollouts.state_jacobian + rollouts.action_jacobian @ rollouts.policy_jacobian
    seen = np.flatnonzero(units)
    kept = jacobians[:, :, seen[:, None], seen]
    scaled: FloatArray = kept * units[seen] / units[seen][:, None]
    return scaled


def product_norms(
    jacobians: FloatArray, lengths: Sequence[int], horizons: Sequence[int]
) -> dict[int, FloatArray]:
    """Spectral norms of P, by horizon, of windows that are spread over all episodes.

    Args:
        jacobians: A_t [T, b, C, C].
        lengths: the lengths of the episodes [b].
        horizons: the values of H; those longer than all episodes have no norms.
    """
    norms = {}
    for horizon in horizons:
        starts = [
            (t, e) for e, length in enumerate(lengths) for t in range(int(length) - horizon + 1)
        ]
        chosen = starts[:: -(-len(starts) // WINDOWS) or 1]
        norms[horizon] = np.array([product_norm(jacobians[t : t + horizon, e]) for t, e in chosen])
    return norms


def product_norm(jacobians: FloatArray) -> float:
    """The spectral norm of the product of matrices [H, C, C], the last one leftmost."""
    product = np.eye(jacobians.shape[-1])
    for each in jacobians:
        product = each @ product
    return float(np.linalg.norm(product, 2))
