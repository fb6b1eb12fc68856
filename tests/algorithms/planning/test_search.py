"""The line search: limits kept, no plan ever worse, candidates that go wrong left out."""

import numpy as np
import pytest

import physics
from algorithms.planning.backward import Gains, new_gains
from algorithms.planning.episodes import Episodes
from algorithms.planning.search import ALPHAS, search, try_alphas
from physics.environment import Environment, FloatArray, Transition, UnsolvedStepError
from physics.randomness import generator
from physics.tasks.cart_pole import CartPole
from tests.algorithms.rolled_out import roll_out

PLANS = 3


def random_episodes(environment: Environment) -> Episodes:
    draws = generator(5, "random plan")
    return roll_out(
        environment,
        environment.initial_states(range(PLANS)),
        lambda states: draws.uniform(-1, 1, (len(states), environment.action_size)),
    )


def random_gains(environment: Environment, size: float, draws: np.random.Generator) -> Gains:
    """Nonsense that claims to be an improvement."""
    gains = new_gains(environment, PLANS)
    gains.change[:] = size * draws.normal(size=gains.change.shape)
    gains.feedback[:] = size * draws.normal(size=gains.feedback.shape)
    gains.slope[:] = -1.0
    return gains


def copied(episodes: Episodes) -> Episodes:
    return Episodes._make(part.copy() for part in episodes)


@pytest.mark.parametrize("name", ["Pendulum", "CartPole", "CartPoleSwingUp", "MountainCar"])
@pytest.mark.parametrize("size", [1e-3, 0.1, 10.0, 1e12])
def test_no_plan_gets_worse_and_every_plan_is_what_its_actions_do(name: str, size: float) -> None:
    environment = physics.make(name)
    episodes = random_episodes(environment)
    draws = np.random.default_rng(0)
    stop = 40
    for _ in range(5):
        before = copied(episodes)
        gains = random_gains(environment, size, draws)
        gain = search(environment, np.arange(PLANS), (0, stop), episodes, gains)
        more = episodes.rewards[:, :stop].sum(axis=1) - before.rewards[:, :stop].sum(axis=1)
        assert np.all(gain >= 0.0)
        np.testing.assert_allclose(more, gain, atol=1e-9)
        assert np.abs(episodes.actions).max() <= 1.0
        again = roll_out(environment, episodes.states[:, 0].copy(), Playback(episodes.actions))
        assert np.array_equal(again.states[:, : stop + 1], episodes.states[:, : stop + 1])
        assert np.array_equal(again.rewards[:, :stop], episodes.rewards[:, :stop])
        same = gain == 0.0
        assert np.array_equal(before.actions[same], episodes.actions[same])


class Playback:
    """Given actions [P, T, m], one step after the other."""

    def __init__(self, actions: FloatArray) -> None:
        self.steps = iter(np.swapaxes(actions, 0, 1))

    def __call__(self, states: FloatArray) -> FloatArray:
        return next(self.steps)


def test_what_was_not_to_be_expected_is_not_taken() -> None:
    environment = physics.make("Pendulum")
    episodes = random_episodes(environment)
    before = copied(episodes)
    gains = random_gains(environment, 0.1, np.random.default_rng(0))
    gains.slope[:] = 1.0
    assert search(environment, np.arange(PLANS), (0, 40), episodes, gains).tolist() == [0.0] * PLANS
    assert all(np.array_equal(a, b) for a, b in zip(before, episodes, strict=True))


def test_the_largest_alpha_is_the_whole_change() -> None:
    environment = physics.make("Pendulum")
    episodes = random_episodes(environment)
    gains = new_gains(environment, PLANS)
    gains.change[:] = 0.3 - episodes.actions
    plans = np.arange(PLANS)
    candidates = try_alphas(environment, plans, (0, 10), episodes, gains)
    np.testing.assert_allclose(candidates.actions[:, :: len(ALPHAS)], 0.3, rtol=1e-12)


def test_a_candidate_that_lives_longer_goes_on_with_the_plans_actions() -> None:
    environment = physics.make("CartPole")
    starts = np.array([[0.0, 0.0, 0.15, 0.5]] * PLANS)
    episodes = roll_out(environment, starts, lambda s: np.zeros((len(s), 1)))
    end = int(episodes.ends[0])
    assert 2 < end < 30
    gains = new_gains(environment, PLANS)
    gains.change[:, :end] = 0.6
    gains.slope[:] = -1.0
    gain = search(environment, np.arange(PLANS), (0, 60), episodes, gains)
    assert np.all(gain > 0.0)
    assert np.all(episodes.ends > end)
    assert np.all(episodes.actions[:, end:] == 0.0)
    assert np.all(episodes.rewards[0, episodes.ends[0] : 60] == 0.0)


class Fussy(CartPole):
    """Has no solution beyond a speed of 0.3."""

    def _refuse(self, states: FloatArray) -> None:
        if (np.abs(states[:, 1]) > 0.3).any():
            raise UnsolvedStepError("too fast")

    def step(self, states: FloatArray, actions: FloatArray) -> Transition:
        self._refuse(states)
        return super().step(states, actions)


def test_a_step_without_solution_takes_out_its_own_candidate_alone() -> None:
    fussy, plain = Fussy(), CartPole()
    episodes = roll_out(plain, np.zeros((PLANS, 4)), lambda s: np.zeros((len(s), 1)))
    gains = new_gains(plain, PLANS)
    gains.change[1] = 1.0
    plans = np.arange(PLANS)
    easy, hard = (try_alphas(task, plans, (0, 8), episodes, gains) for task in (plain, fussy))
    is_out = hard.is_out.reshape(PLANS, -1)
    assert not is_out[[0, 2]].any()
    assert is_out[1, 0]
    assert not is_out[1, -1]
    assert not easy.is_out.any()
    assert np.array_equal(easy.states[:, ~hard.is_out], hard.states[:, ~hard.is_out])


@pytest.mark.parametrize("spoil", [np.nan, np.inf, 1e300])
def test_numbers_beyond_all_bounds_leave_the_others_alone(spoil: float) -> None:
    environment = physics.make("MassPoint")
    episodes = random_episodes(environment)
    gains = new_gains(environment, PLANS)
    gains.slope[:] = -1.0
    gains.change[:] = 0.01
    gains.feedback[1] = spoil
    with np.errstate(all="ignore"):
        gain = search(environment, np.arange(PLANS), (0, 20), episodes, gains)
    assert gain[0] > 0.0
    assert gain[2] > 0.0
    assert np.isfinite(episodes.states).all()
