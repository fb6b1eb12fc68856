"""iLQR whole: exact where exactness is possible, better at every iteration, blind to neighbours."""

import numpy as np
import pytest
from scipy.linalg import block_diag, sqrtm
from scipy.optimize import lsq_linear

import physics
from algorithms.planning.backward import LARGEST
from algorithms.planning.episodes import Episodes, replay
from algorithms.planning.planner import Planner
from physics.environment import Environment, FloatArray
from physics.randomness import generator
from tests.algorithms.linear_quadratic import COST, FB, LinearQuadratic
from tests.algorithms.rolled_out import roll_out

N = LinearQuadratic.state_size


def quiet_episodes(environment: Environment, seeds: list[int], scale: float = 1.0) -> Episodes:
    """Next to no action from each seed's start state."""
    actions = [
        generator(seed, "quiet").uniform(-3e-3, 3e-3, environment.action_size) for seed in seeds
    ]
    starts = scale * environment.initial_states(seeds)
    return roll_out(environment, starts, lambda states: np.array(actions))


def plan_to_convergence(planner: Planner, window: tuple[int, int]) -> None:
    planner.begin(np.arange(len(planner.is_active)))
    for _ in range(500):
        if not planner.is_active.any():
            return
        planner.iterate(*window, np.flatnonzero(planner.is_active))
    raise AssertionError("no convergence")


def condensed(start: FloatArray, steps: int) -> tuple[FloatArray, FloatArray]:
    """All x = (s, a) of a linear episode as `M u + c` of its actions u, weighed by sqrt(COST)."""
    m = FB.shape[1] - N
    root = block_diag(*[np.real(sqrtm(COST))] * steps)
    M, c = np.zeros((steps, N + m, steps * m)), np.zeros((steps, N + m))
    to_state, state = np.zeros((N, steps * m)), start
    for t in range(steps):
        M[t, :N], c[t, :N] = to_state, state
        M[t, N:, t * m : (t + 1) * m] = np.eye(m)
        to_state, state = FB @ M[t], FB @ c[t]
    return root @ M.reshape(-1, steps * m), root @ c.ravel()


@pytest.mark.parametrize("scale", [0.01, 8.0, 30.0])
def test_it_finds_the_optimum_of_a_linear_quadratic_task(scale: float) -> None:
    """Without bounds (Riccati), with some actions on them, with nearly all."""
    task = LinearQuadratic()
    episodes = quiet_episodes(task, [0, 1, 2], scale)
    plan_to_convergence(Planner(task, episodes), (0, task.horizon))
    for p in range(3):
        A, c = condensed(episodes.states[p, 0], task.horizon)
        optimum = lsq_linear(A, -c, (-1.0, 1.0), method="bvls", tol=1e-14, max_iter=1000)
        clamped = np.mean(np.abs(optimum.x) > 1 - 1e-9)
        assert clamped == 0.0 if scale < 0.1 else clamped > 0.02
        assert -episodes.rewards[p].sum() == pytest.approx(optimum.cost, rel=1e-7, abs=1e-9)
        np.testing.assert_allclose(episodes.actions[p].ravel(), optimum.x, atol=2e-4)


@pytest.mark.parametrize("name", ["Pendulum", "CartPole", "CartPoleSwingUp", "MountainCar"])
def test_every_iteration_is_at_least_as_good_as_the_one_before(name: str) -> None:
    task = physics.make(name)
    episodes = quiet_episodes(task, [0, 1])
    planner = Planner(task, episodes)
    planner.begin(np.arange(2))
    returns = [episodes.rewards[:, :60].sum(axis=1)]
    for _ in range(20):
        if planner.is_active.any():
            planner.iterate(0, 60, np.flatnonzero(planner.is_active))
        returns.append(episodes.rewards[:, :60].sum(axis=1))
        assert np.abs(episodes.actions).max() <= 1.0
    gains = np.diff(returns, axis=0)
    assert gains.min() >= -1e-12
    assert gains.sum(axis=0).min() > 0.0


@pytest.mark.parametrize("name", ["Pendulum", "CartPole", "CartPoleSwingUp", "MassPoint"])
def test_a_plan_has_the_same_bits_alone_and_in_any_cohort(name: str) -> None:
    task = physics.make(name)

    def planned(seeds: list[int]) -> dict[int, tuple[bytes, ...]]:
        episodes = quiet_episodes(task, seeds)
        planner = Planner(task, episodes)
        for t in range(4):
            planner.begin(np.flatnonzero(episodes.ends > t))
            for _ in range(6):
                if planner.is_active.any():
                    planner.iterate(t, t + 30, np.flatnonzero(planner.is_active))
            replay(task, episodes, t + 30)
        parts = (*episodes, *planner.regularisation, planner.iterations, planner.jacobians)
        return {seed: tuple(part[p].tobytes() for part in parts) for p, seed in enumerate(seeds)}

    alone = {seed: planned([seed])[seed] for seed in (3, 8)}
    many = planned([5, 8, 0, 3, 9, 1, 2])
    assert many[3] == alone[3]
    assert many[8] == alone[8]
    assert planned([8, 3]) == {8: alone[8], 3: alone[3]}


def test_keeping_some_plans_leaves_them_as_they_would_have_been() -> None:
    task = physics.make("CartPoleSwingUp")
    whole = quiet_episodes(task, [0, 1, 2])
    planners = [Planner(task, Episodes._make(part.copy() for part in whole)) for _ in range(2)]
    for planner in planners:
        planner.begin(np.arange(3))
        planner.iterate(0, 40, np.arange(3))
    planners[1].keep([2, 0])
    for planner in planners:
        planner.iterate(0, 40, np.flatnonzero(planner.is_active))
    for kept, part in zip(planners[1].episodes, planners[0].episodes, strict=True):
        assert np.array_equal(kept, part[[2, 0]])


def test_a_fall_within_the_window_is_planned_away() -> None:
    task = physics.make("CartPole")
    episodes = roll_out(
        task, np.array([[0.0, 0.0, 0.05, 0.4]]), lambda states: np.zeros((len(states), 1))
    )
    assert episodes.ends[0] < 30
    planner = Planner(task, episodes)
    plan_to_convergence(planner, (0, 100))
    replay(task, episodes, 100)
    assert episodes.ends[0] > 100
    assert episodes.rewards[0, :100].mean() > 0.95


def test_the_end_of_the_task_is_the_end_of_the_costs() -> None:
    """MassPoint pays for every step until it arrives: the quickest way is full speed."""
    task = physics.make("MassPoint")
    episodes = quiet_episodes(task, [0])
    plan_to_convergence(Planner(task, episodes), (0, 60))
    assert episodes.ends[0] == 49  # 0.5 m at 0.01 m a step, less the goal's radius
    assert np.all(episodes.actions[0, :45] == 1.0)
    assert np.all(episodes.rewards[0, 49:60] == 0.0)


def test_beginning_a_plan_leaves_the_regularisation_of_others_alone() -> None:
    environment = physics.make("Pendulum")
    starts = environment.initial_states(range(2))
    planner = Planner(environment, roll_out(environment, starts, lambda s: np.zeros((len(s), 1))))
    planner.regularisation.level[:] = 2 * LARGEST
    planner.regularisation.growth[:] = 1.6
    planner.begin(np.array([1]))
    assert planner.regularisation.level.tolist() == [2 * LARGEST, 1.0]
    assert planner.regularisation.growth.tolist() == [1.6, 1.0]
    assert planner.is_active.tolist() == [False, True]
