"""Sampling: states and actions of a robot that reach every regime, for the gradient audit."""

import numpy as np

from physics.environment import Environment, FloatArray


def rollouts(
    environment: Environment, generator: np.random.Generator, count: int
) -> tuple[FloatArray, FloatArray]:
    """A quarter each: under random actions, under bang-bang actions, coming to rest, in flight.

    Each state is the end of its own rollout of up to 100 steps.
    """
    kind = np.arange(count) % 4
    states = environment.initial_states(generator.integers(2**60, size=count))
    states[kind == 3, 1] += generator.uniform(0.3, 1.5, np.count_nonzero(kind == 3))
    longest = np.choose(kind, [100, 100, 100, 4])
    length = generator.integers(0, longest + 1)
    for step in range(100):
        going = np.flatnonzero(step < length)
        actions = generator.uniform(-1.0, 1.0, (count, environment.action_size))
        actions[kind == 1] = np.sign(actions[kind == 1])
        actions[kind == 2] = 0.0
        states[going] = environment.step(states[going], actions[going]).next_state
    actions = generator.uniform(-1.2, 1.2, (count, environment.action_size))
    actions[kind == 2] *= generator.choice([0.05, 0.3], (np.count_nonzero(kind == 2), 1))
    return states, actions
