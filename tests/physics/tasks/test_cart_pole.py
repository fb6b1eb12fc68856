"""CartPole: its reward and its ending."""

import numpy as np

import physics


def test_the_reward_is_one_at_rest_and_zero_in_the_corner() -> None:
    environment = physics.make("CartPole")
    corner = [2.4, 0.0, 12 * np.pi / 180, 0.0]
    transition = environment.step(np.array([[0.0] * 4, corner]), np.zeros((2, 1)))
    np.testing.assert_allclose(transition.reward, [1.0, 0.0], atol=1e-15)
    assert not transition.terminated.any()


def test_it_ends_beyond_the_track_and_beyond_twelve_degrees() -> None:
    environment = physics.make("CartPole")
    beyond = np.nextafter([2.4, 12 * 2 * np.pi / 360], 9.0)
    states = np.zeros((4, 4))
    states[0, 0], states[1, 0], states[2, 2], states[3, 2] = (
        beyond[0],
        -beyond[0],
        beyond[1],
        -beyond[1],
    )
    assert environment.step(states, np.zeros((4, 1))).terminated.all()
