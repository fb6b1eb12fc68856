"""torch_step: gradients of a whole episode, and what it refuses."""

import numpy as np
import pytest
import torch

import physics
from physics.environment import Environment


def episode_return(
    environment: Environment, start: torch.Tensor, plan: torch.Tensor
) -> torch.Tensor:
    state, total = start, torch.zeros(len(start), dtype=torch.float64)
    for action in plan.unbind(1):
        transition = physics.torch_step(environment, state, action)
        state, total = transition.next_state, total + transition.reward
    return total


@pytest.mark.parametrize(
    "name", ["MassPoint", "CartPole", "CartPoleSwingUp", "Pendulum", "MountainCar"]
)
def test_gradient_of_an_episode(name: str) -> None:
    environment = physics.make(name)
    start = torch.from_numpy(environment.initial_states([1, 2])).requires_grad_()
    random = torch.Generator().manual_seed(0)
    plan = torch.rand((2, 10, 1), generator=random, dtype=torch.float64) - 0.5
    plan.requires_grad_()
    assert torch.autograd.gradcheck(
        lambda s, p: episode_return(environment, s, p), (start, plan), atol=1e-6
    )


def test_state_gradient_alone() -> None:
    environment = physics.make("Pendulum")
    state = torch.tensor([[0.1, 0.2]], dtype=torch.float64, requires_grad=True)
    action = torch.tensor([[0.3]], dtype=torch.float64)
    omega = physics.torch_step(environment, state, action).next_state[0, 1]
    (gradient,) = torch.autograd.grad(omega, state)
    exact = environment.differentiate(state.detach().numpy(), action.numpy())
    np.testing.assert_array_equal(gradient[0].numpy(), exact.state_jacobian[0, 1])


def test_a_reward_that_is_not_differentiable_says_so() -> None:
    environment = physics.make("Acrobot")
    state = torch.zeros((1, 4), dtype=torch.float64, requires_grad=True)
    transition = physics.torch_step(environment, state, torch.zeros((1, 1), dtype=torch.float64))
    assert transition.next_state.requires_grad
    assert not transition.reward.requires_grad


def test_other_types_are_refused() -> None:
    environment = physics.make("Pendulum")
    state, action = torch.zeros((1, 2), dtype=torch.float64), torch.zeros((1, 1))
    with pytest.raises(ValueError, match=r"actions must be a float64 tensor.*torch\.float32"):
        physics.torch_step(environment, state, action)


def test_a_second_derivative_is_refused() -> None:
    environment = physics.make("Pendulum")
    state = torch.zeros((1, 2), dtype=torch.float64, requires_grad=True)
    action = torch.zeros((1, 1), dtype=torch.float64, requires_grad=True)
    reward = physics.torch_step(environment, state, action).reward
    with pytest.raises(RuntimeError, match="no second derivative"):
        torch.autograd.grad(reward.sum(), action, create_graph=True)
