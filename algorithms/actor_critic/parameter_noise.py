"""Adaptive parameter-space noise: exploration by a perturbed actor.

The actor that explores is `theta + scale * N(0, 1)`, layer normalisation's parameters excepted,
drawn at the start of each episode and of each cycle. The scale follows the distance that the
noise causes in action space,

    d = sqrt(mean (pi(s) - pi~(s))^2)   over a batch and all actions

measured with a new perturbation once per cycle, before the updates: if d > aim, the scale is
divided by 1.1, otherwise it is multiplied by 1.1.

Source: Plappert et al. (2017), as in OpenAI Baselines (adaptive-param_0.2). Differences: the factor
is 1.1, not 1.01, since a run here has a few hundred cycles, not ten thousand; and a cycle begins
with a new perturbation, as in Baselines with several environments (on Pendulum, 20,000 timesteps, 8
seeds, the mean return of ddpg rises from -683 to -476).
"""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from algorithms.experience import replay
from algorithms.experience.replay import Memory
from algorithms.networks import network
from algorithms.networks.actor import choose
from algorithms.networks.layer import Array
from algorithms.networks.parameters import Parameters
from algorithms.networks.scaling import Scaling
from algorithms.networks.shape import Shape
from physics.kernels.compiled import compiled_fast

FACTOR = 1.1
LARGEST_SCALE = 1e3
"""Without it, the scale of a saturated actor, which never reaches its aim, would grow forever."""


class ParameterNoise:
    """The noise of one run.

    Attributes:
        aim: the action distance aimed at, and the first scale.
        scale: standard deviation of the perturbation.
    """

    def __init__(self, aim: float, noisy_size: int) -> None:
        """Noise on the first `noisy_size` parameters."""
        self.aim = aim
        self.scale = aim
        self._noisy_size = noisy_size

    def perturbed(
        self, theta: NDArray[np.float32], generator: np.random.Generator
    ) -> NDArray[np.float32]:
        """A perturbed copy of theta."""
        noise = generator.standard_normal(self._noisy_size, np.float32)
        copy = theta.copy()
        copy[: self._noisy_size] += np.float32(self.scale) * noise
        return copy

    def adapt(self, distance: float) -> None:
        """Adapt the scale to the distance that a perturbation of this scale caused."""
        scale = self.scale / FACTOR if distance > self.aim else self.scale * FACTOR
        self.scale = min(scale, LARGEST_SCALE)


@compiled_fast
def action_distance(
    theta: Array,
    perturbed: Array,
    memory: Memory,
    indices: NDArray[np.int64],
    scaling: Scaling,
    shape: Shape,
) -> Any:
    """The distance d between two actors at the states `indices [B]` of the memory."""
    batch = replay.new_batch(memory, indices.size)
    replay.draw(memory, indices, scaling, batch)
    work = network.new_pass(theta, indices.size, shape)
    network.receive(work, batch.x)
    other = np.empty_like(batch.actions)
    choose(Parameters(theta, shape), work, batch.actions)
    choose(Parameters(perturbed, shape), work, other)
    total = 0.0
    for row in range(indices.size):
        for i in range(shape.outputs):
            total += (other[row, i] - batch.actions[row, i]) ** 2
    return np.sqrt(total / other.size)
