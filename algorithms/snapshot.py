"""Snapshot: the policy and the critic of a run.

    a = tanh(pi(x)),   Q(s, a) = value_mean + value_std q(x, a),   x = clip((f(s) - mean) inverse)

A snapshot is written beside a run's checkpoints and kept when the run has ended: its policy plays
rollouts, and its critic is drawn as a surface over states and actions.
"""

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from algorithms.networks import network
from algorithms.networks.activation import NAMED
from algorithms.networks.layer import Array
from algorithms.networks.parameters import Parameters
from algorithms.networks.policy import Policies, Policy
from algorithms.networks.scaling import normalise
from algorithms.networks.shape import Shape
from algorithms.state import State, part, within
from physics.kernels.compiled import compiled_fast

FloatArray = NDArray[np.float64]


class Inside(NamedTuple):
    """The hidden layers of the run's networks."""

    hidden: tuple[int, ...]
    """Units of each hidden layer."""
    activation: str

    def shape(self, inputs: int, outputs: int) -> Shape:
        """The shape of a network with these numbers of inputs and outputs."""
        return Shape(inputs, self.hidden, outputs, NAMED[self.activation])


def inside(shape: Shape) -> Inside:
    """The hidden layers of a network of this shape."""
    [activation] = [name for name, each in NAMED.items() if type(each) is type(shape.activation)]
    return Inside(shape.hidden, activation)


class Critic(NamedTuple):
    """The network and the normalisation of a Q of the run."""

    theta: NDArray[np.float32]
    """[P]"""
    value_mean: float
    value_std: float


class Snapshot(NamedTuple):
    """One run's policy and, if it has one, its critic."""

    timestep: int
    actions: int
    """m"""
    inside: Inside
    policy: Policy
    critic: Critic | None = None

    def policies(self) -> Policies:
        """The policy, ready to act on one state at a time [1, F]."""
        shape = self.inside.shape(self.policy.mean.size, self.actions)
        return Policies([self.policy], shape)

    def values(self, features: FloatArray, actions: FloatArray) -> FloatArray:
        """Q [b] of features [b, F] and actions [b, m], in the task's units.

        Raises:
            ValueError: if the run learns no critic.
        """
        if self.critic is None:
            raise ValueError("this run learns no critic: it has no Q to look at")
        q = np.empty(len(features))
        shape = self.inside.shape(self.policy.mean.size + self.actions, 1)
        q_rows(self.critic.theta, self.policy, features, actions, shape, q)
        return self.critic.value_mean + self.critic.value_std * q

    def arrays(self) -> State:
        """Plain arrays by name; `snapshot_of` is the inverse."""
        own = {
            "timestep": np.array(self.timestep),
            "actions": np.array(self.actions),
            "hidden": np.array(self.inside.hidden),
            "activation": np.array(self.inside.activation),
        }
        critic = {} if self.critic is None else _arrays(self.critic)
        return own | within("policy", _arrays(self.policy)) | within("critic", critic)


def snapshot_of(arrays: State) -> Snapshot:
    """The snapshot of the arrays of `Snapshot.arrays`. Raises KeyError for other arrays."""
    policy, critic = part(arrays, "policy"), part(arrays, "critic")
    return Snapshot(
        int(arrays["timestep"]),
        int(arrays["actions"]),
        _inside(arrays),
        Policy(policy["theta"], policy["mean"], policy["inverse"], policy["noise"]),
        critic=Critic(critic["theta"], float(critic["value_mean"]), float(critic["value_std"]))
        if critic
        else None,
    )


def _inside(arrays: State) -> Inside:
    """Read the hidden layers; old snapshots have one number of units, for two layers of tanh."""
    hidden = arrays["hidden"].tolist()
    if isinstance(hidden, int):
        return Inside((hidden, hidden), "tanh")
    return Inside(tuple(hidden), str(arrays["activation"]))


def _arrays(parts: Policy | Critic) -> State:
    return {name: np.asarray(value) for name, value in zip(parts._fields, parts, strict=True)}


@compiled_fast
def q_rows(
    theta: Array,
    policy: Any,
    features: FloatArray,
    actions: FloatArray,
    shape: Shape,
    result: FloatArray,
) -> None:
    """The normalised Q [b] of features [b, F] and actions [b, m]."""
    work = network.new_pass(theta, features.shape[0], shape)
    count = features.shape[1]
    for row in range(features.shape[0]):
        for i in range(count):
            feature = np.float32(features[row, i])
            work.x[row, i] = normalise(feature, policy.mean[i], policy.inverse[i])
        for i in range(actions.shape[1]):
            work.x[row, count + i] = np.float32(actions[row, i])
    network.forward(Parameters(theta, shape), work)
    for row in range(features.shape[0]):
        result[row] = work.out[row, 0]
