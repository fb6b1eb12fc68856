"""The network every learner uses: hidden layers and a linear output; and its derivatives.

    out = h_L V + d,   h_k = layer_k(h_{k-1}),   h_0 = x                (algorithms.networks.layer)

The results of a pass lie in flat vectors, layer after layer, like the parameters
(algorithms.networks.shape); a layer's part is a view.

There are four passes, each of which fills arrays that are allocated once:

    forward          out = f(x)
    backward         xbar = outbar df/dx, and the layers' adjoints;  `gradient` makes dS/dtheta
    tangent          outdot = df/dx xdot
    second_backward  d/dtheta of  outtil . out + outbar . outdot

The last is the derivative of an input gradient: with outbar = 1 and xdot = dL/d(xbar), it is the
gradient of any loss L(out, xbar) (double backward, as forward over reverse: Pearlmutter, 1994).

Glossary: `B` rows, `I` inputs, `L` hidden layers, `H` units of one of them, `U` of all, `O`
outputs.
"""

from typing import NamedTuple

import numpy as np

from algorithms.networks import layer
from algorithms.networks.layer import Adjoint, Array, LayerTangent, Trace
from algorithms.networks.parameters import Parameters, hidden_layer, output_layer
from algorithms.networks.shape import Shape, inputs_of, units_before
from physics.kernels.compiled import compiled_fast


class Pass(NamedTuple):
    """A forward pass and the backward pass that may follow it."""

    x: Array
    """[B, I]"""
    n: Array
    """[B U], as are h, h_bar and z_bar: of each layer [B, H], row by row."""
    r: Array
    """[B L]"""
    h: Array
    out: Array
    """[B, O]"""
    out_bar: Array
    """[B, O]"""
    h_bar: Array
    z_bar: Array
    x_bar: Array
    """[B, I]"""


class Direction(NamedTuple):
    """A tangent pass and the second-order backward pass that may follow it."""

    x: Array
    """[B, I]"""
    z: Array
    """[B U], as are n, h and til."""
    n: Array
    h: Array
    out: Array
    """[B, O]"""
    out_til: Array
    """[B, O]"""
    til: Array
    product: Array
    """[largest of the hidden products], scratch"""


@compiled_fast
def new_pass(theta: Array, rows: int, shape: Shape) -> Pass:
    """Arrays for a forward and a backward pass over `rows` rows, of theta's dtype."""
    kind, layers = theta.dtype, len(shape.hidden)
    units = rows * units_before(shape, layers)
    return Pass(
        np.empty((rows, shape.inputs), kind),
        np.empty(units, kind),
        np.empty(rows * layers, kind),
        np.empty(units, kind),
        np.empty((rows, shape.outputs), kind),
        np.empty((rows, shape.outputs), kind),
        np.empty(units, kind),
        np.empty(units, kind),
        np.empty((rows, shape.inputs), kind),
    )


@compiled_fast
def new_direction(theta: Array, rows: int, shape: Shape) -> Direction:
    """Arrays for a tangent and a second-order backward pass over `rows` rows."""
    kind, layers = theta.dtype, len(shape.hidden)
    units = rows * units_before(shape, layers)
    largest = inputs_of(shape, layers) * shape.outputs
    for k in range(layers):
        largest = max(largest, inputs_of(shape, k) * shape.hidden[k])
    return Direction(
        np.empty((rows, shape.inputs), kind),
        np.empty(units, kind),
        np.empty(units, kind),
        np.empty(units, kind),
        np.empty((rows, shape.outputs), kind),
        np.empty((rows, shape.outputs), kind),
        np.empty(units, kind),
        np.empty(largest, kind),
    )


@compiled_fast
def of_layer(buffer: Array, rows: int, shape: Shape, k: int) -> Array:
    """The part [B, H] of hidden layer k of a flat buffer [B U]; no copy."""
    start, units = rows * units_before(shape, k), shape.hidden[k]
    return buffer[start : start + rows * units].reshape((rows, units))


@compiled_fast
def trace_of(a: Pass, shape: Shape, k: int) -> Trace:
    """The results of the forward pass for hidden layer k."""
    rows = a.x.shape[0]
    return Trace(
        of_layer(a.n, rows, shape, k),
        a.r[k * rows : (k + 1) * rows],
        of_layer(a.h, rows, shape, k),
    )


@compiled_fast
def adjoint_of(a: Pass, shape: Shape, k: int) -> Adjoint:
    """The results of the backward pass for hidden layer k."""
    rows = a.x.shape[0]
    return Adjoint(of_layer(a.h_bar, rows, shape, k), of_layer(a.z_bar, rows, shape, k))


@compiled_fast
def tangent_of(d: Direction, shape: Shape, k: int) -> LayerTangent:
    """The results of the tangent pass for hidden layer k."""
    rows = d.x.shape[0]
    return LayerTangent(
        of_layer(d.z, rows, shape, k),
        of_layer(d.n, rows, shape, k),
        of_layer(d.h, rows, shape, k),
    )


@compiled_fast
def layer_inputs(x: Array, h: Array, shape: Shape, k: int) -> Array:
    """The inputs of hidden layer k, for k = L of the output layer: x, or the h before."""
    return x if k == 0 else of_layer(h, x.shape[0], shape, k - 1)


@compiled_fast
def receive(a: Pass, x: Array) -> None:
    """Copy the inputs `x [B, I]` into the pass.

    It copies entry by entry: copying a slice adds a check of shapes that takes longer to compile
    than a network.
    """
    for i in range(x.shape[0]):
        for j in range(x.shape[1]):
            a.x[i, j] = x[i, j]


@compiled_fast
def forward(p: Parameters, a: Pass) -> None:
    """Compute `out = f(x)`."""
    shape = p.shape
    layers = len(shape.hidden)
    for k in range(layers):
        x = layer_inputs(a.x, a.h, shape, k)
        layer.forward(hidden_layer(p, k), shape.activation, x, trace_of(a, shape, k))
    last = output_layer(p)
    np.dot(layer_inputs(a.x, a.h, shape, layers), last.weight, a.out)
    for i in range(a.out.shape[0]):
        for j in range(a.out.shape[1]):
            a.out[i, j] += last.bias[j]


@compiled_fast
def backward(p: Parameters, a: Pass) -> None:
    """Compute the layers' adjoints from `out_bar`."""
    shape = p.shape
    layers, rows = len(shape.hidden), a.x.shape[0]
    np.dot(a.out_bar, output_layer(p).weight.T, of_layer(a.h_bar, rows, shape, layers - 1))
    for k in range(layers - 1, -1, -1):
        own, adjoint = hidden_layer(p, k), adjoint_of(a, shape, k)
        layer.backward(own, shape.activation, trace_of(a, shape, k), adjoint)
        if k > 0:
            np.dot(adjoint.z, own.weight.T, of_layer(a.h_bar, rows, shape, k - 1))


@compiled_fast
def backward_to_input(p: Parameters, a: Pass) -> None:
    """Compute `x_bar` and the layers' adjoints from `out_bar`."""
    backward(p, a)
    np.dot(adjoint_of(a, p.shape, 0).z, hidden_layer(p, 0).weight.T, a.x_bar)


@compiled_fast
def gradient(p: Parameters, a: Pass, result: Parameters) -> None:
    """Compute `d(outbar . out)/dtheta`, after `backward`."""
    shape = p.shape
    layers, last = len(shape.hidden), output_layer(result)
    np.dot(layer_inputs(a.x, a.h, shape, layers).T, a.out_bar, last.weight)
    column_sums(a.out_bar, last.bias)
    for k in range(layers):
        layer.gradient(
            hidden_layer(p, k), shape.activation, layer_inputs(a.x, a.h, shape, k),
            trace_of(a, shape, k), adjoint_of(a, shape, k), hidden_layer(result, k),
        )  # fmt: skip


@compiled_fast
def tangent(p: Parameters, a: Pass, d: Direction) -> None:
    """Compute `out` of `d`, the change of f along `d.x`, after `forward`."""
    shape = p.shape
    layers = len(shape.hidden)
    for k in range(layers):
        layer.tangent(
            hidden_layer(p, k), shape.activation, trace_of(a, shape, k),
            layer_inputs(d.x, d.h, shape, k), tangent_of(d, shape, k),
        )  # fmt: skip
    np.dot(layer_inputs(d.x, d.h, shape, layers), output_layer(p).weight, d.out)


@compiled_fast
def second_backward(p: Parameters, a: Pass, d: Direction, result: Parameters) -> None:
    """Compute `d(outtil . out + outbar . outdot)/dtheta`, after `backward` and `tangent`."""
    shape = p.shape
    layers, rows, last = len(shape.hidden), a.x.shape[0], output_layer(result)
    np.dot(layer_inputs(a.x, a.h, shape, layers).T, d.out_til, last.weight)
    add_product(layer_inputs(d.x, d.h, shape, layers), a.out_bar, d.product, last.weight)
    column_sums(d.out_til, last.bias)
    np.dot(d.out_til, output_layer(p).weight.T, of_layer(d.til, rows, shape, layers - 1))
    for k in range(layers - 1, -1, -1):
        own, of_result = hidden_layer(p, k), hidden_layer(result, k)
        adjoint, til = adjoint_of(a, shape, k), of_layer(d.til, rows, shape, k)
        layer.second_backward(
            own, shape.activation, trace_of(a, shape, k), adjoint, tangent_of(d, shape, k),
            til, of_result,
        )  # fmt: skip
        np.dot(layer_inputs(a.x, a.h, shape, k).T, til, of_result.weight)
        add_product(layer_inputs(d.x, d.h, shape, k), adjoint.z, d.product, of_result.weight)
        if k > 0:
            np.dot(til, own.weight.T, of_layer(d.til, rows, shape, k - 1))


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
