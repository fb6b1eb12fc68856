"""HalfCheetah's contacts keep the laws: no penetration, the cone, dissipation, energy, momentum."""

from collections.abc import Iterator
from itertools import pairwise

import numpy as np
import pytest

from physics.environment import FloatArray
from physics.randomness import generator
from physics.robots.dynamics.body import load_action, load_state
from physics.robots.dynamics.substep import advance, solve_substep
from physics.robots.report import ContactReport
from physics.tasks.half_cheetah import HalfCheetah

ENVIRONMENT = HalfCheetah()
CHEETAH = ENVIRONMENT.mechanism
MU, H = 0.4, 0.01
ROWS = 500


def policies(random: np.random.Generator, step: int, rows: int) -> FloatArray:
    """Actions of a mixed crowd: white noise, bang-bang, and both held for 10 steps."""
    actions = random.uniform(-1.0, 1.0, (rows, 4))
    kind = np.arange(rows) % 4
    actions[kind == 1] = np.sign(actions[kind == 1])
    held = np.random.default_rng(step // 10).uniform(-1.5, 1.5, (rows, 4))
    actions[kind == 2] = np.clip(held[kind == 2], -1.0, 1.0)
    actions[kind == 3] = np.sign(held[kind == 3])
    return actions


def rollout(steps: int, seed: int) -> Iterator[tuple[FloatArray, FloatArray, ContactReport]]:
    """States, actions and contacts of 500 episodes side by side, step by step."""
    random = generator(seed, "laws")
    states = ENVIRONMENT.initial_states(random.integers(2**60, size=ROWS))
    for step in range(steps):
        actions = policies(random, step, ROWS)
        yield states, actions, ENVIRONMENT.contact_report(states, actions)
        states = ENVIRONMENT.step(states, actions).next_state


@pytest.fixture(scope="module")
def reports() -> list[tuple[FloatArray, FloatArray, ContactReport]]:
    """An episode of every policy: 10^5 steps, half a million solves."""
    return list(rollout(ENVIRONMENT.horizon, 0))


Reports = list[tuple[FloatArray, FloatArray, ContactReport]]


def test_every_solve_converges_to_round_off(reports: Reports) -> None:
    residuals = np.concatenate([report.residual.ravel() for _, _, report in reports])
    assert residuals.size == 500_000
    assert residuals.max() < 1e-11
    assert np.median(residuals) < 1e-14


def test_no_penetration(reports: Reports) -> None:
    lowest = min(report.gap.min() for _, _, report in reports)
    assert lowest > -5e-3


def test_friction_stays_in_its_cone_and_opposes_the_slip(reports: Reports) -> None:
    slides = sticks = 0
    for _, _, report in reports:
        pn, pt, slip = report.normal_impulse, report.tangential_impulse, report.slip
        assert pn.min() > -1e-11
        assert (np.abs(pt) <= MU * pn + 1e-11).all()
        # maximum dissipation: where it slips, friction is at the cone's edge, against it
        slipping = np.abs(slip) > 1e-9
        np.testing.assert_allclose(pt[slipping], -MU * (np.sign(slip) * pn)[slipping], atol=1e-9)
        slides += int((slipping & (pn > 0.0)).sum())
        sticks += int((~slipping & (pn > 0.0)).sum())
    assert slides > 10_000
    assert sticks > 10_000


def test_impulses_act_at_closed_gaps_alone(reports: Reports) -> None:
    """Where a contact pushes, the solve foresees a gap of 0; the true one differs by the turning:

    |gap| <= h^2 / 2 sum_i |arm_i| omega_i^2, at most 0.75 m for any arm
    """
    pushes = 0
    for (_, _, report), (after, _, _) in pairwise(reports):
        thigh = after[:, [9, 9]] + after[:, [10, 12]]
        turning = after[:, 9] ** 2 + (thigh**2 + (thigh + after[:, [11, 13]]) ** 2).sum(axis=1)
        pushing = report.normal_impulse[:, -1] > 1e-9
        bound = np.broadcast_to(0.75 * H**2 / 2.0 * turning[:, None], pushing.shape)
        assert (np.abs(report.gap[:, -1])[pushing] <= bound[pushing] + 1e-12).all()
        pushes += int(pushing.sum())
    assert pushes > 10_000


def test_joints_stay_within_their_stops(reports: Reports) -> None:
    """Rooms are linear in the coordinates: the solve foresees them exactly."""
    lower = CHEETAH["stop_bound"][0, 0::2]
    upper = CHEETAH["stop_bound"][0, 1::2]
    pushed = 0
    for states, _, report in reports:
        joints = states[:, 3:7]
        assert (joints > lower - 1e-12).all()
        assert (joints < upper + 1e-12).all()
        assert report.stop_impulse.min() > -1e-11
        pushed += int((report.stop_impulse != 0.0).sum())
    assert pushed > 1000


def energy(states: FloatArray) -> FloatArray:
    """Kinetic energy (rotors included), height, springs, up to a constant (J)."""
    q, v = np.ascontiguousarray(states[:, :7]), states[:, 7:]
    kinetic = np.einsum("bi,bij,bj->b", v, ENVIRONMENT.mass_matrix(q), v) / 2.0
    # the forces at rest are minus the potential's slope, so M's row of z gives its height part
    mechanism = CHEETAH[0]
    absolute = q.copy()
    for j in range(3, 7):
        absolute[:, j] += absolute[:, mechanism.parent[j]]
    height = mechanism.mass * q[:, 1]
    for j in range(2, 7):
        x, z = mechanism.moment[j]
        height += z * np.cos(absolute[:, j]) - x * np.sin(absolute[:, j])
    spring = (mechanism.stiffness * q**2).sum(axis=1) / 2.0
    total: FloatArray = kinetic + mechanism.gravity * height + spring
    return total


def test_this_energy_is_that_of_the_forces() -> None:
    """Its slope in q at rest is minus the smooth force."""
    q = generator(0, "energy").uniform(-1.0, 1.0, (20, 7))
    rest = np.zeros((20, 7))
    slopes = np.empty((20, 7))
    for i in range(7):
        step = 1e-5 * np.eye(7)[i]
        above, below = (energy(np.concatenate([q + s * step, rest], axis=1)) for s in (1, -1))
        slopes[:, i] = (above - below) / 2e-5
    forces = ENVIRONMENT.smooth_forces(q, rest, np.zeros((20, 4)))
    np.testing.assert_allclose(slopes, -forces, rtol=0, atol=1e-6)


@pytest.mark.parametrize("start", ["dropped", "thrown", "mid-run"])
def test_energy_never_grows_without_motors(start: str) -> None:
    """Impacts, friction, stops, dampers and the implicit springs only take.

    The scheme itself holds velocities constant over a substep, which in a fast tumble of the whole
    body (10 rad/s) may add a per cent; no start and no run of the task does that.
    """
    states = ENVIRONMENT.initial_states(range(200))
    if start == "thrown":
        states[:, 1] += 1.0
        states[:, 7:] *= 10.0
    if start == "mid-run":
        random = generator(0, "mid-run")
        for _ in range(50):
            states = ENVIRONMENT.step(states, np.sign(random.normal(size=(200, 4)))).next_state
    before = energy(states)
    first = before
    for _ in range(200):
        states = ENVIRONMENT.step(states, np.zeros((200, 4))).next_state
        after = energy(states)
        assert (after <= before + 1e-10).all()
        before = after
    assert np.median(first - before) > 0.1


def test_rest_is_rest() -> None:
    """Left alone it comes to rest, on its feet, carried by the weight's own impulse."""
    states = ENVIRONMENT.initial_states(range(50))
    for _ in range(400):
        states = ENVIRONMENT.step(states, np.zeros((50, 4))).next_state
    assert np.abs(states[:, 7:]).max() < 1e-9
    report = ENVIRONMENT.contact_report(states, np.zeros((50, 4)))
    np.testing.assert_allclose(report.normal_impulse.sum(axis=2), 14.0 * 9.81 * H, rtol=1e-9)
    np.testing.assert_allclose(report.tangential_impulse.sum(axis=2), 0.0, atol=1e-9)


def momentum_defect(state: FloatArray, steps: int, h: float) -> tuple[float, float]:
    """Momentum gained less the impulses of weight and contact, and the contacts' share (N s)."""

    def momentum(q: FloatArray, v: FloatArray) -> FloatArray:
        absolute: FloatArray = np.array([body.pose.M[j, :2] for j in range(2, 7)])
        return np.array([14.0 * v[0], 14.0 * v[1]]) + absolute.T @ v[2:]

    bodies = np.zeros(1, ENVIRONMENT.body_type)
    body, mechanism = bodies[0], CHEETAH[0]
    load_state(mechanism, state[None], 0, body)
    load_action(mechanism, np.zeros((1, 4)), 0, body)
    solve_substep(mechanism, h, body)
    before, given, contacts = momentum(body.q, body.v), np.zeros(2), 0.0
    for _ in range(steps):
        for i in range(body.problem.count):
            if body.candidate[i] < 16:
                pn, pt = body.problem.impulse[2 * i : 2 * i + 2]
                given += [pt, pn]
                contacts += abs(pn) + abs(pt)
        given[1] -= 14.0 * 9.81 * h
        advance(body, h)
        solve_substep(mechanism, h, body)
    gained = momentum(body.q, body.v) - before
    return float(np.abs(gained - given).max()), contacts


@pytest.mark.parametrize("height", [1.0, 0.0])
def test_momentum_changes_by_weight_and_contact_alone(height: float) -> None:
    """Motors, springs, dampers and stops are inner forces, and cancel.

    A substep changes velocities with the masses held in place, so the sum is kept to first order
    in h: it must vanish with it, in flight and over a landing alike.
    """
    state = ENVIRONMENT.initial_states([4])[0]
    state[1] += height
    state[7:] *= 20.0
    defects = []
    for halvings in range(4, 8):
        defect, contacts = momentum_defect(state, 20 * 2**halvings, H / 2**halvings)
        defects.append(defect)
        assert (contacts > 10.0) == (height == 0.0)
    assert defects[-1] < 0.05
    np.testing.assert_allclose(np.divide(defects[1:], defects[:-1]), 0.5, atol=0.15)


@pytest.mark.slow
def test_a_million_steps_meet_no_unsolved_one() -> None:
    worst, lowest = 0.0, 0.0
    for seed in range(1, 11):
        for _, _, report in rollout(ENVIRONMENT.horizon, seed):
            worst = max(worst, report.residual.max())
            lowest = min(lowest, report.gap.min())
    assert worst < 1e-10
    assert lowest > -5e-3
