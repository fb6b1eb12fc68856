"""The surface of figure 2: the truth by hand, and the critic's and actor's own answers."""

import numpy as np
import pytest

import physics
from tests.workers.policies.test_episode import learnt
from workers.policies.critic_surface import best_values, critic_surface

POINT = physics.make("MassPoint")


def reward(s: float) -> float:
    return 1 / (s * s + 1) - 1


def test_the_truth_by_hand() -> None:
    """From 0.035: away to 0.045, then back to 0.015, and the last step ends at 0.005."""
    found = best_values(POINT, np.array([[0.035]]), np.array([[1.0]]), 0.9)
    visited = [0.035, 0.045, 0.035, 0.025, 0.015]
    expected = sum(0.9**step * reward(s) for step, s in enumerate(visited))
    assert found[0] == pytest.approx(expected, rel=1e-12)


def test_no_first_action_is_better_than_the_best() -> None:
    """Where the goal is further than a step, full speed towards it is the best first action."""
    actions = np.linspace(-1, 1, 21)[:, None]
    for s in (-0.5, 0.3):
        values = best_values(POINT, np.full((21, 1), s), actions, 0.99)
        assert values.argmax() == (20 if s < 0 else 0)


def test_the_surface_is_the_snapshots() -> None:
    snapshot = learnt(POINT)
    surface = critic_surface(POINT, snapshot, 0.99)
    assert surface.value.shape == surface.truth.shape == (41, 21)
    at = np.array([[surface.positions[7]]]), np.array([[surface.actions[3]]])
    features = POINT.features(at[0])
    own = snapshot.values(features, at[1])[0]  # float32: a product's bits go with its rows
    assert surface.value[7, 3] == pytest.approx(own, rel=1e-5)
    assert surface.truth[7, 3] == best_values(POINT, *at, 0.99)[0]
    assert surface.policy[7] == snapshot.policies().act(features)[0, 0]
