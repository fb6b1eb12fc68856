"""Reward: the reward of a robot's step, and `Running`, for forward motion at little effort.

    r = (x' - x) / seconds + bonus - control_cost |clip(a)|^2      without the bonus if s' ends it

x is coordinate 0. At a bound of the action, the derivative is the interior one.
"""

from dataclasses import dataclass
from typing import Protocol, runtime_checkable

from physics.environment import BoolArray, FloatArray
from physics.kernels.compiled import compiled


@runtime_checkable
class Reward(Protocol):
    """The reward of a step of some seconds; arrays are batches, and the last ones are filled."""

    def fill(
        self,
        seconds: float,
        states: FloatArray,
        actions: FloatArray,
        next_states: FloatArray,
        terminated: BoolArray,
        rewards: FloatArray,
    ) -> None:
        """Fill `rewards` [batch]."""

    def fill_gradients(
        self,
        seconds: float,
        states: FloatArray,
        actions: FloatArray,
        next_states: FloatArray,
        state_gradients: FloatArray,
        action_gradients: FloatArray,
        next_state_gradients: FloatArray,
    ) -> None:
        """Fill the partial derivatives in s [batch, 2n], a [batch, m] and s' [batch, 2n]."""


@compiled
def _reward_rows(
    seconds: float,
    bonus: float,
    control_cost: float,
    states: FloatArray,
    actions: FloatArray,
    next_states: FloatArray,
    terminated: BoolArray,
    rewards: FloatArray,
) -> None:
    """Fill `rewards` [batch]."""
    for row in range(states.shape[0]):
        effort = 0.0
        for i in range(actions.shape[1]):
            effort += min(max(actions[row, i], -1.0), 1.0) ** 2
        speed = (next_states[row, 0] - states[row, 0]) / seconds
        rewards[row] = speed - control_cost * effort
        if not terminated[row]:
            rewards[row] += bonus


@compiled
def _gradient_rows(
    seconds: float,
    control_cost: float,
    actions: FloatArray,
    state_gradients: FloatArray,
    action_gradients: FloatArray,
    next_state_gradients: FloatArray,
) -> None:
    """Fill the partial derivatives of every row's reward."""
    for row in range(actions.shape[0]):
        for i in range(state_gradients.shape[1]):
            state_gradients[row, i] = -1.0 / seconds if i == 0 else 0.0
            next_state_gradients[row, i] = 1.0 / seconds if i == 0 else 0.0
        for i in range(actions.shape[1]):
            a = actions[row, i]
            action_gradients[row, i] = -2.0 * control_cost * a if abs(a) <= 1.0 else 0.0


@dataclass(frozen=True)
class Running:
    """The reward of running.

    Attributes:
        control_cost: the cost of an action of length 1.
        bonus: the bonus of a step that does not end the episode.
    """

    control_cost: float
    bonus: float = 0.0

    def fill(
        self,
        seconds: float,
        states: FloatArray,
        actions: FloatArray,
        next_states: FloatArray,
        terminated: BoolArray,
        rewards: FloatArray,
    ) -> None:
        """Fill `rewards` [batch]."""
        constants = seconds, self.bonus, self.control_cost
        _reward_rows(*constants, states, actions, next_states, terminated, rewards)

    def fill_gradients(
        self,
        seconds: float,
        states: FloatArray,
        actions: FloatArray,
        next_states: FloatArray,
        state_gradients: FloatArray,
        action_gradients: FloatArray,
        next_state_gradients: FloatArray,
    ) -> None:
        """Fill the partial derivatives in s [batch, 2n], a [batch, m] and s' [batch, 2n]."""
        del states, next_states
        gradients = state_gradients, action_gradients, next_state_gradients
        _gradient_rows(seconds, self.control_cost, actions, *gradients)
