"""Learned: a snapshot's policy and critic as functions of states, with their derivatives.

    x = clip((f(s) - mean) / std),   a = tanh(pi(x)),   Q = value_mean + value_std q(x, a)
    dpi/ds = (1 - a^2) dpi/dx dx/ds

A feature that is clipped has no slope. Networks are float32, everything else is float64.
"""

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from algorithms.diagnostics.closed_loop import Gradient
from algorithms.networks import network
from algorithms.networks.layer import Array
from algorithms.networks.parameters import Parameters
from algorithms.networks.scaling import CLIP, coordinate_stds, coordinates_of
from algorithms.networks.shape import Shape
from algorithms.snapshot import Critic, Snapshot
from physics.environment import Environment, FloatArray
from physics.kernels.compiled import compiled_fast


class Inputs(NamedTuple):
    """The inputs of a network for some states, and their slopes."""

    x: NDArray[np.float32]
    """[b, F], normalised."""
    jacobian: FloatArray
    """[b, F, n], `dx/ds`."""


class LearnedPolicy:
    """The deterministic policy of a run, a `Controller`."""

    def __init__(self, environment: Environment, snapshot: Snapshot) -> None:
        """Use the policy of a snapshot that was trained on this task."""
        self._environment = environment
        self._snapshot = snapshot

    def __call__(self, states: FloatArray) -> tuple[FloatArray, FloatArray]:
        """The actions [b, m] in states [b, n], and their Jacobians [b, m, n]."""
        policy = self._snapshot.policy
        seen = inputs(self._environment, self._snapshot, states)
        shape = self._snapshot.inside.shape(policy.mean.size, self._snapshot.actions)
        out, by_input = differentiated(policy.theta, shape, seen.x)
        actions = np.tanh(out)
        return actions, (1.0 - actions**2)[:, :, None] * (by_input @ seen.jacobian)


class LearnedCritic:
    """The gradient of a run's critic."""

    def __init__(self, environment: Environment, snapshot: Snapshot, critic: Critic) -> None:
        """Use the critic of a snapshot that was trained on this task."""
        self._environment = environment
        self._snapshot = snapshot
        self._critic = critic

    def __call__(self, states: FloatArray, actions: FloatArray) -> Gradient:
        """The gradient of Q at states [b, n] and actions [b, m], in the task's units."""
        seen = inputs(self._environment, self._snapshot, states)
        x = np.hstack([seen.x, actions.astype(np.float32)])
        _, by_input = differentiated(
            self._critic.theta, self._snapshot.inside.shape(x.shape[1], 1), x
        )
        gradient, features = self._critic.value_std * by_input[:, 0], seen.x.shape[1]
        by_state = np.einsum("bf,bfn->bn", gradient[:, :features], seen.jacobian)
        return Gradient(by_state, gradient[:, features:])


def inputs(environment: Environment, snapshot: Snapshot, states: FloatArray) -> Inputs:
    """The inputs of a snapshot's networks for states [b, n]."""
    features, policy = environment.features(states), snapshot.policy
    x = np.clip((features.astype(np.float32) - policy.mean) * policy.inverse, -CLIP, CLIP)
    slopes = environment.feature_slopes(features) * policy.inverse * (np.abs(x) < CLIP)
    columns = np.eye(environment.state_size)[environment.feature_sources]
    return Inputs(x, slopes[:, :, None] * columns)


def units(environment: Environment, snapshot: Snapshot) -> FloatArray:
    """The spread [n] of each coordinate in training; 0 for those that no network sees.

    A gradient in a state times this, or `J units_j / units_i`, depends on no unit of the task.
    """
    coordinates = coordinates_of(environment)
    variance = 1.0 / snapshot.policy.inverse.astype(np.float64) ** 2
    spread = np.zeros(environment.state_size)
    spread[coordinates.seen] = coordinate_stds(variance, coordinates)
    return spread


def differentiated(
    theta: NDArray[np.float32], shape: Shape, x: NDArray[np.float32]
) -> tuple[FloatArray, FloatArray]:
    """A network's outputs [b, O] at inputs [b, I], and their Jacobians [b, O, I]."""
    out = np.empty((len(x), shape.outputs), np.float32)
    jacobian = np.empty((len(x), shape.outputs, shape.inputs), np.float32)
    differentiate_network(theta, shape, np.ascontiguousarray(x), out, jacobian)
    return out.astype(np.float64), jacobian.astype(np.float64)


@compiled_fast
def differentiate_network(theta: Array, shape: Any, x: Array, out: Array, jacobian: Array) -> None:
    """Fill `out [b, O]` and `jacobian [b, O, I]`: one backward pass for each output."""
    p, work = Parameters(theta, shape), network.new_pass(theta, x.shape[0], shape)
    network.receive(work, x)
    network.forward(p, work)
    out[:] = work.out
    for k in range(out.shape[1]):
        work.out_bar[:] = 0
        work.out_bar[:, k] = 1
        network.backward_to_input(p, work)
        for row in range(x.shape[0]):
            for i in range(x.shape[1]):
                jacobian[row, k, i] = work.x_bar[row, i]
