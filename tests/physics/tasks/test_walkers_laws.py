"""Contacts of Hopper and Walker2d keep the laws: no penetration, the cone, dissipation, energy."""

from collections.abc import Iterator

import numpy as np
import pytest

from physics.environment import FloatArray
from physics.randomness import generator
from physics.robots.report import ContactReport
from physics.robots.task import RobotTask
from physics.tasks.hopper import Hopper
from physics.tasks.walker2d import Walker2d
from tests.physics.robot_energy import energy

ROWS, STEPS = 300, 150

Reports = list[tuple[FloatArray, ContactReport]]


@pytest.fixture(scope="module", params=[Hopper, Walker2d], ids=lambda task: task.name)
def environment(request: pytest.FixtureRequest) -> RobotTask:
    task: RobotTask = request.param()
    return task


def policies(random: np.random.Generator, step: int, size: int) -> FloatArray:
    """Actions of a mixed crowd: white noise, bang-bang, and both held for 10 steps."""
    actions = random.uniform(-1.0, 1.0, (ROWS, size))
    kind = np.arange(ROWS) % 4
    actions[kind == 1] = np.sign(actions[kind == 1])
    held = np.random.default_rng(step // 10).uniform(-1.5, 1.5, (ROWS, size))
    actions[kind == 2] = np.clip(held[kind == 2], -1.0, 1.0)
    actions[kind == 3] = np.sign(held[kind == 3])
    return actions


def rollout(environment: RobotTask, steps: int) -> Iterator[tuple[FloatArray, ContactReport]]:
    """States and contacts of episodes side by side, which go on when they have fallen."""
    random = generator(0, "laws")
    states = environment.initial_states(random.integers(2**60, size=ROWS))
    for step in range(steps):
        actions = policies(random, step, environment.action_size)
        yield states, environment.contact_report(states, actions)
        states = environment.step(states, actions).next_state


@pytest.fixture(scope="module")
def reports(environment: RobotTask) -> Reports:
    """45,000 steps, 180,000 solves."""
    return list(rollout(environment, STEPS))


def test_every_solve_converges_to_round_off(reports: Reports) -> None:
    residuals = np.concatenate([report.residual.ravel() for _, report in reports])
    assert residuals.max() < 1e-10
    assert np.median(residuals) < 1e-13


def test_no_penetration(reports: Reports) -> None:
    assert min(report.gap.min() for _, report in reports) > -5e-3


def test_friction_stays_in_its_cone_and_opposes_the_slip(
    environment: RobotTask, reports: Reports
) -> None:
    """Each sphere's cone is its own."""
    mu = environment.mechanism["friction"][0]
    slides = sticks = 0
    for _, report in reports:
        pn, pt, slip = report.normal_impulse, report.tangential_impulse, report.slip
        assert pn.min() > -1e-11
        assert (np.abs(pt) <= mu * pn + 1e-11).all()
        slipping = np.abs(slip) > 1e-9
        np.testing.assert_allclose(pt[slipping], (-mu * np.sign(slip) * pn)[slipping], atol=1e-9)
        slides += int((slipping & (pn > 0.0)).sum())
        sticks += int((~slipping & (pn > 0.0)).sum())
    assert slides > 1000
    assert sticks > 1000


def test_joints_stay_within_their_stops(environment: RobotTask, reports: Reports) -> None:
    joints = [link.joint for link in environment.robot.links if link.joint is not None]
    lower, upper = np.array([(joint.lower, joint.upper) for joint in joints]).T
    pushed = 0
    for states, report in reports:
        angles = states[:, 3 : 3 + len(joints)]
        assert (angles > lower - 1e-12).all()
        assert (angles < upper + 1e-12).all()
        assert report.stop_impulse.min() > -1e-11
        pushed += int((report.stop_impulse != 0.0).sum())
    assert pushed > 1000


@pytest.mark.parametrize(
    ("state", "action"),
    [
        (
            "0.9217645526823227 0.7997312813394283 0.897152953169983 0 -1.1102230246251565e-16 "
            "0.7853981633974482 0 0 0.7853981633974483 2.42944846958249 -2.1086837197413826 "
            "3.021945946950937 0 -7.771561172376096e-14 4.440892098500626e-16 "
            "5.551115123125783e-14 0 -5.595524044110789e-14",
            [0.03] * 6,
        ),
        (
            "0.4963340429271019 0.6285578005828983 -1.674897906553088 -2.6179938779914944 0 "
            "0.7853981633974483 -2.6179938779914944 0 0.7853981633974483 1.9376681116536514 "
            "-1.1387170897058252 3.0716435930682326 4.440892098500626e-16 -4.440892098500626e-16 "
            "4.440892098500626e-16 0 0 0",
            [-0.1, 0.1, 0.1, -0.1, 0.1, 0.1],
        ),
        (
            "0.00922674540449548 1.209876109712928 0.014680229542654702 0 1.734723475976807e-18 "
            "0.706767041382512 -2.806063572474704e-09 0 0.7853981633974483 0.019785412428929193 "
            "0.0017877316437997818 -0.10476772410540303 -2.3592239273284576e-16 "
            "1.0408340855860843e-15 -2.4423500501391624 9.825904409557773e-05 "
            "7.771561172376096e-16 -5.484501741648273e-14",
            [0.93926519, 0.7407532930374146, 0.31672973, 0.89229959, 0.73610896, 0.95784695],
        ),
        (
            "0.011282591783823641 1.2099227187077533 0.011593591943270948 -3.352349932372878e-09 "
            "-1.734723475976807e-18 0.7853981633974483 -3.469446951953614e-18 "
            "1.734723475976807e-18 0.021935725301701632 -0.014179495586923113 "
            "0.0005828412388878007 -0.04365131927268927 0.00022203767753403714 "
            "6.938893903907228e-17 8.604228440844963e-16 -2.435551760271437e-15 "
            "1.3808398868775384e-15 -0.6439196018705564",
            [
                0.9999997615814209,
                0.9999997615814209,
                0.9931886196136475,
                0.9974923729896545,
                0.9994709491729736,
                0.09431421756744385,
            ],
        ),
    ],
)
def test_legs_in_one_place_with_all_joints_at_their_stops(state: str, action: list[float]) -> None:
    """Contacts of different legs repeat each other, and not every split of impulses will do."""
    states, actions = np.array([state.split()], np.float64), np.array([action])
    report = Walker2d().contact_report(states, actions)
    assert report.residual.max() < 1e-11
    assert (report.normal_impulse >= -1e-11).all()
    assert (np.abs(report.tangential_impulse) <= 1.9 * report.normal_impulse + 1e-11).all()


def test_this_energy_is_that_of_the_forces(environment: RobotTask) -> None:
    """Its slope in q at rest is minus the smooth force."""
    n = environment.state_size // 2
    q = generator(0, "energy").uniform(-1.0, 1.0, (20, n))
    rest, slopes = np.zeros((20, n)), np.empty((20, n))
    for i in range(n):
        step = 1e-5 * np.eye(n)[i]
        above, below = (
            energy(environment, np.concatenate([q + s * step, rest], axis=1)) for s in (1, -1)
        )
        slopes[:, i] = (above - below) / 2e-5
    forces = environment.smooth_forces(q, rest, np.zeros((20, environment.action_size)))
    np.testing.assert_allclose(slopes, -forces, rtol=0, atol=1e-6)


def fall(environment: RobotTask) -> FloatArray:
    """Energies [steps, 100] of robots that are let go as they stand (J)."""
    states = environment.initial_states(range(100))
    idle = np.zeros((100, environment.action_size))
    energies = [energy(environment, states)]
    for _ in range(500):
        states = environment.step(states, idle).next_state
        energies.append(energy(environment, states))
    return np.array(energies)


def test_energy_does_not_grow_without_motors(environment: RobotTask) -> None:
    """Impacts, friction, stops and dampers only take.

    The scheme itself holds velocities constant over a substep: a hopper that topples over its toe
    gains some millijoules of its 100 J. That vanishes with the substep.
    """
    energies = fall(environment)
    growth = np.diff(energies, axis=0).max()
    assert (energies[0] - energies[-1] > 10.0).all()
    assert growth < 5e-3
    finer = {"substep_seconds": environment.substep_seconds / 4, "substeps": 16}
    fine = type(environment.name, (type(environment),), finer)()
    assert np.diff(fall(fine), axis=0).max() < max(0.25 * growth, 1e-10)


def test_rest_is_rest(environment: RobotTask) -> None:
    """Left alone it comes to lie, carried by the weight's own impulse."""
    states = environment.initial_states(range(20))
    idle = np.zeros((20, environment.action_size))
    for _ in range(2500):
        states = environment.step(states, idle).next_state
    n = environment.state_size // 2
    assert np.abs(states[:, n:]).max() < 1e-6
    report = environment.contact_report(states, idle)
    weight = environment.robot.total_mass * 9.81 * environment.substep_seconds
    np.testing.assert_allclose(report.normal_impulse.sum(axis=2), weight, rtol=1e-6)
    np.testing.assert_allclose(report.tangential_impulse.sum(axis=2), 0.0, atol=1e-6)
