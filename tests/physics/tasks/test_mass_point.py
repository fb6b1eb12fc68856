"""MassPoint against its equations, and its optimal episode."""

import numpy as np

import physics


def test_the_best_policy_takes_49_steps() -> None:
    environment = physics.make("MassPoint")
    state = environment.initial_states([0])
    assert state[0, 0] == -0.5
    total, steps = 0.0, 0
    while True:
        s = state[0, 0]
        transition = environment.step(state, np.array([[1.0]]))
        assert transition.reward[0] == 1.0 / (s * s + 1.0) - 1.0
        assert transition.next_state[0, 0] == s + 0.01
        total, steps, state = total + transition.reward[0], steps + 1, transition.next_state
        if transition.terminated[0]:
            break
    # After 49 steps of 0.01 the point is at -0.01, but for rounding on one side of the goal's edge.
    assert steps in {49, 50}
    assert abs(state[0, 0]) < 0.01


def test_the_optimum_of_the_reward_is_the_origin() -> None:
    environment = physics.make("MassPoint")
    states = np.linspace(-1.0, 1.0, 201)[:, None]
    linearization = environment.differentiate(states, np.zeros((201, 1)))
    assert np.argmax(linearization.transition.reward) == 100
    uphill = linearization.reward_state_gradient[:, 0] * states[:, 0]
    assert (uphill[states[:, 0] != 0.0] < 0.0).all()
