"""The parameters of a network: views into a flat vector, and initial values."""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from algorithms.networks.layer import Array, Layer
from algorithms.networks.shape import (
    Shape,
    bias_offset,
    decayed_size,
    inputs_of,
    noisy_size,
    parameter_size,
    products_before,
    units_before,
)
from physics.kernels.compiled import compiled_fast

LAST = 3e-3


class Parameters(NamedTuple):
    """A flat vector of parameters, or of a gradient, and how it is laid out."""

    theta: Array
    """[P]"""
    shape: Shape


class Output(NamedTuple):
    """Parameters of the output layer."""

    weight: Array
    """[H, O]"""
    bias: Array
    """[O]"""


def initial_theta(shape: Shape, generator: np.random.Generator) -> NDArray[np.float32]:
    """Draw theta: hidden products Glorot-uniform, the last layer U(-0.003, 0.003), the rest 0 or 1.

    With a small last layer, the actor starts near 0 and the critic near its mean (Lillicrap, 2015).
    """
    theta = np.zeros(parameter_size(shape), np.float32)
    p = Parameters(theta, shape)
    hidden = [hidden_layer(p, k) for k in range(len(shape.hidden))]
    for each in hidden:
        drawn = generator.uniform(-1, 1, each.weight.shape)
        each.weight[:] = drawn * np.sqrt(6 / sum(each.weight.shape))
    last = output_layer(p).weight
    last[:] = generator.uniform(-LAST, LAST, last.shape)
    for each in hidden:
        inputs, units = each.weight.shape
        each.bias[:] = generator.uniform(-1, 1, units) / np.sqrt(inputs)
        each.gain[:] = 1
    return theta


@compiled_fast
def hidden_layer(p: Parameters, k: int) -> Layer:
    """The parameters of hidden layer k; no copy."""
    shape, theta = p.shape, p.theta
    inputs, units = inputs_of(shape, k), shape.hidden[k]
    w = products_before(shape, k)
    b = bias_offset(shape) + units_before(shape, k)
    g = noisy_size(shape) + 2 * units_before(shape, k)
    return Layer(
        theta[w : w + inputs * units].reshape((inputs, units)),
        theta[b : b + units],
        theta[g : g + units],
        theta[g + units : g + 2 * units],
    )


@compiled_fast
def output_layer(p: Parameters) -> Output:
    """The parameters of the output layer; no copy."""
    shape, theta = p.shape, p.theta
    v, b, end = decayed_size(shape), bias_offset(shape), noisy_size(shape)
    units = inputs_of(shape, len(shape.hidden))
    return Output(
        theta[v:b].reshape((units, shape.outputs)),
        theta[end - shape.outputs : end],
    )


def first_outputs(theta: NDArray[np.float32], shape: Shape, outputs: int) -> NDArray[np.float32]:
    """Theta of the same network with only its first `outputs` outputs."""
    last = output_layer(Parameters(theta, shape))
    v, b, end = decayed_size(shape), bias_offset(shape), noisy_size(shape)
    return np.concatenate([
        theta[:v], last.weight[:, :outputs].ravel(), theta[b : end - shape.outputs],
        last.bias[:outputs], theta[end:],
    ])  # fmt: skip
