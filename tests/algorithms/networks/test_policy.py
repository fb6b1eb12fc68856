"""A uniform policy of actors of both kinds."""

import numpy as np
import pytest

from algorithms.networks.parameters import initial_theta
from algorithms.networks.policy import Policies, deterministic, uniform
from algorithms.networks.shape import Shape
from physics.randomness import generator

STEPS, INPUTS, ACTIONS = 400, 3, 2


@pytest.mark.parametrize("outputs", [ACTIONS, 2 * ACTIONS], ids=["deterministic", "stochastic"])
def test_its_actions_are_the_uniform_draws_whatever_was_learned_and_seen(outputs: int) -> None:
    shape = Shape(INPUTS, (8, 8), outputs)
    theta = 10 * initial_theta(shape, generator(3, "actor"))
    mean, inverse = np.full(INPUTS, 0.5, np.float32), np.full(INPUTS, 2.0, np.float32)
    learned = deterministic(theta, mean, inverse, ACTIONS)
    policy = uniform(learned, shape, (STEPS, ACTIONS), generator(3, "uniform actions"))
    policies, seen = Policies([policy], shape), generator(3, "features")
    actions = [policies.act(seen.standard_normal((1, INPUTS)))[0] for _ in range(STEPS)]
    draws = generator(3, "uniform actions").uniform(-1, 1, (STEPS, ACTIONS))
    np.testing.assert_allclose(actions, draws, atol=2e-6)
    assert policy.mean is mean
    assert not policy.theta.any()
