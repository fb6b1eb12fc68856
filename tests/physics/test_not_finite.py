"""NaN and infinity are refused at the step where they appear, and their rows are named."""

import pickle
import re

import numpy as np
import pytest

import physics
from physics.drawing import Drawing
from physics.environment import Environment, FloatArray, NotFiniteError
from tests.physics.small_tasks import DistanceAtGoal, LogOfNegative

CALLS = ("step", "differentiate")


@pytest.mark.parametrize("call", CALLS)
def test_a_step_that_leaves_the_numbers(call: str) -> None:
    states = np.array([[1.0, 0.0], [-1.0, 0.5], [0.5, 0.0], [0.0, 0.0]])
    with pytest.raises(NotFiniteError) as caught:
        getattr(LogOfNegative(), call)(states, np.full((4, 1), 0.25))
    assert caught.value.rows == (1, 3)
    assert re.fullmatch(
        r"LogOfNegative: next_state\[0\] of row 1 is nan, "
        r"for state \[-1\.0, 0\.5\], action \[0\.25\]",
        str(caught.value),
    )


def test_a_derivative_that_leaves_the_numbers() -> None:
    states, actions = np.array([[1.0, 0.0], [0.0, 0.0]]), np.zeros((2, 1))
    task = DistanceAtGoal()
    assert task.step(states, actions).reward.tolist() == [-1.0, 0.0]
    with pytest.raises(NotFiniteError, match=r"reward_next_state_gradient\[0\] of row 1") as caught:
        task.differentiate(states, actions)
    assert caught.value.rows == (1,)


@pytest.mark.parametrize("call", CALLS)
@pytest.mark.parametrize("value", [np.nan, np.inf, -np.inf])
def test_what_the_caller_gives(call: str, value: float) -> None:
    task = physics.make("CartPole")
    states, actions = np.zeros((9, 4)), np.zeros((9, 1))
    states[3, 2] = actions[7, 0] = value
    with pytest.raises(NotFiniteError, match="must be finite, but row 3 has") as caught:
        getattr(task, call)(states, actions)
    assert caught.value.rows == (3, 7)


@pytest.mark.parametrize("call", CALLS)
def test_compiled_tasks_overflow_by_name(call: str) -> None:
    """From 1e200 on, squares are infinite: the first quantity that shows it is named."""
    task = physics.make("CartPole")
    with pytest.raises(NotFiniteError, match=r"CartPole: .* of row 1 is -?(inf|nan)") as caught:
        getattr(task, call)(np.array([[0.0] * 4, [1e200] * 4]), np.zeros((2, 1)))
    assert caught.value.rows == (1,)


class OneInfinity(Environment):
    """Puts one infinity into any field that a test names."""

    name = "OneInfinity"
    version = state_size = action_size = horizon = 1
    max_reward = 0.0
    place = 0

    def step_kernel(self, states: FloatArray, actions: FloatArray, *outputs: FloatArray) -> int:
        del actions
        for index, output in enumerate(outputs):
            output[:] = 0
            if index == self.place:
                output[len(states) - 1] = -np.inf
        return -1

    differentiate_kernel = step_kernel

    def initial_state(self, generator: np.random.Generator) -> FloatArray:
        return generator.uniform(size=1)

    def draw(self, state: FloatArray) -> Drawing:
        raise NotImplementedError("nothing to see")


FIELDS = (
    "next_state", "reward", "", "state_jacobian", "action_jacobian", "reward_state_gradient",
    "reward_action_gradient", "reward_next_state_gradient",
)  # fmt: skip


@pytest.mark.parametrize("place", [0, 1, 3, 4, 5, 6, 7])
def test_no_quantity_is_left_out(place: int) -> None:
    task = OneInfinity()
    task.place = place
    with pytest.raises(NotFiniteError, match=rf"{FIELDS[place]}\[?.* of row 2 is -inf") as raised:
        task.differentiate(np.zeros((3, 1)), np.zeros((3, 1)))
    assert raised.value.quantity == FIELDS[place].replace("_", " ")


def test_the_rows_survive_the_way_to_another_process() -> None:
    error = NotFiniteError("row 3 is nan", [3, 5], "reward")
    returned = pickle.loads(pickle.dumps(error))  # noqa: S301 - our own
    assert (str(returned), returned.rows) == ("row 3 is nan", (3, 5))
    assert returned.quantity == "reward"
