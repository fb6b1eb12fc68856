"""One hidden layer: a product, layer normalisation, an activation; and its derivatives.

    z = x W + b,   n = (z - mean z) r,   r = 1 / sqrt(var z + EPSILON),   y = g n + c,   h = tanh y

Backward, of a scalar S (a bar is dS/d.; `mean` runs over the units of one row):

    ybar = hbar slope(h),   q = g ybar,   zbar = r (q - mean q - n mean(q n))

Forward, along a direction (a dot):

    ndot = r (zdot - mean zdot - n mean(n zdot)),   hdot = slope(h) g ndot

Second order: S depends on h and on hdot. With `ybar` the adjoint of ydot, found by the backward
pass above, and `hbar` that of h, the adjoint of z is

    ytil = hbar slope(h) + ybar bend(h) g ndot
    N    = g ytil - r (zdot mean(q n) + q mean(n zdot))
    ztil = r (N - mean N - n (mean(N n) + mean(q ndot)))

Glossary: `B` rows, `I` inputs, `H` units; `W [I, H]`, `b, g, c [H]`; every row by itself.
Source: layer normalisation, Ba et al. (2016), before the activation as in OpenAI Baselines.
"""

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from algorithms.networks.activation import activate, bend, slope
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
    """What a forward pass leaves."""

    n: Array
    """[B, H]"""
    r: Array
    """[B]"""
    h: Array
    """[B, H]"""


class Adjoint(NamedTuple):
    """What a backward pass leaves."""

    y: Array
    """[B, H]; holds hbar as the pass begins."""
    z: Array
    """[B, H]"""


class LayerTangent(NamedTuple):
    """What a forward pass along a direction leaves."""

    z: Array
    """[B, H]"""
    n: Array
    """[B, H]"""
    h: Array
    """[B, H]"""


@compiled_fast
def forward(layer: Layer, x: Array, trace: Trace) -> None:
    """Fill the trace from the inputs `x [B, I]`."""
    n, r, h = trace.n, trace.r, trace.h
    np.dot(x, layer.weight, n)
    rows, units = n.shape
    real = n.dtype.type
    share = real(1) / real(units)
    for i in range(rows):
        total = real(0)
        for j in range(units):
            z = n[i, j] + layer.bias[j]
            n[i, j] = z
            total += z
        r[i] = total * share
    for i in range(rows):
        mean = r[i]
        squares = real(0)
        for j in range(units):
            centred = n[i, j] - mean
            n[i, j] = centred
            squares += centred * centred
        r[i] = real(1) / np.sqrt(squares * share + EPSILON)
    for i in range(rows):
        ri = r[i]
        for j in range(units):
            nij = n[i, j] * ri
            n[i, j] = nij
            h[i, j] = activate(layer.gain[j] * nij + layer.shift[j])


@compiled_fast
def backward(layer: Layer, trace: Trace, adjoint: Adjoint) -> None:
    """Fill the adjoint, whose `y` holds hbar on entry."""
    n, h = trace.n, trace.h
    ybar, zbar = adjoint.y, adjoint.z
    rows, units = n.shape
    real = n.dtype.type
    share = real(1) / real(units)
    for i in range(rows):
        q_mean, qn_mean = real(0), real(0)
        for j in range(units):
            y = ybar[i, j] * slope(h[i, j])
            q = layer.gain[j] * y
            ybar[i, j] = y
            zbar[i, j] = q
            q_mean += q
            qn_mean += q * n[i, j]
        q_mean *= share
        qn_mean *= share
        ri = trace.r[i]
        for j in range(units):
            zbar[i, j] = ri * (zbar[i, j] - q_mean - n[i, j] * qn_mean)


@compiled_fast
def gradient(x: Array, trace: Trace, adjoint: Adjoint, result: Layer) -> None:
    """The gradient of S with respect to the layer's parameters."""
    np.dot(x.T, adjoint.z, result.weight)
    result.bias[:] = 0
    result.gain[:] = 0
    result.shift[:] = 0
    rows, units = trace.n.shape
    for i in range(rows):
        for j in range(units):
            y = adjoint.y[i, j]
            result.bias[j] += adjoint.z[i, j]
            result.gain[j] += y * trace.n[i, j]
            result.shift[j] += y


@compiled_fast
def tangent(layer: Layer, trace: Trace, x_dot: Array, result: LayerTangent) -> None:
    """How the layer changes as its inputs move along `x_dot [B, I]`."""
    np.dot(x_dot, layer.weight, result.z)
    n, h = trace.n, trace.h
    rows, units = n.shape
    real = n.dtype.type
    share = real(1) / real(units)
    for i in range(rows):
        z_mean, nz_mean = real(0), real(0)
        for j in range(units):
            z = result.z[i, j]
            z_mean += z
            nz_mean += z * n[i, j]
        z_mean *= share
        nz_mean *= share
        ri = trace.r[i]
        for j in range(units):
            ndot = ri * (result.z[i, j] - z_mean - n[i, j] * nz_mean)
            result.n[i, j] = ndot
            result.h[i, j] = slope(h[i, j]) * layer.gain[j] * ndot


@compiled_fast
def second_backward(
    layer: Layer, trace: Trace, adjoint: Adjoint, moved: LayerTangent, h_bar: Array, result: Layer
) -> None:
    """Turn `h_bar [B, H]` into ztil in place; the gradient but for `weight` goes to `result`."""
    n, h, ybar = trace.n, trace.h, adjoint.y
    rows, units = n.shape
    real = n.dtype.type
    share = real(1) / real(units)
    result.bias[:] = 0
    result.gain[:] = 0
    result.shift[:] = 0
    for i in range(rows):
        ri = trace.r[i]
        nz_mean, qn_mean, qm_mean = real(0), real(0), real(0)
        for j in range(units):
            q = layer.gain[j] * ybar[i, j]
            nz_mean += n[i, j] * moved.z[i, j]
            qn_mean += q * n[i, j]
            qm_mean += q * moved.n[i, j]
        nz_mean *= share * ri
        qn_mean *= share * ri
        qm_mean *= share
        big_mean, bign_mean = real(0), real(0)
        for j in range(units):
            nij, hij, y, g = n[i, j], h[i, j], ybar[i, j], layer.gain[j]
            ndot = moved.n[i, j]
            ytil = h_bar[i, j] * slope(hij) + y * bend(hij) * g * ndot
            result.gain[j] += ytil * nij + y * ndot
            result.shift[j] += ytil
            big = g * (ytil - y * nz_mean) - moved.z[i, j] * qn_mean
            h_bar[i, j] = big
            big_mean += big
            bign_mean += big * nij
        big_mean *= share
        bign_mean = bign_mean * share + qm_mean
        for j in range(units):
            ztil = ri * (h_bar[i, j] - big_mean - n[i, j] * bign_mean)
            h_bar[i, j] = ztil
            result.bias[j] += ztil
