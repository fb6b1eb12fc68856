"""The contact problem by itself: small cases by hand, large ones from the cheetah's poses."""

from typing import Any

import numpy as np
import pytest

from physics.environment import FloatArray
from physics.randomness import generator
from physics.robots.dynamics.body import load_action, load_state
from physics.robots.dynamics.substep import solve_substep
from physics.robots.lcp.complementarity import solve
from physics.robots.lcp.contact_mode import OPEN, SLIDE_AHEAD, SLIDE_BACK, STICK
from physics.robots.lcp.lemke import lemke_modes
from physics.tasks.half_cheetah import HalfCheetah

ENVIRONMENT = HalfCheetah()
MECHANISM, BODY, DT = ENVIRONMENT.mechanism[0], ENVIRONMENT.body_type, ENVIRONMENT.substep_seconds


def solved(W: FloatArray, free: FloatArray, friction: list[float]) -> Any:
    """The problem's record after `solve`, from the guess that everything sticks."""
    bodies = np.zeros(1, BODY)
    problem, rows = bodies[0].problem, 2 * len(friction)
    problem.count = len(friction)
    problem.W[:rows, :rows], problem.free[:rows] = W, free
    problem.friction[: len(friction)], problem.mode[: len(friction)] = friction, STICK
    solve(problem)
    return problem


def worst_pair(W: FloatArray, free: FloatArray, friction: FloatArray, impulse: FloatArray) -> float:
    """Largest violation of the problem's conditions, from their definition."""
    velocity = W @ impulse + free
    pn, pt, vn, vt = impulse[0::2], impulse[1::2], velocity[0::2], velocity[1::2]
    rough, speed = friction > 0.0, np.abs(vt)
    pairs = [(pn, vn)]
    pairs += [
        (np.maximum(side * pt, 0.0)[rough], (speed + side * vt)[rough]) for side in (1.0, -1.0)
    ]
    pairs += [(speed[rough], (friction * pn - np.abs(pt))[rough])]
    return max(float(np.abs(np.minimum(x, y)).max(initial=0.0)) for x, y in pairs)


@pytest.mark.parametrize(
    ("free", "mode", "impulse"),
    [
        ([0.5, 3.0], OPEN, [0.0, 0.0]),  # parts by itself
        ([-2.0, 0.6], STICK, [2.0, -0.6]),  # slow enough to be held: |pt| <= 0.4 pn
        ([-2.0, 3.0], SLIDE_AHEAD, [2.0, -0.8]),
        ([-2.0, -3.0], SLIDE_BACK, [2.0, 0.8]),
    ],
)
def test_a_unit_mass_on_the_ground(free: list[float], mode: int, impulse: list[float]) -> None:
    problem = solved(np.eye(2), np.array(free), [0.4])
    assert problem.mode[0] == mode
    np.testing.assert_allclose(problem.impulse[:2], impulse)


def test_a_stop_has_no_friction() -> None:
    problem = solved(np.diag([2.0, 0.0]), np.array([-1.0, 0.0]), [0.0])
    assert problem.mode[0] == STICK
    np.testing.assert_allclose(problem.impulse[:2], [0.5, 0.0])


def test_a_contact_that_others_lift_opens() -> None:
    """Two points of a lever: one is hit hard, and the other, barely closing, comes off."""
    J = np.array([[1.0, -0.2], [0.0, 0.0], [1.0, 1.0], [0.0, 0.0]])
    W = J @ np.diag([1.0, 3.0]) @ J.T
    problem = solved(W, np.array([-3.0, 0.0, -0.1, 0.0]), [0.0, 0.0])
    assert problem.mode[:2].tolist() == [STICK, OPEN]
    np.testing.assert_allclose(problem.impulse[:4], [3.0 / W[0, 0], 0.0, 0.0, 0.0])


@pytest.mark.parametrize(("push", "unknowns"), [(0.1, 4), (0.3, 3)])
def test_two_sticking_contacts_of_one_link_are_singular_and_solved(
    push: float, unknowns: int
) -> None:
    """A plank of unit mass on the ground, pushed aside: three ways to move, four rows.

    The harder push is more than one contact's cone can hold: that one is left at its cone's edge,
    slipping at no speed, and the other holds the rest.
    """
    J = np.array([[0, 1, 1.0], [1, 0, 0.1], [0, 1, -1.0], [1, 0, 0.1]])
    W = J @ np.diag([1.0, 1.0, 3.0]) @ J.T
    free = J @ [push, -1.0, 0.0]
    problem = solved(W, free, [0.4, 0.4])
    assert (problem.unknowns, problem.rank) == (unknowns, 3)
    np.testing.assert_allclose(problem.velocity[:4], 0.0, atol=1e-12)
    assert worst_pair(W, free, np.array([0.4, 0.4]), problem.impulse[:4]) < 1e-12
    assert problem.impulse[1] + problem.impulse[3] == pytest.approx(-push)


def crowded_problems(count: int) -> list[tuple[FloatArray, FloatArray, FloatArray]]:
    """(W, free, friction) of the cheetah's substeps with three candidates or more."""
    random = generator(0, "crowded")
    states = ENVIRONMENT.initial_states(range(500))
    bodies, problems = np.zeros(1, BODY), []
    for step in range(1000):
        if step % 10 == 0:
            actions = np.sign(random.normal(size=(500, 4)))
        states = ENVIRONMENT.step(states, actions).next_state
        for row in random.integers(500, size=20 if step > 30 else 0):
            body = bodies[0]
            load_state(MECHANISM, states, row, body)
            load_action(MECHANISM, actions, row, body)
            solve_substep(MECHANISM, DT, body)
            m = body.problem.count
            if m >= 3:
                W, free = body.problem.W[: 2 * m, : 2 * m], body.problem.free[: 2 * m]
                problems.append((W.copy(), free.copy(), body.problem.friction[:m].copy()))
        if len(problems) >= count:
            return problems
    raise AssertionError(f"only {len(problems)} crowded problems")


def test_crowded_problems_are_solved() -> None:
    for W, free, friction in crowded_problems(1000):
        problem, rows = solved(W, free, friction.tolist()), len(free)
        assert worst_pair(W, free, friction, problem.impulse[:rows]) < 1e-11
        velocity = W @ problem.impulse[:rows] + free
        np.testing.assert_allclose(problem.velocity[:rows], velocity, atol=1e-11)


def test_lemke_finds_the_same_velocities() -> None:
    """On its own, from nothing; where impulses are split otherwise, velocities agree."""
    missed = 0
    for W, free, friction in crowded_problems(1000):
        expected = solved(W, free, friction.tolist())
        mode = np.zeros(len(friction), np.int64)
        lemke_modes(W, free, friction, len(friction), 0, mode, np.zeros(len(free)))
        bodies = np.zeros(1, BODY)
        again = bodies[0].problem
        rows = len(free)
        again.count = len(friction)
        again.W[:rows, :rows], again.free[:rows] = W, free
        again.friction[: len(friction)], again.mode[: len(friction)] = friction, mode
        solve(again)
        np.testing.assert_allclose(again.velocity[:rows], expected.velocity[:rows], atol=1e-9)
        missed += (again.mode[: len(friction)] != mode).any()
    assert missed < 50  # a split that leaves the cone, or a lost path, is settled afterwards
