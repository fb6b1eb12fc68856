"""Closed loop: rollouts of a policy with noise, and the exact gradient of their returns.

    a_t = pi(s_t) + w_t,    s_{t+1} = f(s_t, a_t),    R_H = sum over t < H of gamma^t r_t

Backwards in time, with lambda the gradient of the rewards to come (0 from the end on):

    q        = r_s' + gamma lambda_{t+1}
    by_a     = r_a + J_a' q
    by_s     = r_s + J_s' q
    lambda_t = by_s + (dpi/ds)' by_a

At t = 0, `by_s` and `by_a` are the gradient of the policy's Q_H(s, a), cut after H steps. `by_a` is
also the gradient of R_H with respect to w_0.

Glossary: `T` steps, `b` rollouts; `n`, `m` sizes of states and actions.
"""

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from physics.environment import BoolArray, Environment, FloatArray, IntArray

Controller = Callable[[FloatArray], tuple[FloatArray, FloatArray]]
"""A policy: states [b, n] -> actions [b, m] and their Jacobians in the states [b, m, n]."""


class Gradient(NamedTuple):
    """The gradient of a quantity in b states and actions."""

    by_state: FloatArray
    """[b, n]"""
    by_action: FloatArray
    """[b, m]"""


class Rollouts(NamedTuple):
    """Steps with their derivatives; those after a rollout's end are void."""

    states: FloatArray
    """[T, b, n]"""
    actions: FloatArray
    """[T, b, m], noise included; the task clips them."""
    rewards: FloatArray
    """[T, b]; 0 from the end on."""
    policy_jacobian: FloatArray
    """[T, b, m, n]"""
    state_jacobian: FloatArray
    """[T, b, n, n]"""
    action_jacobian: FloatArray
    """[T, b, n, m]"""
    reward_state: FloatArray
    """[T, b, n], partial derivative of the reward in s."""
    reward_action: FloatArray
    """[T, b, m]"""
    reward_next: FloatArray
    """[T, b, n]"""
    lengths: IntArray
    """[b], the number of steps of each rollout."""

    @property
    def is_live(self) -> BoolArray:
        """[T, b], whether a step belongs to its rollout."""
        live: BoolArray = np.arange(len(self.rewards))[:, None] < self.lengths
        return live


def roll_out(
    environment: Environment,
    controller: Controller,
    starts: FloatArray,
    steps: int,
    noise: FloatArray | None = None,
) -> Rollouts:
    """Let a policy act from each start [b, n] for some steps, or until the task ends.

    Args:
        environment: the task; its time limit does not count.
        controller: the policy.
        starts: the first states.
        steps: T, at most.
        noise: [T, b, m], added to the actions; None for no noise.

    Raises:
        ValueError, ArithmeticError: as `Environment.differentiate`.
    """
    states, lengths = starts, np.full(len(starts), steps)
    rows: list[tuple[FloatArray, ...]] = []
    for t in range(steps):
        actions, policy_jacobian = controller(states)
        if noise is not None:
            actions = actions + noise[t]
        step, *derivatives = environment.differentiate(states, actions)
        rewards = np.where(lengths > t, step.reward, 0.0)
        rows.append((states, actions, rewards, policy_jacobian, *derivatives))
        lengths[step.terminated & (lengths > t)] = t + 1
        goes_on = lengths > t + 1
        if not goes_on.any():
            break
        states = np.where(goes_on[:, None], step.next_state, states)
    return Rollouts._make([*(np.stack(part) for part in zip(*rows, strict=True)), lengths])


def value_gradient(rollouts: Rollouts, horizon: int, gamma: float = 1.0) -> Gradient:
    """The exact gradient of R_H in each rollout's first state and action, H = `horizon`.

    It is not finite where the closed loop makes it grow beyond float64.
    """
    later = np.zeros_like(rollouts.states[0])
    by_state, by_action = later, np.zeros_like(rollouts.actions[0])
    live = rollouts.is_live
    with np.errstate(over="ignore", invalid="ignore"):
        for t in range(min(horizon, len(live)) - 1, -1, -1):
            q = rollouts.reward_next[t] + gamma * later
            by_action = rollouts.reward_action[t] + pulled_back(q, rollouts.action_jacobian[t])
            by_state = rollouts.reward_state[t] + pulled_back(q, rollouts.state_jacobian[t])
            total = by_state + pulled_back(by_action, rollouts.policy_jacobian[t])
            later = np.where(live[t][:, None], total, 0.0)
    return Gradient(by_state, by_action)


def pulled_back(vectors: FloatArray, jacobians: FloatArray) -> FloatArray:
    """`J' v` [b, k] of vectors [b, j] and Jacobians [b, j, k]."""
    product: FloatArray = np.einsum("bj,bjk->bk", vectors, jacobians)
    return product
