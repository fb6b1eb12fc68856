"""Small tasks as a user writes them in torch; each but the first has one thing to be noticed."""

import numpy as np
import torch

from physics.drawing import Drawing, disc
from physics.environment import FloatArray
from physics.torch_environment import TorchEnvironment


class Plain(TorchEnvironment):
    """A mass pushed along a line."""

    name = "Plain"
    version = 1
    state_size = 2
    action_size = 1
    horizon = 50
    max_reward = 0.0

    def dynamics(self, state: torch.Tensor, action: torch.Tensor) -> torch.Tensor:
        return torch.stack([state[0] + 0.1 * state[1], state[1] + 0.1 * action[0]])

    def reward(
        self, state: torch.Tensor, action: torch.Tensor, next_state: torch.Tensor
    ) -> torch.Tensor:
        del state, action
        return -(next_state**2).sum()

    def initial_state(self, generator: np.random.Generator) -> FloatArray:
        return generator.uniform(-1.0, 1.0, 2)

    def draw(self, state: FloatArray) -> Drawing:
        return Drawing((-1.0, -1.0, 1.0, 1.0), (disc((float(state[0]), 0.0), 0.1, "body"),))


class LogOfNegative(Plain):
    """A step that leaves the numbers."""

    name = "LogOfNegative"

    def dynamics(self, state: torch.Tensor, action: torch.Tensor) -> torch.Tensor:
        x, v = state
        return torch.stack([torch.log(x + 0.1 * v), v + 0.1 * action[0]])


class DistanceAtGoal(Plain):
    """A distance as reward, started at the goal: sqrt has no derivative at 0."""

    name = "DistanceAtGoal"

    def dynamics(self, state: torch.Tensor, action: torch.Tensor) -> torch.Tensor:
        push = torch.where(action[0].abs() > 0.9, action[0], 0 * action[0])
        return torch.stack([state[0] + 0.1 * state[1], state[1] + 0.1 * push])

    def reward(
        self, state: torch.Tensor, action: torch.Tensor, next_state: torch.Tensor
    ) -> torch.Tensor:
        del state, action
        return -torch.sqrt((next_state**2).sum())

    def initial_state(self, generator: np.random.Generator) -> FloatArray:
        del generator
        return np.zeros(2)
