"""Policy: a trained policy that acts in numpy.

    x = clip((f(s) - mean) / std, -5, 5)
    h = x,   then for each hidden layer   h = act(g n + c),   n = normalised(h W + b)
    a = tanh(h V + d)

f(s) are the features of a state: the observation of the task's Gymnasium environment. A stochastic
policy is evaluated with its mean, so there is no noise. Arithmetic is float32, as in training;
actions equal those of the run's own evaluation except for rounding.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from algorithms.acting.header import Header
from algorithms.networks.layer import Layer
from algorithms.networks.parameters import Output, Parameters, hidden_layer, output_layer
from algorithms.snapshot import Snapshot
from physics.environment import Environment
from physics.randomness import generator

Floats = NDArray[np.float32]

ACTIVATIONS: Mapping[str, Any] = {
    "tanh": np.tanh,
    "elu": lambda y: np.where(y > 0, y, np.expm1(np.minimum(y, 0))),
    "silu": lambda y: y / 2 * (1 + np.tanh(y / 2)),
    "relu": lambda y: np.maximum(y, 0),
}


@dataclass(frozen=True, eq=False)
class TrainedPolicy:
    """A deterministic policy of one task.

    Attributes:
        header: the task, the sizes and the origin.
        mean: float32 [F], the mean of the features in training.
        inverse_std: float32 [F], 1 / their standard deviation.
        layers: the hidden layers, the first one first.
        output: the layer that computes the actions.
    """

    header: Header
    mean: Floats
    inverse_std: Floats
    layers: Sequence[Layer]
    output: Output

    def act(self, observation: ArrayLike) -> Floats:
        """The action for an observation of the task's Gymnasium environment.

        Args:
            observation: features [F], or those of a batch [b, F].

        Returns:
            float32 [m], or [b, m], within the box of the actions.

        Raises:
            ValueError: for another shape, NaN and infinity.
        """
        features = self._checked(observation, "features", self.mean.size)
        clip = np.float32(self.header.feature_clip)
        h = np.clip((features.astype(np.float32) - self.mean) * self.inverse_std, -clip, clip)
        for layer in self.layers:
            h = self._hidden(layer, h)
        actions: Floats = np.tanh(h @ self.output.weight + self.output.bias)
        return actions

    def act_in(self, state: ArrayLike) -> Floats:
        """The action in a state [n], or in the states of a batch [b, n].

        Raises:
            ValueError: as `act`.
        """
        states = self._checked(state, "coordinates", self.header.state_size)
        features = self.header.feature_map.features(np.atleast_2d(states))
        return self.act(features.reshape(*states.shape[:-1], self.mean.size))

    def _hidden(self, layer: Layer, x: Floats) -> Floats:
        z = x @ layer.weight + layer.bias
        spread = np.sqrt(z.var(axis=-1, keepdims=True) + np.float32(self.header.epsilon))
        n = (z - z.mean(axis=-1, keepdims=True)) / spread
        h: Floats = ACTIVATIONS[self.header.activation](layer.gain * n + layer.shift)
        return h

    def _checked(self, given: ArrayLike, what: str, size: int) -> NDArray[np.float64]:
        """The input of a policy, float64 [..., size]. Raises ValueError if it is invalid."""
        array = np.asarray(given, np.float64)
        if array.ndim not in (1, 2) or array.shape[-1] != size:
            header = self.header
            raise ValueError(
                f"the policy of {header.task} takes {size} {what}, [{size}] or [batch, {size}], "
                f"not {list(array.shape)}; `act` takes the {self.mean.size} features that "
                f"Gymnasium observes, `act_in` the {header.state_size} coordinates of a state"
            )
        if not np.isfinite(array).all():
            raise ValueError(
                f"the policy of {self.header.task} got {what} that are NaN or infinite"
            )
        return array


def policy_of(
    snapshot: Snapshot, environment: Environment, origin: Mapping[str, Any]
) -> TrainedPolicy:
    """The policy of a snapshot that was taken in this task.

    Raises:
        ValueError: for a task whose features a header cannot describe, such as one that overrides
            `features`.
    """
    shape = snapshot.inside.shape(snapshot.policy.mean.size, snapshot.actions)
    p = Parameters(snapshot.policy.theta, shape)
    header = Header(
        task=environment.name,
        task_version=environment.version,
        parameters={**environment.parameters, **environment.changed},
        state_size=environment.state_size,
        angles=dict(environment.angles),
        hidden=list(environment.hidden),
        clipped=dict(environment.clipped),
        feature_order=list(environment.feature_order),
        action_size=environment.action_size,
        activation=snapshot.inside.activation,  # type: ignore[arg-type]  # checked by pydantic
        hidden_units=list(shape.hidden),
        origin={**origin, "timestep": snapshot.timestep},
    )
    states = 20.0 * generator(0, "features").standard_normal((16, environment.state_size))
    features = environment.without_noise().features(states)
    if not np.array_equal(header.feature_map.features(states), features):
        raise ValueError(
            f"the policy of {environment.name} cannot be exported: its features are not those "
            "of its declared angles and hidden coordinates"
        )
    return TrainedPolicy(
        header,
        snapshot.policy.mean.copy(),
        snapshot.policy.inverse.copy(),
        [Layer(*(part.copy() for part in hidden_layer(p, k))) for k in range(len(shape.hidden))],
        Output(*(part.copy() for part in output_layer(p))),
    )
