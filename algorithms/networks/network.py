"""The network every learner uses: two hidden layers and a linear output; and its derivatives.

    out = h2 V + d,   h2 = layer2(h1),   h1 = layer1(x)                  (algorithms.networks.layer)

All parameters of a network lie in one flat vector theta, products first, then biases, then the
gains and shifts of layer normalisation:

    theta = [W1 | W2 | V | b1 | b2 | d | g1 | c1 | g2 | c2]

so that Adam, Polyak averaging and weight decay are loops over a vector, and "every parameter but
layer normalisation's" (parameter noise) is a prefix of it.

Four passes, each filling arrays made once by `Workspace`:

    forward          out = f(x)
    backward         xbar = outbar df/dx, and the layers' adjoints;  `gradient` makes dS/dtheta
    tangent          outdot = df/dx xdot
    second_backward  d/dtheta of  outtil . out + outbar . outdot

The last is the derivative of an input gradient: with outbar = 1 and xdot = dL/d(xbar), it is the
gradient of any loss L(out, xbar) (double backward, as forward over reverse: Pearlmutter, 1994).

Glossary: `B` rows, `I` inputs, `H` hidden units, `O` outputs.
"""

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from algorithms.networks import layer
from algorithms.networks.layer import Adjoint, Array, Layer, LayerTangent, Trace
from physics.kernels.compiled import compiled_fast

LAST = 3e-3


class Shape(NamedTuple):
    """The sizes of a network."""

    inputs: int
    hidden: int
    outputs: int


class Parameters(NamedTuple):
    """Views into a flat vector of parameters, or of a gradient."""

    first: Layer
    second: Layer
    weight: Array
    """[H, O]"""
    bias: Array
    """[O]"""


class Pass(NamedTuple):
    """A forward pass and the backward pass that may follow it."""

    x: Array
    """[B, I]"""
    first: Trace
    second: Trace
    out: Array
    """[B, O]"""
    out_bar: Array
    """[B, O]"""
    second_bar: Adjoint
    first_bar: Adjoint
    x_bar: Array
    """[B, I]"""


class Direction(NamedTuple):
    """A tangent pass and the second-order backward pass that may follow it."""

    x: Array
    """[B, I]"""
    first: LayerTangent
    second: LayerTangent
    out: Array
    """[B, O]"""
    out_til: Array
    """[B, O]"""
    second_til: Array
    """[B, H]"""
    first_til: Array
    """[B, H]"""
    product: Array
    """[max(I, H), H], scratch"""


@compiled_fast
def decayed_size(shape: Shape) -> Any:
    """How many parameters, from the first, are hidden products."""
    return (shape.inputs + shape.hidden) * shape.hidden


def noisy_size(shape: Shape) -> int:
    """How many parameters, from the first, are not layer normalisation's."""
    return int(decayed_size(shape)) + shape.hidden * (shape.outputs + 2) + shape.outputs


def parameter_size(shape: Shape) -> int:
    """The length of theta."""
    return noisy_size(shape) + 4 * shape.hidden


def initial(shape: Shape, generator: np.random.Generator) -> NDArray[np.float32]:
    """Draw theta: hidden products Glorot-uniform, the last layer U(-0.003, 0.003), the rest 0 or 1.

    A small last layer lets the actor begin near 0 and the critic near its mean (Lillicrap, 2015).
    """
    i, h, o = shape
    theta = np.zeros(parameter_size(shape), np.float32)
    p = parameters(theta, shape)
    p.first.weight[:] = generator.uniform(-1, 1, (i, h)) * np.sqrt(6 / (i + h))
    p.second.weight[:] = generator.uniform(-1, 1, (h, h)) * np.sqrt(6 / (h + h))
    p.weight[:] = generator.uniform(-LAST, LAST, (h, o))
    p.first.bias[:] = generator.uniform(-1, 1, h) / np.sqrt(i)
    p.second.bias[:] = generator.uniform(-1, 1, h) / np.sqrt(h)
    p.first.gain[:] = 1
    p.second.gain[:] = 1
    return theta


@compiled_fast
def parameters(theta: Array, shape: Shape) -> Parameters:
    """Name the parts of theta; no copy."""
    i, h, o = shape.inputs, shape.hidden, shape.outputs
    w2 = i * h
    v = w2 + h * h
    b = v + h * o
    g = b + 2 * h + o
    return Parameters(
        Layer(
            theta[:w2].reshape((i, h)),
            theta[b : b + h],
            theta[g : g + h],
            theta[g + h : g + 2 * h],
        ),
        Layer(
            theta[w2:v].reshape((h, h)),
            theta[b + h : b + 2 * h],
            theta[g + 2 * h : g + 3 * h],
            theta[g + 3 * h : g + 4 * h],
        ),
        theta[v:b].reshape((h, o)),
        theta[b + 2 * h : g],
    )


def first_outputs(theta: NDArray[np.float32], shape: Shape, outputs: int) -> NDArray[np.float32]:
    """Theta of the same network with its first so many outputs alone."""
    p = parameters(theta, shape)
    v = decayed_size(shape)
    b = v + p.weight.size
    d = b + 2 * shape.hidden
    return np.concatenate([
        theta[:v], p.weight[:, :outputs].ravel(), theta[b:d],
        p.bias[:outputs], theta[d + shape.outputs :],
    ])  # fmt: skip


@compiled_fast
def new_pass(theta: Array, rows: int, shape: Shape) -> Pass:
    """Arrays for a forward and a backward pass over `rows` rows, of theta's dtype."""
    i, h, o = shape.inputs, shape.hidden, shape.outputs
    kind = theta.dtype
    return Pass(
        np.empty((rows, i), kind),
        Trace(np.empty((rows, h), kind), np.empty(rows, kind), np.empty((rows, h), kind)),
        Trace(np.empty((rows, h), kind), np.empty(rows, kind), np.empty((rows, h), kind)),
        np.empty((rows, o), kind),
        np.empty((rows, o), kind),
        Adjoint(np.empty((rows, h), kind), np.empty((rows, h), kind)),
        Adjoint(np.empty((rows, h), kind), np.empty((rows, h), kind)),
        np.empty((rows, i), kind),
    )


@compiled_fast
def new_direction(theta: Array, rows: int, shape: Shape) -> Direction:
    """Arrays for a tangent and a second-order backward pass over `rows` rows."""
    i, h, o = shape.inputs, shape.hidden, shape.outputs
    kind = theta.dtype
    wide = (rows, h)
    return Direction(
        np.empty((rows, i), kind),
        LayerTangent(np.empty(wide, kind), np.empty(wide, kind), np.empty(wide, kind)),
        LayerTangent(np.empty(wide, kind), np.empty(wide, kind), np.empty(wide, kind)),
        np.empty((rows, o), kind),
        np.empty((rows, o), kind),
        np.empty(wide, kind),
        np.empty(wide, kind),
        np.empty((max(i, h) * h), kind),
    )


@compiled_fast
def receive(a: Pass, x: Array) -> None:
    """Copy the inputs `x [B, I]` into the pass.

    Entry by entry: a slice's copy brings a check of shapes with it that takes longer to compile
    than a network.
    """
    for i in range(x.shape[0]):
        for j in range(x.shape[1]):
            a.x[i, j] = x[i, j]


@compiled_fast
def forward(p: Parameters, a: Pass) -> None:
    """`out = f(x)`."""
    layer.forward(p.first, a.x, a.first)
    layer.forward(p.second, a.first.h, a.second)
    np.dot(a.second.h, p.weight, a.out)
    for i in range(a.out.shape[0]):
        for k in range(a.out.shape[1]):
            a.out[i, k] += p.bias[k]


@compiled_fast
def backward(p: Parameters, a: Pass) -> None:
    """The layers' adjoints, from `out_bar`."""
    np.dot(a.out_bar, p.weight.T, a.second_bar.y)
    layer.backward(p.second, a.second, a.second_bar)
    np.dot(a.second_bar.z, p.second.weight.T, a.first_bar.y)
    layer.backward(p.first, a.first, a.first_bar)


@compiled_fast
def backward_to_input(p: Parameters, a: Pass) -> None:
    """`x_bar`, and the layers' adjoints, from `out_bar`."""
    backward(p, a)
    np.dot(a.first_bar.z, p.first.weight.T, a.x_bar)


@compiled_fast
def gradient(a: Pass, result: Parameters) -> None:
    """`d(outbar . out)/dtheta`, after `backward`."""
    np.dot(a.second.h.T, a.out_bar, result.weight)
    column_sums(a.out_bar, result.bias)
    layer.gradient(a.first.h, a.second, a.second_bar, result.second)
    layer.gradient(a.x, a.first, a.first_bar, result.first)


@compiled_fast
def tangent(p: Parameters, a: Pass, d: Direction) -> None:
    """`out` of `d`: how f changes along `d.x`, after `forward`."""
    layer.tangent(p.first, a.first, d.x, d.first)
    layer.tangent(p.second, a.second, d.first.h, d.second)
    np.dot(d.second.h, p.weight, d.out)


@compiled_fast
def second_backward(p: Parameters, a: Pass, d: Direction, result: Parameters) -> None:
    """`d(outtil . out + outbar . outdot)/dtheta`, after `backward` and `tangent`."""
    np.dot(a.second.h.T, d.out_til, result.weight)
    add_product(d.second.h, a.out_bar, d.product, result.weight)
    column_sums(d.out_til, result.bias)

    np.dot(d.out_til, p.weight.T, d.second_til)
    layer.second_backward(p.second, a.second, a.second_bar, d.second, d.second_til, result.second)
    np.dot(a.first.h.T, d.second_til, result.second.weight)
    add_product(d.first.h, a.second_bar.z, d.product, result.second.weight)

    np.dot(d.second_til, p.second.weight.T, d.first_til)
    layer.second_backward(p.first, a.first, a.first_bar, d.first, d.first_til, result.first)
    np.dot(a.x.T, d.first_til, result.first.weight)
    add_product(d.x, a.first_bar.z, d.product, result.first.weight)


@compiled_fast
def add_product(left: Array, right: Array, scratch: Array, result: Array) -> None:
    """Add `left' right` to the result."""
    rows, columns = result.shape
    product = scratch[: rows * columns].reshape((rows, columns))
    np.dot(left.T, right, product)
    for i in range(rows):
        for j in range(columns):
            result[i, j] += product[i, j]


@compiled_fast
def column_sums(rows: Array, result: Array) -> None:
    """Sum over the first axis."""
    result[:] = 0
    for i in range(rows.shape[0]):
        for k in range(rows.shape[1]):
            result[k] += rows[i, k]
