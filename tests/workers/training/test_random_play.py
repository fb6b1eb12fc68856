"""Random returns: of the random policy, with an interval that holds."""

import numpy as np
import pytest

import physics
from physics.randomness import generator
from workers.training.random_play import measure_random_return, random_returns


def test_is_the_same_every_time() -> None:
    assert measure_random_return("Pendulum", 50) == measure_random_return("Pendulum", 50)


def test_plays_episodes_as_one_would_by_hand() -> None:
    """Episode by episode, with the same draws; MassPoint ends its episodes early."""
    task = physics.make("MassPoint")
    episodes = 5
    draws = generator(0, "random return").uniform(
        -1.0, 1.0, (task.horizon, episodes, task.action_size)
    )
    expected = []
    for episode in range(episodes):
        state, total = task.initial_states([episode]), 0.0
        for actions in draws:
            step = task.step(state, actions[episode : episode + 1])
            total += float(step.reward[0])
            state = step.next_state
            if step.terminated[0]:
                break
        expected.append(total)
    np.testing.assert_allclose(random_returns(task, episodes), expected, rtol=1e-12)


def test_the_interval_is_of_the_mean() -> None:
    """-1232.6 within [-1250.3, -1214.9], over 1,000 episodes."""
    measured = measure_random_return("Pendulum")
    assert (measured.environment, measured.episodes) == ("Pendulum", 1000)
    assert measured.version == physics.make("Pendulum").version
    assert measured.low < measured.mean < measured.high
    assert measured.high - measured.low == pytest.approx(35.4, abs=0.1)


def test_an_interval_needs_two_episodes() -> None:
    with pytest.raises(ValueError, match="at least 2 episodes, got 1"):
        measure_random_return("Pendulum", 1)
