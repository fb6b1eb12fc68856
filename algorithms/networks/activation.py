# ruff: noqa: ARG001, ARG005  (every function takes y and h, even if it needs only one)
"""The activations of hidden units, with their first and second derivatives.

    tanh   h = tanh y                      slope = 1 - h^2              bend = -2 h slope
    elu    h = y, or e^y - 1 below 0       slope = 1, or h + 1          bend = 0, or h + 1
    silu   h = y s                         slope = s + h (1 - s)        bend = see below
    relu   h = max(y, 0)                   slope = 1, or 0              bend = 0

slope is dh/dy and bend its derivative; s = 1 / (1 + e^-y), and silu's bend is
s (1 - s) (2 + y (1 - 2 s)). The default is tanh, a smooth activation, because a hybrid trains the
critic's input gradient. With ReLU that gradient is piecewise constant, and gradient terms could not
train biases.

The exponentials are computed by the vectorised tanh (algorithms.networks.squash), with
t = tanh(y / 2): s = (1 + t) / 2,   e^y - 1 = 2 t / (1 - t).

An activation is a type, so that a network's kernels are compiled for its activation and no unit
has to test which it is.

Source: ELU, Clevert et al. (2015); SiLU, Elfwing et al. (2017).
"""

from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np
from numba.extending import overload

from algorithms.networks.squash import squash, squash_slope
from physics.kernels.compiled import compiled_fast

ZERO, HALF, ONE, TWO = np.float32(0), np.float32(0.5), np.float32(1), np.float32(2)


class Tanh(NamedTuple):
    """Hyperbolic tangent."""


class ELU(NamedTuple):
    """Exponential linear unit, alpha = 1."""


class SiLU(NamedTuple):
    """Sigmoid-weighted linear unit."""


class ReLU(NamedTuple):
    """Rectified linear unit."""


Activation = Tanh | ELU | SiLU | ReLU
NAMED: dict[str, Activation] = {"tanh": Tanh(), "elu": ELU(), "silu": SiLU(), "relu": ReLU()}


@compiled_fast
def _tanh(y: Any) -> Any:
    return squash(y)


@compiled_fast
def _tanh_slope(y: Any, h: Any) -> Any:
    return squash_slope(h)


@compiled_fast
def _tanh_bend(y: Any, h: Any) -> Any:
    return -TWO * h * squash_slope(h)


@compiled_fast
def _elu(y: Any) -> Any:
    t = squash(HALF * min(y, ZERO))
    return max(y, ZERO) + TWO * t / (ONE - t)


@compiled_fast
def _elu_slope(y: Any, h: Any) -> Any:
    return min(h, ZERO) + ONE


@compiled_fast
def _elu_bend(y: Any, h: Any) -> Any:
    return h + ONE if y < ZERO else ZERO


@compiled_fast
def _silu(y: Any) -> Any:
    return y * HALF * (ONE + squash(HALF * y))


@compiled_fast
def _silu_slope(y: Any, h: Any) -> Any:
    s = HALF * (ONE + squash(HALF * y))
    return s + h * (ONE - s)


@compiled_fast
def _silu_bend(y: Any, h: Any) -> Any:
    s = HALF * (ONE + squash(HALF * y))
    return s * (ONE - s) * (TWO + y * (ONE - TWO * s))


@compiled_fast
def _relu(y: Any) -> Any:
    return max(y, ZERO)


@compiled_fast
def _relu_slope(y: Any, h: Any) -> Any:
    return ONE if y > ZERO else ZERO


@compiled_fast
def _relu_bend(y: Any, h: Any) -> Any:
    return ZERO


class _Functions(NamedTuple):
    activate: Callable[[Any], Any]
    slope: Callable[[Any, Any], Any]
    bend: Callable[[Any, Any], Any]


_OF: dict[type[Activation], _Functions] = {
    Tanh: _Functions(_tanh, _tanh_slope, _tanh_bend),
    ELU: _Functions(_elu, _elu_slope, _elu_bend),
    SiLU: _Functions(_silu, _silu_slope, _silu_bend),
    ReLU: _Functions(_relu, _relu_slope, _relu_bend),
}


def activate(activation: Activation, y: Any) -> Any:
    """The unit's value h."""
    return _OF[type(activation)].activate(y)


def slope(activation: Activation, y: Any, h: Any) -> Any:
    """`dh/dy`."""
    return _OF[type(activation)].slope(y, h)


def bend(activation: Activation, y: Any, h: Any) -> Any:
    """`d^2 h/dy^2`."""
    return _OF[type(activation)].bend(y, h)


# numba compares the two signatures of an overload, annotations included: these have none.
@overload(activate)
def _(activation, y):  # type: ignore[no-untyped-def]
    function = _OF[activation.instance_class].activate
    return lambda activation, y: function(y)


@overload(slope)
def _(activation, y, h):  # type: ignore[no-untyped-def]
    function = _OF[activation.instance_class].slope
    return lambda activation, y, h: function(y, h)


@overload(bend)
def _(activation, y, h):  # type: ignore[no-untyped-def]
    function = _OF[activation.instance_class].bend
    return lambda activation, y, h: function(y, h)
