"""RollingDie: the laws it keeps, the facts it reproduces, its derivatives regime by regime."""

import numpy as np
import pytest

import physics
from physics.audit.audit import audit
from physics.audit.record import as_table
from physics.environment import FloatArray, UnsolvedStepError
from physics.impacts.impulse import REVERSE
from physics.randomness import generator
from physics.tasks.rolling_die import RollingDie

GRAVITY = 9.81


@pytest.fixture(scope="module")
def environment() -> RollingDie:
    made = physics.make("RollingDie")
    assert isinstance(made, RollingDie)
    return made


def energy(states: FloatArray) -> FloatArray:
    _, y, _, vx, vy, omega = states.T
    total: FloatArray = (vx**2 + vy**2) / 2 + omega**2 / 12 + GRAVITY * y
    return total


def lowest_gap(states: FloatArray) -> FloatArray:
    low: FloatArray = states[:, 1] - 0.5 * (
        np.abs(np.cos(states[:, 2])) + np.abs(np.sin(states[:, 2]))
    )
    return low


def journeys(environment: RollingDie, steps: int, torque: float) -> list[tuple[FloatArray, ...]]:
    """(states, actions, next states) of dice thrown, and of dice in every kind of contact."""
    random = generator(0, f"journeys {torque}")
    states = np.concatenate(
        [environment.initial_states(range(500)), environment.sample(random, 3000)[0]]
    )
    walked: list[tuple[FloatArray, ...]] = []
    for _ in range(steps):
        actions = random.choice(
            [-torque, random.uniform(-torque, torque), torque], (len(states), 1)
        )
        following = environment.step(states, actions).next_state
        walked.append((states, actions, following))
        states = following
    return walked


def test_without_torque_energy_never_grows(environment: RollingDie) -> None:
    for states, _, following in journeys(environment, 250, torque=0.0):
        assert (energy(following) <= energy(states) + 1e-12).all()


def test_torque_adds_no_more_energy_than_its_work(environment: RollingDie) -> None:
    for states, actions, following in journeys(environment, 250, torque=1.0):
        work = actions[:, 0] * (following[:, 2] - states[:, 2])
        lying = (following[:, 4:] == 0.0).all(axis=1)
        # Lying down may turn theta by 0.003 rad against the torque.
        assert (energy(following) <= energy(states) + work + 1e-12 + 1e-9 * lying).all()


def test_no_corner_sinks(environment: RollingDie) -> None:
    for torque in (0.0, 1.0):
        assert all(
            (lowest_gap(following) >= -1e-9).all()
            for _, _, following in journeys(environment, 250, torque)
        )


def test_every_impulse_lies_in_its_cone(environment: RollingDie) -> None:
    contacts = 0
    for states, actions, _ in journeys(environment, 100, torque=1.0):
        report = environment.contact_report(states, actions)
        tangential, normal = np.moveaxis(report.impulse, -1, 0)
        assert (normal >= 0.0).all()
        assert (np.abs(tangential) <= 0.5 * normal + 1e-13).all()
        contacts += int((normal > 0.0).sum())
    assert contacts > 50_000


def test_impulses_and_gravity_explain_the_velocity(environment: RollingDie) -> None:
    """Momentum: everything that changes it is in the contact report, but for lying down."""
    states, actions = environment.sample(generator(0, "momentum"), 5000)
    following = environment.step(states, actions).next_state
    report = environment.contact_report(states, actions)
    free = ~(report.kind == 3).any(axis=1)
    change = (following - states)[free, 3:5]
    # Settled contact that is cut short was pulled by gravity for its duration alone, as all else.
    explained = report.impulse.sum(axis=1)[free] - [0.0, GRAVITY * 0.02]
    np.testing.assert_allclose(change, explained, atol=1e-12)
    assert ((report.moment >= 0.0) & (report.moment <= 0.02)).all()
    assert (np.diff(np.where(report.kind > 0, report.moment, 1.0), axis=1) >= 0.0).all()
    touched = report.kind == 1
    assert np.abs(report.point[touched][:, 1]).max() < 1e-11


@pytest.mark.parametrize("torque", [1.0, 0.0])
def test_published_returns(environment: RollingDie, torque: float) -> None:
    """Uniform random torque returns -519 (sd 192), zero torque the same."""
    random = generator(0, "returns")
    count = 4000
    states, returns = environment.initial_states(range(count)), np.zeros(count)
    for _ in range(environment.horizon):
        transition = environment.step(states, random.uniform(-torque, torque, (count, 1)))
        returns, states = returns + transition.reward, transition.next_state
    assert not transition.terminated.any()
    # Three standard errors of 4,000 episodes.
    assert returns.mean() == pytest.approx(-519, abs=9)
    assert returns.std() == pytest.approx(192, abs=7)


def test_a_quarter_of_the_impacts_reverse_their_slip(environment: RollingDie) -> None:
    random = generator(0, "reversals")
    states = environment.initial_states(range(1000))
    reversals = impacts = 0
    for _ in range(environment.horizon):
        actions = random.uniform(-1, 1, (1000, 1))
        report = environment.contact_report(states, actions)
        impacts += int((report.kind == 1).sum())
        reversals += int(((report.kind == 1) & (report.path >= REVERSE)).sum())
        states = environment.step(states, actions).next_state
    assert reversals / impacts == pytest.approx(0.24, abs=0.015)


def test_jacobians_grow_large_near_glancing_touches(environment: RollingDie) -> None:
    random = generator(0, "entries")
    states, largest = environment.initial_states(range(4000)), 0.0
    for _ in range(environment.horizon):
        linearization = environment.differentiate(states, random.uniform(-1, 1, (4000, 1)))
        assert np.isfinite(linearization.state_jacobian).all()
        largest = max(largest, float(np.abs(linearization.state_jacobian).max()))
        states = linearization.transition.next_state
    assert 500 < largest < 5000


def test_a_bounce_straight_down_is_a_bouncing_balls(environment: RollingDie) -> None:
    """On a corner right below the centre, without slip: the closed form of the saltation matrix."""
    e, gap, vy = 0.6, 0.01, -1.5
    state = np.array([[0.0, np.sqrt(0.5) + gap, np.pi / 4, 0.0, vy, 0.0]])
    jacobian = environment.differentiate(state, np.zeros((1, 1))).state_jacobian[0]
    moment = (vy + np.sqrt(vy**2 + 2 * GRAVITY * gap)) / GRAVITY
    speed = vy - GRAVITY * moment
    saltation = np.array([[-e, 0.0], [-(1 + e) * GRAVITY / speed, -e]])
    before, then = (np.array([[1.0, t], [0.0, 1.0]]) for t in (moment, 0.02 - moment))
    np.testing.assert_allclose(
        jacobian[np.ix_([1, 4], [1, 4])], then @ saltation @ before, rtol=1e-11
    )


def test_a_lying_die_knows_its_x_and_vx_alone(environment: RollingDie) -> None:
    states = np.array([[4.0, 0.5, np.pi / 2, vx, 0.0, 0.0] for vx in (0.09, 1.0)])
    linearization = environment.differentiate(states, np.zeros((2, 1)))
    expected = np.zeros((2, 6, 6))
    expected[:, 0, 0] = 1.0
    expected[:, 0, 3] = [0.09 / (0.5 * GRAVITY), 0.02]
    expected[1, 3, 3] = 1.0
    np.testing.assert_allclose(linearization.state_jacobian, expected, atol=1e-15)
    assert not linearization.action_jacobian.any()


@pytest.mark.slow
def test_jacobians_over_2000_states_of_every_regime(environment: RollingDie) -> None:
    rows = audit(environment)
    assert [row.regime for row in rows] == list(environment.regimes)
    assert all(row.passed() for row in rows), as_table(rows)
    # An accidental jump within a piece would look like a kink: there are few.
    assert sum(row.kinks for row in rows) < 0.01 * sum(row.states for row in rows)


def test_impulses_to_draw_are_those_of_the_report(environment: RollingDie) -> None:
    """A die that lands flat, one in the air, one that lies."""
    states = np.array(
        [
            [0.0, 0.501, 0.0, 1.0, -1.0, 0.0],
            [0.0, 3.0, 0.0, 1.0, 0.0, 0.0],
            [0.0, 0.5, 0.0, 1.0, 0.0, 0.0],
        ]
    )
    actions = np.zeros((3, 1))
    landing, flying, lying = environment.contact_impulses(states, actions)
    report = environment.contact_report(states, actions)
    np.testing.assert_array_equal(landing[:, :2], report.point[0, :2])
    np.testing.assert_array_equal(landing[:, 2:], report.impulse[0, :2])
    assert (landing[:, 3] > 0.0).all()
    assert flying.shape == lying.shape == (0, 4)


def test_what_cannot_be_solved_is_refused(environment: RollingDie) -> None:
    states, actions = np.tile([0.0, 0.7072, 0.0, 0.0, 0.0, 0.0], (3, 1)), np.zeros((3, 1))
    states[1, 5] = 1e9
    for call in (environment.step, environment.differentiate):
        with pytest.raises(
            UnsolvedStepError, match=r"RollingDie: no solution for state \[0.0, 0.7072"
        ):
            call(states, actions)


@pytest.mark.parametrize(("theta", "side"), [(0.0, 1.0), (np.pi, 1.0), (-np.pi / 2, -1.0)])
def test_a_die_that_falls_flat_leaves_to_a_side(
    environment: RollingDie, theta: float, side: float
) -> None:
    """As its page says: one corner strikes after the other, the smallest index first."""
    idle, fall = np.zeros((1, 1)), np.sqrt(2.0**2 + 2 * GRAVITY * 0.01)
    states = np.array([[0.0, 0.51, theta, 0.0, -2.0, 0.0]])
    report, following = environment.contact_report(states, idle), environment.step(states, idle)
    assert np.count_nonzero(report.kind) == 2
    np.testing.assert_allclose(report.moment[0, 1], report.moment[0, 0], atol=1e-12)
    impulse = report.impulse[0].sum(axis=0)
    np.testing.assert_allclose(impulse / fall, [0.245 * side, 1.506], atol=5e-4)
    np.testing.assert_allclose(following.next_state[0, 5] / fall, -0.235 * side, atol=5e-4)
    states = np.array([[0.0, 1.0, theta, 0.0, 0.0, 0.0]])
    for _ in range(environment.horizon):
        states = environment.step(states, idle).next_state
    np.testing.assert_allclose(states[0, [0, 1, 3, 4, 5]], [0.112 * side, 0.5, 0, 0, 0], atol=5e-4)
