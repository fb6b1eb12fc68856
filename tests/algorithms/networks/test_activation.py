"""Each activation, its slope and its bend against torch's, in Python and compiled."""

from collections.abc import Callable

import numpy as np
import pytest
import torch
from numpy.typing import NDArray

from algorithms.networks.activation import NAMED, Activation, activate, bend, slope
from physics.kernels.compiled import compiled_fast

PLAIN: dict[str, Callable[[torch.Tensor], torch.Tensor]] = {
    "tanh": torch.tanh,
    "elu": torch.nn.functional.elu,
    "silu": torch.nn.functional.silu,
    "relu": torch.relu,
}


@compiled_fast
def fill(activation: Activation, y: NDArray[np.float32], result: NDArray[np.float32]) -> None:
    for i in range(y.size):
        h = activate(activation, y[i])
        result[0, i], result[1, i], result[2, i] = (
            h, slope(activation, y[i], h), bend(activation, y[i], h),
        )  # fmt: skip


@pytest.mark.parametrize("name", sorted(NAMED))
def test_values_and_derivatives_are_those_of_torch(name: str) -> None:
    y = np.linspace(-12, 12, 1_000, dtype=np.float32)
    ours = np.empty((3, y.size), np.float32)
    fill(NAMED[name], y, ours)
    exact = torch.tensor(y, dtype=torch.float64, requires_grad=True)
    h = PLAIN[name](exact)
    (first,) = torch.autograd.grad(h.sum(), exact, create_graph=True)
    second = torch.zeros_like(exact)
    if first.requires_grad:
        (second,) = torch.autograd.grad(first.sum(), exact)
    for own, plain in zip(ours, (h, first, second), strict=True):
        np.testing.assert_allclose(own, plain.detach().numpy(), rtol=2e-6, atol=3e-6)


@pytest.mark.parametrize("name", sorted(NAMED))
def test_python_and_compiled_code_give_the_same(name: str) -> None:
    y = np.linspace(-3, 3, 7, dtype=np.float32)
    ours, activation = np.empty((3, y.size), np.float32), NAMED[name]
    fill(activation, y, ours)
    for k, each in enumerate(y):
        h = activate(activation, each)
        np.testing.assert_allclose(
            [h, slope(activation, each, h), bend(activation, each, h)], ours[:, k], rtol=1e-6
        )
