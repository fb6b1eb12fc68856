"""Autograd: a step of a task as a torch function, differentiated by its exact Jacobians.

The gradient of a loss L passes a step backwards as

    dL/ds = J_s^T (dL/ds' + dL/dr dr/ds') + dL/dr dr/ds
    dL/da = J_a^T (dL/ds' + dL/dr dr/ds') + dL/dr dr/da
"""

from typing import Any, NamedTuple

import torch

from physics.environment import Environment


class TorchTransition(NamedTuple):
    """One step of each row of a batch, as tensors."""

    next_state: torch.Tensor
    """[batch, n]"""
    reward: torch.Tensor
    """[batch]"""
    terminated: torch.Tensor
    """[batch], bool"""


def torch_step(
    environment: Environment, states: torch.Tensor, actions: torch.Tensor
) -> TorchTransition:
    """Advance states [batch, n] by one step; gradients flow to states and actions.

    Where `reward_is_differentiable` is False, the reward carries no gradient, and asking for one is
    torch's error. There is no second derivative: asking for one is an error too.

    Raises:
        ValueError: for anything but float64 tensors on the CPU, and as `Environment.step`.
    """
    for what, tensor in (("states", states), ("actions", actions)):
        if tensor.dtype != torch.float64 or tensor.device.type != "cpu":
            raise ValueError(
                f"{what} must be a float64 tensor on the CPU, not {tensor.dtype} on {tensor.device}"
            )
    return TorchTransition(*_Step.apply(environment, states, actions))  # type: ignore[no-untyped-call]


class _Step(torch.autograd.Function):
    @staticmethod
    def forward(
        context: Any, environment: Environment, states: torch.Tensor, actions: torch.Tensor
    ) -> tuple[torch.Tensor, torch.Tensor, torch.Tensor]:
        linearization = environment.differentiate(states.detach().numpy(), actions.detach().numpy())
        transition, *derivatives = linearization
        context.save_for_backward(*map(torch.from_numpy, derivatives))
        next_state, reward, terminated = map(torch.from_numpy, transition)
        constant = [terminated] if environment.reward_is_differentiable else [terminated, reward]
        context.mark_non_differentiable(*constant)
        return next_state, reward, terminated

    @staticmethod
    def backward(
        context: Any,
        next_state_gradient: torch.Tensor,
        reward_gradient: torch.Tensor,
        _terminated: torch.Tensor,
    ) -> tuple[None, torch.Tensor, torch.Tensor]:
        if torch.is_grad_enabled():
            # Otherwise the Jacobians would silently count as constants.
            raise RuntimeError("torch_step has no second derivative: drop create_graph=True")
        state_jacobian, action_jacobian, r_s, r_a, r_next = context.saved_tensors
        by_reward = reward_gradient[:, None]
        arriving = (next_state_gradient + by_reward * r_next)[:, None]
        by_state = (arriving @ state_jacobian)[:, 0] + by_reward * r_s
        by_action = (arriving @ action_jacobian)[:, 0] + by_reward * r_a
        return None, by_state, by_action
