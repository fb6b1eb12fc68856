"""Every task's derivatives against central differences, regime by regime."""

import numpy as np
import pytest

import physics
from physics.audit.differences import differences, relative_errors
from physics.catalogue import OWN
from physics.randomness import generator

COUNT = 1500


@pytest.mark.parametrize("name", OWN)
def test_jacobians_and_reward_gradients(name: str) -> None:
    environment = physics.make(name)
    states, actions = environment.sample(generator(0, "jacobian test"), COUNT)
    reference = differences(environment, states, actions)
    errors = relative_errors(environment.differentiate(states, actions), reference)
    regime = environment.pieces(states, actions).regime
    for index, regime_name in enumerate(environment.regimes):
        smooth = (regime == index) & reference.smooth
        assert smooth.sum() >= 5, f"{regime_name}: {smooth.sum()} smooth states"
        worst = errors[smooth].max()
        assert worst < 1e-6, f"{regime_name}: relative error {worst:.1e}"
    # Where rounding is amplified, narrow widths do not count, and more states are too near a kink.
    assert reference.smooth.mean() > (0.9 if environment.rounding < 1e-13 else 0.8)


@pytest.mark.parametrize("name", OWN)
def test_a_wrong_derivative_is_found(name: str) -> None:
    environment = physics.make(name)
    states, actions = environment.sample(generator(0, "jacobian test"), 20)
    reference = differences(environment, states, actions)
    linearization = environment.differentiate(states, actions)
    jacobian = linearization.state_jacobian
    at_a_wall = ~jacobian.any(axis=(1, 2), keepdims=True)
    jacobian[:] = jacobian * (1.0 + 1e-5) + 1e-5 * at_a_wall
    errors = relative_errors(linearization, reference)
    assert (errors[reference.smooth] > 1e-6).all()


def test_a_state_at_a_kink_is_told_apart() -> None:
    environment = physics.make("Pendulum")
    states = np.array([[0.3, 0.0], [0.3, 0.0], [np.pi, 0.0]])
    actions = np.array([[0.5], [1.0], [0.5]])
    np.testing.assert_array_equal(
        differences(environment, states, actions).smooth, [True, False, False]
    )


def test_where_rounding_is_amplified_narrow_differences_do_not_count() -> None:
    """An action 1e-6 from its clip: only the two narrowest widths fit."""
    environment = physics.make("Pendulum")
    states, actions = np.array([[0.3, 0.0]]), np.array([[1.0 - 1e-6]])
    assert differences(environment, states, actions).smooth.tolist() == [True]
    environment.rounding = 2e-13  # type: ignore[misc]  # of this instance
    assert differences(environment, states, actions).smooth.tolist() == [False]
