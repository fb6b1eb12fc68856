"""The shape of a network: sizes of its layers, and where their parameters lie in one flat vector.

    theta = [W_1 | ... | W_L | V | b_1 | ... | b_L | d | g_1 | c_1 | ... | g_L | c_L]

products first, then biases, then the gains and shifts of layer normalisation. So "every hidden
product" (weight decay) and "every parameter but layer normalisation's" (parameter noise) are
prefixes of theta.
"""

from typing import Any, NamedTuple, Protocol

from algorithms.networks.activation import NAMED, Activation, Tanh
from physics.kernels.compiled import compiled_fast


class Shape(NamedTuple):
    """The sizes of a network, and its activation."""

    inputs: int
    hidden: tuple[int, ...]
    """Units of each hidden layer; at least one layer."""
    outputs: int
    activation: Activation = Tanh()


class HiddenSettings(Protocol):
    """The settings of a network's hidden layers (algorithms.settings)."""

    @property
    def hidden_units(self) -> int:
        """Units of each hidden layer."""

    @property
    def hidden_layers(self) -> int:
        """The number of hidden layers."""

    @property
    def activation(self) -> str:
        """The name of the activation."""


def shape_of(inputs: int, outputs: int, config: HiddenSettings) -> Shape:
    """The shape of a network with these settings."""
    hidden = (config.hidden_units,) * config.hidden_layers
    return Shape(inputs, hidden, outputs, NAMED[config.activation])


@compiled_fast
def inputs_of(shape: Shape, k: int) -> Any:
    """The number of inputs of hidden layer k, from 0 on; for k = L, of the output layer."""
    return shape.inputs if k == 0 else shape.hidden[k - 1]


@compiled_fast
def units_before(shape: Shape, k: int) -> Any:
    """How many units the hidden layers before k have."""
    count = 0
    for i in range(k):
        count += shape.hidden[i]
    return count


@compiled_fast
def products_before(shape: Shape, k: int) -> Any:
    """How many entries the products of the hidden layers before k have."""
    count = 0
    for i in range(k):
        count += inputs_of(shape, i) * shape.hidden[i]
    return count


@compiled_fast
def decayed_size(shape: Shape) -> Any:
    """How many parameters, from the first, are hidden products."""
    return products_before(shape, len(shape.hidden))


@compiled_fast
def bias_offset(shape: Shape) -> Any:
    """Where the biases begin in theta."""
    return decayed_size(shape) + inputs_of(shape, len(shape.hidden)) * shape.outputs


@compiled_fast
def noisy_size(shape: Shape) -> Any:
    """How many parameters, from the first, are not layer normalisation's."""
    return bias_offset(shape) + units_before(shape, len(shape.hidden)) + shape.outputs


def parameter_size(shape: Shape) -> int:
    """The length of theta."""
    return int(noisy_size(shape)) + 2 * sum(shape.hidden)
