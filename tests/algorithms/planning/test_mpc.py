"""MPC end to end: exact where exactness is possible, honest about what it predicts."""

import numpy as np
import pytest
from scipy.optimize import lsq_linear

import algorithms
import physics
from algorithms.experience.rollout import start_states
from algorithms.learner import Learner
from algorithms.measurement import Measurement
from algorithms.planning.mpc import MPCLearner, first_plans
from algorithms.settings import MPCConfig
from physics.environment import Environment, FloatArray
from tests.algorithms.linear_quadratic import COST, FB, LinearQuadratic
from tests.algorithms.planning.test_planner import condensed
from workers.training.random_play import measure_random_return

HOUR = 10**7
"""More timesteps than any episode here takes."""


class Calm(LinearQuadratic):
    """Too near to rest for any bound to matter."""

    def initial_state(self, generator: np.random.Generator) -> FloatArray:
        return 0.01 * super().initial_state(generator)


class Wild(LinearQuadratic):
    """Far enough from rest for bounds to matter."""

    def initial_state(self, generator: np.random.Generator) -> FloatArray:
        return 8.0 * super().initial_state(generator)


def whole(learner: MPCLearner) -> dict[int, list[Measurement]]:
    found: dict[int, list[Measurement]] = {seed: [] for seed in learner.seeds}
    while not learner.finished:
        for m in learner.advance():
            assert isinstance(m, Measurement)
            found[m.seed].append(m)
    return found


def iter_events(learner: Learner) -> list[object]:
    events: list[object] = []
    while not learner.finished:
        events += learner.advance()
    return events


def start(task: Environment, seed: int) -> FloatArray:
    states, _ = start_states(task, [(seed, "episode", 0)])
    state: FloatArray = states[0]
    return state


def riccati_cost(state: FloatArray, steps: int) -> float:
    """`s' P s / 2`, P from the Riccati recursion on the stacked cost."""
    n = LinearQuadratic.state_size
    P = np.zeros((n, n))
    for _ in range(steps):
        Q = COST + FB.T @ P @ FB
        P = Q[:n, :n] - Q[:n, n:] @ np.linalg.solve(Q[n:, n:], Q[n:, :n])
    return float(state @ P @ state) / 2


def reference_return(state: FloatArray, horizon: int) -> float:
    """Receding horizon by a quadratic program an action, solved by scipy."""
    steps, m, total = LinearQuadratic.horizon, FB.shape[1] - len(state), 0.0
    for t in range(steps):
        A, c = condensed(state, min(horizon, steps - t))
        plan = lsq_linear(A, -c, (-1.0, 1.0), method="bvls", tol=1e-14, max_iter=1000).x
        x = np.concatenate([state, plan[:m]])
        total -= x @ COST @ x / 2
        state = FB @ x
    return float(total)


def test_without_bounds_it_earns_what_riccati_says() -> None:
    task = Calm()
    found = whole(MPCLearner(task, [0, 1], HOUR, MPCConfig(horizon=20, iterations=200)))
    for seed, measurements in found.items():
        cost = riccati_cost(start(task, seed), task.horizon)
        assert measurements[-1].return_mean == pytest.approx(-cost, rel=1e-6, abs=1e-12)


@pytest.mark.parametrize("horizon", [4, 20])
def test_with_bounds_it_earns_what_a_reference_program_does(horizon: int) -> None:
    task = Wild()
    found = whole(MPCLearner(task, [0, 1], HOUR, MPCConfig(horizon=horizon, iterations=200)))
    for seed, measurements in found.items():
        expected = reference_return(start(task, seed), horizon)
        assert measurements[-1].return_mean == pytest.approx(expected, rel=1e-5)


def test_it_predicts_with_what_is_collected_planned_and_left_of_the_first_rollout() -> None:
    task, seeds = physics.make("CartPoleSwingUp"), [0, 1]
    initial, _ = first_plans(task, seeds, 64)
    learner = MPCLearner(task, seeds, 4_000, MPCConfig(horizon=30, iterations=1))
    found = whole(learner)
    for p, seed in enumerate(seeds):
        # 500 steps of the rollout and 330 of a search pass 800 before any action is done.
        assert found[seed][0].return_mean == pytest.approx(initial.rewards[p].sum(), rel=1e-12)
        assert found[seed][-1].return_mean != found[seed][0].return_mean
        assert [m.timestep for m in found[seed]] == [800, 1600, 2400, 3200, 4000]


def test_the_last_measurement_is_what_the_episode_earned() -> None:
    task = physics.make("Pendulum")
    learner = MPCLearner(task, [3], HOUR, MPCConfig(horizon=25, iterations=2))
    planner = learner._planner
    last: list[Measurement] = []
    actions = planner.episodes.actions
    while not learner.finished:
        actions = planner.episodes.actions if learner.seeds else actions
        last = [m for m in learner.advance() if isinstance(m, Measurement)] or last
    state, total = start(task, 3)[None], 0.0
    for t in range(task.horizon):
        step = task.step(state, actions[:, t].copy())
        state, total = step.next_state, total + float(step.reward[0])
    assert last[-1].return_mean == pytest.approx(total, rel=1e-12)
    assert last[-1].diagnostics["actions"] == task.horizon
    assert last[-1].diagnostics["collected_return"] == last[-1].return_mean


def test_it_plans_without_the_noise_and_acts_with_it() -> None:
    task = physics.make("Pendulum", process_noise=0.05, observation_noise=5.0)
    learner = MPCLearner(task, [3, 4], HOUR, MPCConfig(horizon=10, iterations=2))
    planner, exact = learner._planner, task.without_noise()
    last: dict[int, Measurement] = {}
    while not learner.finished:
        now, actions = int(learner._times.min()), planner.episodes.actions
        last |= {m.seed: m for m in learner.advance() if isinstance(m, Measurement)}
        if learner.seeds and now % 50 == 40:  # what is ahead of it follows without noise
            here = np.ascontiguousarray(planner.episodes.states[:, now + 1])
            ahead = exact.step(here, np.ascontiguousarray(actions[:, now + 1])).next_state
            np.testing.assert_array_equal(planner.episodes.states[:, now + 2], ahead)
    for row, seed in enumerate([3, 4]):
        state, total = start(task, seed)[None], 0.0
        for t in range(task.horizon):
            step = task.step(state, actions[row : row + 1, t].copy())
            state, total = step.next_state, total + float(step.reward[0])
        assert last[seed].return_mean == pytest.approx(total, rel=1e-12)


def test_a_run_has_the_same_bits_alone_in_a_cohort_and_after_others_are_dropped() -> None:
    def curves(seeds: list[int], dropped: list[int]) -> list[tuple[object, ...]]:
        learner = algorithms.build("mpc", "Pendulum", seeds, (0, 0), 20_000, {"horizon": 25})
        learner.advance()
        learner.drop(dropped)
        found = []
        while not learner.finished:
            found += [m for m in learner.advance() if m.seed == 5]
        return [
            (m.timestep, m.return_mean, m.return_history, m.updates, m.jacobians)
            for m in found
            if isinstance(m, Measurement)
        ]

    alone = curves([5], [])
    assert len(alone) == 25
    assert curves(list(range(16)), []) == alone
    assert curves([4, 5, 6], [4, 6]) == alone


def test_an_episode_that_the_task_ends_ends_the_run() -> None:
    learner = algorithms.build("mpc", "MassPoint", [0], (0, 0), HOUR, {"iterations": 5})
    found = [m for m in iter_events(learner) if isinstance(m, Measurement)]
    assert found[-1].diagnostics["actions"] == 49  # full speed: see test_ilqr
    assert found[-1].timestep < HOUR


def test_it_refuses_a_task_without_reward_gradient() -> None:
    with pytest.raises(ValueError, match=r"mpc needs the reward's gradient, and that of Acrobot"):
        algorithms.build("mpc", "Acrobot", [0])


@pytest.mark.slow
def test_it_solves_the_swing_up() -> None:
    """Recorded (preset, seeds 0 to 15): mean 0.900, least 0.880."""
    task, random = physics.make("CartPoleSwingUp"), measure_random_return("CartPoleSwingUp").mean
    last = {m.seed: m.return_mean for m in algorithms.train("mpc", task.name, range(16))}
    scores = (np.array(list(last.values())) - random) / (task.max_reward * task.horizon - random)
    print(f"normalised return: mean {scores.mean():.3f}, least {scores.min():.3f}")  # noqa: T201
    assert len(scores) == 16
    assert scores.min() > 0.6
