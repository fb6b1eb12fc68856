"""MountainCar: energy, walls, and that it can be done."""

import numpy as np

import physics
from physics.environment import FloatArray
from physics.randomness import generator


def energy(s: FloatArray) -> FloatArray:
    total: FloatArray = s[:, 1] ** 2 / 2 + 0.0025 / 3 * np.sin(3 * s[:, 0])
    return total


def test_energy_changes_by_the_motors_work() -> None:
    """The step's error in it is Taylor's remainder: (v' - v)^2 + 3 * 0.0025 v'^2, halved."""
    environment = physics.make("MountainCar")
    random = generator(0, "energy")
    states = random.uniform([-1.0, -0.05], [0.4, 0.05], (1000, 2))
    actions = random.uniform(-1.0, 1.0, (1000, 1))
    following = environment.step(states, actions).next_state
    gained = energy(following) - energy(states) - 0.0015 * actions[:, 0] * following[:, 1]
    v = following[:, 1]
    bound = ((v - states[:, 1]) ** 2 + 3 * 0.0025 * v**2) / 2
    assert (np.abs(gained) <= bound + 1e-15).all()


def test_a_wall_takes_energy() -> None:
    environment = physics.make("MountainCar")
    linearization = environment.differentiate(np.array([[-1.19, -0.05]]), np.array([[-1.0]]))
    np.testing.assert_array_equal(linearization.transition.next_state, [[-1.2, 0.0]])
    assert not linearization.state_jacobian.any()
    assert not linearization.action_jacobian.any()


def test_the_right_wall_stops_the_car_but_not_its_velocity() -> None:
    environment = physics.make("MountainCar")
    linearization = environment.differentiate(np.array([[0.59, 0.05]]), np.array([[0.0]]))
    assert linearization.transition.next_state[0, 0] == 0.6
    assert linearization.transition.next_state[0, 1] > 0.05
    assert not linearization.state_jacobian[0, 0].any()
    assert linearization.state_jacobian[0, 1, 1] == 1.0


def test_driving_the_way_one_moves_climbs_the_hill() -> None:
    environment = physics.make("MountainCar")
    for seed in range(5):
        state, steps, ended = environment.initial_states([seed]), 0, False
        while not ended and steps < environment.horizon:
            push = 1.0 if state[0, 1] >= 0.0 else -1.0
            transition = environment.step(state, np.array([[push]]))
            state, ended, steps = transition.next_state, bool(transition.terminated[0]), steps + 1
        assert ended
    idle = environment.initial_states([0])
    for _ in range(environment.horizon):
        transition = environment.step(idle, np.ones((1, 1)))
        idle = transition.next_state
        assert not transition.terminated[0]  # pushing right alone is too weak
