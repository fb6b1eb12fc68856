"""Diagnostics: how well learning goes, above all whether the critic's gradient fits its target.

DDPG fits values and hopes that gradients fit as well; that they often do not is the paper's claim
(section 3.2). So it is measured for every learner, on a batch from its replay, whatever its loss:

    cosine       mean over the batch of  cos(dQ, dQhat)
    norm ratio   median of |dQ| over median of |dQhat|

each for the actions' part of the gradient and for the state's, in normalised units. Rows where a
norm is 0 have no direction and are left out; where none is left the number is NaN.
"""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from algorithms import bellman, network, replay
from algorithms.critic import own_gradient
from algorithms.ddpg_update import Report, new_work
from algorithms.network import Shape
from algorithms.optimizer import Learned
from algorithms.replay import Memory
from algorithms.scaling import Coordinates, Scaling
from algorithms.state import State
from physics.compiled import compiled_fast

Gradients = NDArray[np.float32]


class UpdateMeans:
    """The means of what updates saw, since they were last taken."""

    NAMES = (
        "critic_loss",
        "gradient_loss",
        "q_mean",
        "critic_gradient_norm",
        "actor_gradient_norm",
    )

    def __init__(self) -> None:
        """Begin with none."""
        self._cycles = np.empty((0, len(self.NAMES)), np.float32)

    def add(self, report: Report) -> None:
        """Take in a cycle's report."""
        cycle = [getattr(report, name).mean() for name in self.NAMES]
        self._cycles = np.vstack([self._cycles, np.array(cycle, np.float32)])

    def take(self) -> dict[str, float]:
        """The means by name, NaN if there were no updates; begin anew."""
        cycles, self._cycles = self._cycles, self._cycles[:0]
        if not len(cycles):
            return dict.fromkeys(self.NAMES, float("nan"))
        return {name: float(np.mean(cycles[:, i])) for i, name in enumerate(self.NAMES)}

    def state(self) -> State:
        """The means of each cycle since they were last taken [cycles, names]."""
        return {"cycles": self._cycles}

    def restore(self, state: State) -> None:
        """Take up what `state` gave."""
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


@compiled_fast
def gradient_pair(
    learned_actor: Learned,
    learned_critic: Learned,
    memory: Memory,
    coordinates: Coordinates,
    scaling: Scaling,
    gamma: Any,
    shapes: tuple[Shape, Shape],
) -> tuple[Gradients, Gradients]:
    """The critic's gradient [B, C + m] and its target, at every transition of a memory."""
    actor_shape, critic_shape = shapes
    indices = np.arange(memory.rewards.size)
    work = new_work(memory, learned_actor, learned_critic, indices.size, shapes)
    fit = work.fit
    replay.draw(memory, indices, scaling, work.batch)
    replay.draw_derivatives(memory, indices, coordinates, scaling, work.batch)
    pi_target = network.parameters(learned_actor.target, actor_shape)
    q_target = network.parameters(learned_critic.target, critic_shape)
    bellman.target_value(
        pi_target, q_target, work.batch, gamma, scaling,
        work.actor, fit.critic, work.actions, fit.value,
    )  # fmt: skip
    bellman.target_gradient(
        pi_target, q_target, work.batch, gamma, work.actor, fit.critic, work.actions, fit.target
    )
    own_gradient(
        network.parameters(learned_critic.theta, critic_shape), work.batch, coordinates, fit
    )
    return fit.gradient, fit.target
