"""One hidden layer: a product, layer normalisation, an activation; and its derivatives.

    z = x W + b,   n = (z - mean z) r,   r = 1 / sqrt(var z + EPSILON),   y = g n + c,   h = act(y)

Backward, of a scalar S (a bar is dS/d.; `mean` runs over the units of one row):

    ybar = hbar slope,   q = g ybar,   zbar = r (q - mean q - n mean(q n))

Forward, along a direction (a dot):

    ndot = r (zdot - mean zdot - n mean(n zdot)),   hdot = slope g ndot

Second order: S depends on h and on hdot. With `hbar` the adjoint of hdot and `ybar = hbar slope`,
found by the backward pass above, and `htil` the adjoint of h, that of z is

    ytil = htil slope + hbar bend g ndot
    N    = g ytil - r (zdot mean(q n) + q mean(n zdot))
    ztil = r (N - mean N - n (mean(N n) + mean(q ndot)))

No loop both sums and stores (physics.kernels.compiled).

Glossary: `B` rows, `I` inputs, `H` units; `W [I, H]`, `b, g, c [H]`; every row by itself; slope and
bend, the activation's derivatives (algorithms.networks.activation).
Source: layer normalisation, Ba et al. (2016), before the activation as in OpenAI Baselines.
"""

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from algorithms.networks.activation import Activation, activate, bend, slope
from physics.kernels.compiled import compiled_fast

Array = NDArray[np.floating[Any]]

EPSILON = np.float32(1e-5)


class Layer(NamedTuple):
    """Parameters, or a gradient with respect to them."""

    weight: Array
    """[I, H]"""
    bias: Array
    """[H]"""
    gain: Array
    """[H]"""
    shift: Array
    """[H]"""


class Trace(NamedTuple):
    """The results of a forward pass."""

    n: Array
    """[B, H]"""
    r: Array
    """[B]"""
    h: Array
    """[B, H]"""


class Adjoint(NamedTuple):
    """The results of a backward pass."""

    h: Array
    """[B, H]; filled before the pass begins."""
    z: Array
    """[B, H]"""


class LayerTangent(NamedTuple):
    """The results of a forward pass along a direction."""

    z: Array
    """[B, H]"""
    n: Array
    """[B, H]"""
    h: Array
    """[B, H]"""


@compiled_fast
def forward(layer: Layer, activation: Activation, x: Array, trace: Trace) -> None:
    """Fill the trace from the inputs `x [B, I]`."""
    n, r, h = trace.n, trace.r, trace.h
    np.dot(x, layer.weight, n)
    rows, units = n.shape
    real = n.dtype.type
    share = real(1) / real(units)
    for i in range(rows):
        for j in range(units):
            n[i, j] += layer.bias[j]
    for i in range(rows):
        total = real(0)
        for j in range(units):
            total += n[i, j]
        r[i] = total * share
    for i in range(rows):
        mean = r[i]
        for j in range(units):
            n[i, j] -= mean
    for i in range(rows):
        squares = real(0)
        for j in range(units):
            squares += n[i, j] * n[i, j]
        r[i] = real(1) / np.sqrt(squares * share + EPSILON)
    for i in range(rows):
        ri = r[i]
        for j in range(units):
            nij = n[i, j] * ri
            n[i, j] = nij
            h[i, j] = activate(activation, layer.gain[j] * nij + layer.shift[j])


@compiled_fast
def backward(layer: Layer, activation: Activation, trace: Trace, adjoint: Adjoint) -> None:
    """Fill the adjoint of z from that of h."""
    n, h, zbar = trace.n, trace.h, adjoint.z
    rows, units = n.shape
    real = n.dtype.type
    share = real(1) / real(units)
    for i in range(rows):
        for j in range(units):
            y = layer.gain[j] * n[i, j] + layer.shift[j]
            zbar[i, j] = layer.gain[j] * adjoint.h[i, j] * slope(activation, y, h[i, j])
    for i in range(rows):
        q_mean, qn_mean = real(0), real(0)
        for j in range(units):
            q_mean += zbar[i, j]
            qn_mean += zbar[i, j] * n[i, j]
        q_mean *= share
        qn_mean *= share
        ri = trace.r[i]
        for j in range(units):
            zbar[i, j] = ri * (zbar[i, j] - q_mean - n[i, j] * qn_mean)


@compiled_fast
def gradient(
    layer: Layer, activation: Activation, x: Array, trace: Trace, adjoint: Adjoint, result: Layer
) -> None:
    """Fill the gradient of S with respect to the layer's parameters, after `backward`."""
    np.dot(x.T, adjoint.z, result.weight)
    result.bias[:] = 0
    result.gain[:] = 0
    result.shift[:] = 0
    rows, units = trace.n.shape
    for i in range(rows):
        for j in range(units):
            n = trace.n[i, j]
            y = layer.gain[j] * n + layer.shift[j]
            ybar = adjoint.h[i, j] * slope(activation, y, trace.h[i, j])
            result.bias[j] += adjoint.z[i, j]
            result.gain[j] += ybar * n
            result.shift[j] += ybar


@compiled_fast
def tangent(
    layer: Layer, activation: Activation, trace: Trace, x_dot: Array, result: LayerTangent
) -> None:
    """Fill the change of the layer as its inputs move along `x_dot [B, I]`."""
    np.dot(x_dot, layer.weight, result.z)
    n, h = trace.n, trace.h
    rows, units = n.shape
    real = n.dtype.type
    share = real(1) / real(units)
    for i in range(rows):
        z_mean, nz_mean = real(0), real(0)
        for j in range(units):
            z_mean += result.z[i, j]
            nz_mean += result.z[i, j] * n[i, j]
        z_mean *= share
        nz_mean *= share
        ri = trace.r[i]
        for j in range(units):
            ndot = ri * (result.z[i, j] - z_mean - n[i, j] * nz_mean)
            y = layer.gain[j] * n[i, j] + layer.shift[j]
            result.n[i, j] = ndot
            result.h[i, j] = slope(activation, y, h[i, j]) * layer.gain[j] * ndot


@compiled_fast
def second_backward(
    layer: Layer,
    activation: Activation,
    trace: Trace,
    adjoint: Adjoint,
    moved: LayerTangent,
    h_til: Array,
    result: Layer,
) -> None:
    """Turn `h_til [B, H]` into ztil in place; the gradient except `weight` goes to `result`.

    The adjoint's h, which is not read afterwards, is overwritten with q.
    """
    n, h = trace.n, trace.h
    rows, units = n.shape
    real = n.dtype.type
    share = real(1) / real(units)
    result.bias[:] = 0
    result.gain[:] = 0
    result.shift[:] = 0
    for i in range(rows):
        ri = trace.r[i]
        for j in range(units):
            nij, g, ndot, hbar = n[i, j], layer.gain[j], moved.n[i, j], adjoint.h[i, j]
            y = g * nij + layer.shift[j]
            along = slope(activation, y, h[i, j])
            ybar = hbar * along
            ytil = h_til[i, j] * along + hbar * bend(activation, y, h[i, j]) * g * ndot
            adjoint.h[i, j] = g * ybar
            h_til[i, j] = g * ytil
            result.gain[j] += ytil * nij + ybar * ndot
            result.shift[j] += ytil
        nz_mean, qn_mean, qm_mean = real(0), real(0), real(0)
        for j in range(units):
            nz_mean += n[i, j] * moved.z[i, j]
            qn_mean += adjoint.h[i, j] * n[i, j]
            qm_mean += adjoint.h[i, j] * moved.n[i, j]
        nz_mean *= share * ri
        qn_mean *= share * ri
        qm_mean *= share
        for j in range(units):
            h_til[i, j] -= adjoint.h[i, j] * nz_mean + moved.z[i, j] * qn_mean
        big_mean, bign_mean = real(0), real(0)
        for j in range(units):
            big_mean += h_til[i, j]
            bign_mean += h_til[i, j] * n[i, j]
        big_mean *= share
        bign_mean = bign_mean * share + qm_mean
        for j in range(units):
            ztil = ri * (h_til[i, j] - big_mean - n[i, j] * bign_mean)
            h_til[i, j] = ztil
            result.bias[j] += ztil
