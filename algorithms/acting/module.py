"""Module: a trained policy in torch, batched and differentiable."""

from typing import Literal

import torch
from torch import nn

from algorithms.acting.policy import TrainedPolicy
from algorithms.networks.layer import Array, Layer
from physics.features import FeatureMap

ACTIVATIONS: dict[str, type[nn.Module]] = {
    "tanh": nn.Tanh, "elu": nn.ELU, "silu": nn.SiLU, "relu": nn.ReLU,
}  # fmt: skip


class PolicyModule(nn.Module):
    """The policy as a torch module; its parameters can be trained further.

    It takes features [..., F], or states [..., n], and returns actions [..., m].
    """

    def __init__(
        self, policy: TrainedPolicy, takes: Literal["features", "states"] = "features"
    ) -> None:
        """Copy the policy; `takes` says what the argument of `forward` is.

        Raises:
            ValueError: for an unknown `takes`.
        """
        super().__init__()
        if takes not in ("features", "states"):
            raise ValueError(f"takes must be 'features' or 'states', not {takes!r}")
        self.takes_states = takes == "states"
        self.clip = policy.header.feature_clip
        self.register_buffer("mean", torch.tensor(policy.mean))
        self.register_buffer("inverse_std", torch.tensor(policy.inverse_std))
        self.network = nn.Sequential(
            *(part for layer in policy.layers for part in hidden_parts(layer, policy)),
            linear(policy.output.weight, policy.output.bias),
            nn.Tanh(),
        )
        self._features: FeatureMap = policy.header.feature_map

    mean: torch.Tensor
    inverse_std: torch.Tensor

    def forward(self, given: torch.Tensor) -> torch.Tensor:
        """The actions."""
        features = self._features.features(given) if self.takes_states else given
        x = (features.to(self.mean.dtype) - self.mean) * self.inverse_std
        actions: torch.Tensor = self.network(x.clamp(-self.clip, self.clip))
        return actions


def hidden_parts(layer: Layer, policy: TrainedPolicy) -> list[nn.Module]:
    """A hidden layer: product, layer normalisation, activation."""
    norm = nn.LayerNorm(layer.bias.size, policy.header.epsilon)
    norm.weight = nn.Parameter(torch.tensor(layer.gain))
    norm.bias = nn.Parameter(torch.tensor(layer.shift))
    return [linear(layer.weight, layer.bias), norm, ACTIVATIONS[policy.header.activation]()]


def linear(weight: Array, bias: Array) -> nn.Linear:
    """A product with `weight [inputs, outputs]`."""
    inputs, outputs = weight.shape
    made = nn.Linear(inputs, outputs, device="meta")  # draws no random numbers
    made.weight = nn.Parameter(torch.tensor(weight.T))
    made.bias = nn.Parameter(torch.tensor(bias))
    return made
