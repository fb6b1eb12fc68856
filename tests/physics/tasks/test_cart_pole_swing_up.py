"""CartPoleSwingUp: energy over an episode, and that it can be done."""

import numpy as np

import physics
from physics.environment import FloatArray
from physics.tasks.cart_and_pole import CART_MASS, GRAVITY, HALF_LENGTH, POLE_MASS

TOTAL_MASS = CART_MASS + POLE_MASS
POLE_MOMENT = POLE_MASS * HALF_LENGTH


def energy(s: FloatArray) -> FloatArray:
    speed, theta, omega = s[:, 1], s[:, 2], s[:, 3]
    total: FloatArray = (
        TOTAL_MASS * speed**2 / 2
        + POLE_MOMENT * speed * omega * np.cos(theta)
        + 2 / 3 * POLE_MASS * HALF_LENGTH**2 * omega**2
        + POLE_MASS * GRAVITY * HALF_LENGTH * np.cos(theta)
    )
    return total


def test_a_free_pole_is_not_pumped_up() -> None:
    """Over an episode its energy breathes by 5 % of the swing's, and in the long run it falls.

    Explicit Euler would add more than half of the swing's energy an episode.
    """
    start = np.array([[0.0, 0.0, 1.0, 0.0], [0.0, 0.2, 2.0, 1.0], [0.0, 0.0, 0.05, 0.0]])
    swing = 2 * POLE_MASS * GRAVITY * HALF_LENGTH

    def gains(name: str) -> FloatArray:
        environment, state, along = physics.make(name), start, []
        for _ in range(4_000):
            state = environment.step(state, np.zeros((3, 1))).next_state
            along.append((energy(state) - energy(start)) / swing)
        return np.array(along)

    gained, pumped = gains("CartPoleSwingUp"), gains("CartPole")
    assert (np.abs(gained[:500]) < 0.05).all()
    assert (gained < 0.05).all()
    assert (gained[-500:].mean(axis=0) < 0.0).all()
    assert (pumped[500] > 0.5).all()


def test_a_swinging_policy_gets_the_pole_up() -> None:
    """Pumping energy up to that of the upright pole brings it there, inside the track."""
    environment = physics.make("CartPoleSwingUp")
    state, best = environment.initial_states([0]), -1.0
    for _ in range(environment.horizon):
        x, speed, theta, omega = state[0]
        missing = (
            POLE_MASS * GRAVITY * HALF_LENGTH - energy(np.array([[0.0, 0.0, theta, omega]]))[0]
        )
        # The sign of omega cos(theta): the push against which the pole swings.
        force = -2.0 * np.sign(omega * np.cos(theta)) * np.sign(missing) - 0.8 * x - 0.8 * speed
        transition = environment.step(state, np.array([[force]]))
        assert not transition.terminated[0]
        state, best = transition.next_state, max(best, float(np.cos(transition.next_state[0, 2])))
    assert best > 0.95


def test_it_ends_beyond_the_track_alone() -> None:
    environment = physics.make("CartPoleSwingUp")
    states = np.array([[2.41, 0.0, 0.0, 0.0], [-2.41, 0.0, 0.0, 0.0], [2.39, 0.0, 3.0, 0.0]])
    terminated = environment.step(states, np.zeros((3, 1))).terminated
    np.testing.assert_array_equal(terminated, [True, True, False])
