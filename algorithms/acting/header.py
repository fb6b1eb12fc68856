"""Header: the metadata in a policy's file, beside its arrays."""

from collections.abc import Mapping
from dataclasses import asdict, field
from typing import Any, Literal

from pydantic import ConfigDict
from pydantic.dataclasses import dataclass

from algorithms.networks.layer import EPSILON
from algorithms.networks.scaling import CLIP
from physics.features import FeatureMap


@dataclass(frozen=True, config=ConfigDict(extra="forbid", allow_inf_nan=False))
class Header:
    """The task in which a policy acts, and how its arrays give an action.

    Attributes:
        task: the name of the task.
        task_version: the version of the task in training.
        parameters: the values of the task's physical parameters, and those of noise if given.
        state_size: n, the coordinates of a state.
        angles: coordinate -> multiplicity k; its features are cos(k theta), sin(k theta).
        hidden: coordinates without a feature.
        action_size: m.
        activation: "tanh", "elu", "silu" or "relu", of hidden units.
        hidden_units: the number of units of each hidden layer.
        clipped: coordinate -> limit; its feature is clipped to [-limit, limit].
        feature_order: the index of each feature in the order of the coordinates; empty for that
            order.
        origin: where the policy comes from: algorithm, seed, timestep, weights, config, run.
        action_low, action_high: the box of the actions.
        feature_clip: normalised features are clipped to [-feature_clip, feature_clip].
        epsilon: what layer normalisation adds to variances.
        format: the version of the file's format.
    """

    task: str
    task_version: int
    parameters: dict[str, float]
    state_size: int
    angles: dict[int, int]
    hidden: list[int]
    action_size: int
    activation: Literal["tanh", "elu", "silu", "relu"]
    hidden_units: list[int]
    clipped: dict[int, float] = field(default_factory=dict)
    feature_order: list[int] = field(default_factory=list)
    origin: Mapping[str, Any] = field(default_factory=dict)
    action_low: float = -1.0
    action_high: float = 1.0
    feature_clip: float = float(CLIP)
    epsilon: float = float(EPSILON)
    format: Literal[1] = 1

    @property
    def feature_map(self) -> FeatureMap:
        """The map from states to features."""
        return FeatureMap(
            self.state_size,
            self.angles,
            tuple(self.hidden),
            self.clipped,
            tuple(self.feature_order),
        )

    def document(self) -> dict[str, Any]:
        """The header as plain values."""
        return asdict(self)
