"""HalfCheetah against its equations, written a second time and solved by brute force."""

import numpy as np

from physics.environment import FloatArray
from physics.randomness import generator
from physics.tasks.half_cheetah import HalfCheetah
from tests.physics.half_cheetah_by_equation import substep

ENVIRONMENT = HalfCheetah()


def states_and_actions() -> tuple[FloatArray, FloatArray]:
    """Sampled ones, and crawls in which three to five constraints were in play at once."""
    random = generator(0, "by equation")
    sampled, sampled_actions = ENVIRONMENT.sample(random, 100)
    states = ENVIRONMENT.initial_states(range(600))
    actions = np.sign(random.normal(size=(600, 4)))
    for step in range(60):
        if step % 10 == 0:
            actions = np.sign(random.normal(size=(600, 4)))
        states = ENVIRONMENT.step(states, actions).next_state
    in_play = (ENVIRONMENT.contact_report(states, actions).mode != 0).sum(axis=2).max(axis=1)
    crawls = np.flatnonzero((in_play >= 3) & (in_play <= 5))[:80]
    return (
        np.concatenate([sampled, states[crawls]]),
        np.concatenate([sampled_actions, actions[crawls]]),
    )


def test_every_step_is_the_brute_force_solution() -> None:
    states, actions = states_and_actions()
    after, report = ENVIRONMENT.step(states, actions), ENVIRONMENT.contact_report(states, actions)
    most_candidates, several = [], 0
    for row in range(len(states)):
        s, a = states[row], np.clip(actions[row], -1.0, 1.0)
        most = 0
        for _ in range(5):
            s, solutions, candidates = substep(ENVIRONMENT, s, a)
            most = max(most, candidates)
            several += solutions > 1
        np.testing.assert_allclose(after.next_state[row], s, rtol=1e-8, atol=1e-8)
        most_candidates.append(most)
    assert np.bincount(most_candidates, minlength=6)[:5].min() >= 5
    assert several > 0  # splits of impulses that differ, with one velocity
    assert (report.mode[:, :, :16] > 1).any(axis=(1, 2)).sum() > 40
