"""Traced functions: the same bits without the Python, or the function itself."""

import numpy as np
import pytest
import torch

from physics.randomness import generator
from physics.torch_environment import TorchEnvironment, gradients_enabled
from physics.torch_trace import Tensors, traced
from tests.physics.small_tasks import DistanceAtGoal, Plain
from tests.physics.test_parameter_derivatives import Spring

ROWS = 64


class MassMatrix(Plain):
    """A mass matrix solved inside the step, and a reward that looks up the larger coordinate."""

    name = "MassMatrix"

    def dynamics(self, state: torch.Tensor, action: torch.Tensor) -> torch.Tensor:
        one = torch.ones_like(state[0])
        mass = torch.stack([2 + torch.cos(state[1]), 0.5 * one, 0.5 * one, one]).reshape(2, 2)
        turned: torch.Tensor = torch.linalg.solve(mass, torch.stack([action[0], -state[0]]))
        return state + 0.05 * turned

    def reward(
        self, state: torch.Tensor, action: torch.Tensor, next_state: torch.Tensor
    ) -> torch.Tensor:
        return torch.where(state[0] > state[1], next_state[0], -(next_state[1] ** 2))


class Counted(Plain):
    """It counts how often its Python runs."""

    name = "Counted"
    runs = 0

    def dynamics(self, state: torch.Tensor, action: torch.Tensor) -> torch.Tensor:
        Counted.runs += 1
        return super().dynamics(state, action)


def block(seed: int) -> tuple[torch.Tensor, torch.Tensor]:
    random = generator(seed, "torch trace")
    return (
        torch.from_numpy(random.normal(size=(ROWS, 2))),
        torch.from_numpy(random.uniform(-1.5, 1.5, (ROWS, 1))),
    )


@pytest.mark.parametrize("task", [Plain(), Spring(), DistanceAtGoal(), MassMatrix()])
def test_a_trace_has_the_bits_of_the_function(task: TorchEnvironment) -> None:
    with gradients_enabled():
        for function in (task.transitions, task.derivatives):
            quick = traced(function, *block(0))
            assert quick != function, "it was not traced"
            for seed in range(1, 4):
                for one, other in zip(quick(*block(seed)), function(*block(seed)), strict=True):
                    np.testing.assert_array_equal(one.numpy(), other.detach().numpy())


def test_a_task_runs_its_python_no_more() -> None:
    task, (states, actions) = Counted(), block(0)
    for rows in (ROWS, 3, 2 * ROWS):
        task.differentiate(states.numpy()[:rows], actions.numpy()[:rows])
        task.step(states.numpy()[:rows], actions.numpy()[:rows])
        if rows == ROWS:
            before = Counted.runs
    assert Counted.runs == before > 0


def test_what_cannot_be_traced_is_called_as_it_is() -> None:
    def looks_at_values(states: torch.Tensor, actions: torch.Tensor) -> Tensors:
        return (states * float(states[0, 0].item()) + actions,)

    assert traced(looks_at_values, *block(0)) is looks_at_values


def test_what_changes_from_call_to_call_is_called_as_it_is() -> None:
    calls: list[int] = []

    def counts(states: torch.Tensor, actions: torch.Tensor) -> Tensors:
        calls.append(0)
        return (states * len(calls) + actions,)

    assert traced(counts, *block(0)) is counts


def test_two_arrays_that_are_filled_apart_stay_two() -> None:
    def fills(states: torch.Tensor, actions: torch.Tensor) -> Tensors:
        one, other = torch.zeros_like(states), torch.zeros_like(states)
        one[:, 0] = actions[:, 0]
        other[:, 1] = states[:, 0]
        return one, other

    quick = traced(fills, *block(0))
    assert quick is not fills
    for one, other in zip(quick(*block(1)), fills(*block(1)), strict=True):
        np.testing.assert_array_equal(one.numpy(), other.numpy())
