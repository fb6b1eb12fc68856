"""Diagnostics: means over updates, and how well the critic's gradient fits its target.

DDPG fits values, and assumes that gradients fit as well; the paper claims that often they do not
(section 3.2). So the fit is measured for every learner, whatever its loss, on a batch from its
replay:

    cosine       mean over the batch of  cos(dQ, dQhat)
    norm ratio   median of |dQ| over median of |dQhat|

each for the actions' part of the gradient and for the state's, in normalised units. Rows where a
norm is 0 have no direction and are left out; if none is left, the number is NaN.
"""

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from algorithms.experience.replay import Memory, Replay
from algorithms.experience.target_jacobian import fold
from algorithms.networks.scaling import Coordinates
from algorithms.state import State
from physics.environment import Environment

Gradients = NDArray[np.float32]
NO_AGREEMENT = {
    name: float("nan")
    for part in ("state", "action")
    for name in (
        f"{part}_gradient_cosine",
        f"{part}_gradient_norm_ratio",
        f"target_{part}_gradient_norm",
    )
}
"""The result of `agreement` where there are no gradients to compare."""


class UpdateMeans:
    """The means of the updates' reports since they were last taken.

    Attributes:
        names: the names of the fields of a report.
    """

    def __init__(self, names: Sequence[str]) -> None:
        """Begin without reports."""
        self.names = names
        self._cycles = np.empty((0, len(names)), np.float32)

    def add(self, report: Any) -> None:
        """Add a cycle's report, whose fields of these names are arrays [updates]."""
        cycle = [getattr(report, name).mean(dtype=np.float64) for name in self.names]
        self._cycles = np.vstack([self._cycles, np.array(cycle, np.float32)])

    def take(self) -> dict[str, float]:
        """Return the means by name, NaN if there were no updates, and start again."""
        cycles, self._cycles = self._cycles, self._cycles[:0]
        if not len(cycles):
            return dict.fromkeys(self.names, float("nan"))
        means = cycles.mean(axis=0, dtype=np.float64)
        return {name: float(mean) for name, mean in zip(self.names, means, strict=True)}

    def state(self) -> State:
        """The means of each cycle since they were last taken [cycles, names]."""
        return {"cycles": self._cycles}

    def restore(self, state: State) -> None:
        """Restore what `state` returned."""
        self._cycles = state["cycles"]


def agreement(gradient: Gradients, target: Gradients, coordinates: Coordinates) -> dict[str, float]:
    """Cosine and norm ratio of `gradient [B, C + m]` and its target, by name."""
    seen = coordinates.seen.size
    parts = {"state": slice(None, seen), "action": slice(seen, None)}
    numbers = {}
    for name, columns in parts.items():
        own, aim = (g[:, columns].astype(np.float64) for g in (gradient, target))
        own_norm, aim_norm = np.linalg.norm(own, axis=1), np.linalg.norm(aim, axis=1)
        product = own_norm * aim_norm
        directed = product > 0
        cosines = (own * aim).sum(axis=1)[directed] / product[directed]
        median = float(np.median(aim_norm))
        numbers[f"{name}_gradient_cosine"] = float(cosines.mean()) if directed.any() else np.nan
        numbers[f"{name}_gradient_norm_ratio"] = (
            float(np.median(own_norm)) / median if median > 0 else np.nan
        )
        numbers[f"target_{name}_gradient_norm"] = median
    return numbers


def with_derivatives(
    environment: Environment,
    coordinates: Coordinates,
    replay: Replay,
    indices: NDArray[np.int64],
) -> Memory:
    """Transitions of a replay, with derivatives recomputed from the states."""
    actions = replay.memory.actions[indices].astype(np.float64)
    steps = environment.differentiate(replay.states[indices], actions)
    memory = replay.memory
    reward_gradients, jacobians = fold(environment, coordinates, steps)
    return Memory(
        features=memory.features[indices],
        actions=memory.actions[indices],
        rewards=memory.rewards[indices],
        next_features=memory.next_features[indices],
        continues=memory.continues[indices],
        reward_gradients=reward_gradients,
        jacobians=jacobians,
    )
