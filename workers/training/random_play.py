"""Playing at random, to measure a random return.

random      mean undiscounted return of actions U(-1, 1)^m, over episodes of at most T steps
low, high   its 95 % interval: mean -+ t(0.975, n - 1) sd / sqrt(n), sd with ddof 1
n           episodes
"""

import math

import numpy as np
from numpy.typing import NDArray
from scipy.special import stdtrit

import physics
from physics.environment import Environment
from physics.randomness import generator
from physics.task_file import TaskFile, reference
from workers.messages.random_return import RandomReturn

EPISODES = 1000


def measure_random_return(
    environment: str, episodes: int = EPISODES, file: TaskFile | None = None
) -> RandomReturn:
    """Play that many episodes, all at once; the same numbers every time.

    `file` is the text of the task, where the task is of one.

    Raises ValueError for an unknown environment, or fewer than 2 episodes.
    """
    if episodes < 2:
        raise ValueError(f"an interval needs at least 2 episodes, got {episodes}")
    task = physics.make(reference(environment, file))
    returns = random_returns(task, episodes)
    mean = float(returns.mean())
    error = float(returns.std(ddof=1)) / math.sqrt(episodes)
    margin = float(stdtrit(episodes - 1, 0.975)) * error
    return RandomReturn(environment, task.version, mean, mean - margin, mean + margin, episodes)


def random_returns(task: Environment, episodes: int) -> NDArray[np.float64]:
    """Undiscounted return of each episode, float64 [episodes]."""
    draw = generator(0, "random return")
    states = task.initial_states(range(episodes))
    returns = np.zeros(episodes)
    alive = np.arange(episodes)
    for _ in range(task.horizon):
        actions = draw.uniform(-1.0, 1.0, (episodes, task.action_size))
        step = task.step(states, actions[alive])  # an ended episode's row is drawn, not played
        returns[alive] += step.reward
        alive = alive[~step.terminated]
        states = step.next_state[~step.terminated]
        if len(alive) == 0:
            break
    return returns
