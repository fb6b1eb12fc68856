"""A task of torch functions: the same exact derivatives whatever mode torch is in."""

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
import torch

from physics.audit.differences import differences, relative_errors
from physics.randomness import generator
from tests.physics.small_tasks import Plain

MODES: list[Callable[[], Any]] = [torch.enable_grad, torch.no_grad, torch.inference_mode]


def mass(s: torch.Tensor) -> torch.Tensor:
    """A positive definite matrix [2, 2] that depends on the state."""
    off, last = 0.5 * s[0], 1.5 + s[0] ** 2
    rows = [torch.stack([2 + torch.cos(s[1]), off]), torch.stack([off, last])]
    return torch.stack(rows)


def force(s: torch.Tensor, a: torch.Tensor) -> torch.Tensor:
    return torch.stack([a[0], -s[0]])


OPERATIONS: dict[str, Callable[[torch.Tensor, torch.Tensor], torch.Tensor]] = {
    "solve": lambda s, a: torch.linalg.solve(mass(s), force(s, a)),
    "inv": lambda s, a: torch.linalg.inv(mass(s)) @ force(s, a),
    "det": lambda s, a: torch.linalg.det(mass(s)) * force(s, a),
    "slogdet": lambda s, a: torch.linalg.slogdet(mass(s))[1] * force(s, a),
    "cholesky": lambda s, a: torch.cholesky_solve(
        force(s, a)[:, None], torch.linalg.cholesky(mass(s))
    )[:, 0],
    "lstsq": lambda s, a: torch.linalg.lstsq(mass(s), force(s, a)[:, None]).solution[:, 0],
    "eigvalsh": lambda s, a: torch.linalg.eigvalsh(mass(s)) * a[0],
    "qr": lambda s, a: torch.linalg.qr(mass(s))[1] @ force(s, a),
    "svdvals": lambda s, a: torch.linalg.svdvals(mass(s)) * a[0],
    "matrix_exp": lambda s, a: torch.linalg.matrix_exp(0.1 * mass(s)) @ force(s, a),
}


class WithLinearAlgebra(Plain):
    """Some operation of torch.linalg in the step, the determinant and a norm in the reward."""

    name = "WithLinearAlgebra"
    operation = "solve"

    def dynamics(self, state: torch.Tensor, action: torch.Tensor) -> torch.Tensor:
        return state + 0.05 * OPERATIONS[self.operation](state, action)

    def reward(
        self, state: torch.Tensor, action: torch.Tensor, next_state: torch.Tensor
    ) -> torch.Tensor:
        del state, action
        size: torch.Tensor = torch.linalg.det(mass(next_state))
        distance: torch.Tensor = torch.linalg.vector_norm(next_state - 3.0)
        return size - distance


@pytest.mark.parametrize("operation", OPERATIONS)
def test_derivatives_are_the_same_in_every_mode(operation: str) -> None:
    task = WithLinearAlgebra()
    task.operation = operation
    random = generator(0, "torch.linalg")
    states, actions = random.uniform(-1, 1, (70, 2)), random.uniform(-1, 1, (70, 1))
    expected = task.differentiate(states, actions)
    assert relative_errors(expected, differences(task, states, actions)).max() < 1e-6
    for mode in MODES:
        with mode():
            for rows in (slice(None), slice(3, 8), slice(69, 70)):
                found = task.differentiate(states[rows], actions[rows])
                for one, other in zip(
                    [*found.transition, *found[1:]],
                    [*expected.transition, *expected[1:]],
                    strict=True,
                ):
                    np.testing.assert_array_equal(one, other[rows])


def test_the_callers_mode_is_left_alone() -> None:
    with torch.no_grad():
        Plain().differentiate(np.zeros((1, 2)), np.zeros((1, 1)))
        assert not torch.is_grad_enabled()
    with torch.inference_mode():
        Plain().step(np.zeros((1, 2)), np.zeros((1, 1)))
        assert torch.is_inference_mode_enabled()


def test_a_reward_declared_piecewise_constant_has_no_gradient() -> None:
    class Rough(Plain):
        reward_is_differentiable = False

    found = Rough().differentiate(np.ones((2, 2)), np.ones((2, 1)))
    assert (
        found.transition.reward.tolist()
        == Plain().step(np.ones((2, 2)), np.ones((2, 1))).reward.tolist()
    )
    assert not any(gradient.any() for gradient in found[3:])
    assert found.state_jacobian.any()
