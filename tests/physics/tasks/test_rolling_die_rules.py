"""RollingDie against its rules, written again from the text (rolling_die_by_rule)."""

import math

import numpy as np
import pytest

import physics
from physics.environment import FloatArray
from physics.impacts import die_motion
from physics.impacts.flying_body import FlyingBody
from physics.impacts.impulse import PATHS
from physics.impacts.trace import FIELDS, KIND
from physics.randomness import generator
from physics.tasks.rolling_die import RollingDie
from tests.physics import rolling_die_by_rule

HALF = 0.5 * math.pi


@pytest.fixture(scope="module")
def environment() -> RollingDie:
    made = physics.make("RollingDie")
    assert isinstance(made, RollingDie)
    return made


def by_rule(states: FloatArray, actions: FloatArray) -> FloatArray:
    rows = zip(states, actions[:, 0].tolist(), strict=True)
    return np.array([rolling_die_by_rule.step(state, action) for state, action in rows])


def check(environment: RollingDie, states: FloatArray, actions: FloatArray) -> FloatArray:
    """Compare a batch; the next states."""
    following = environment.step(states, actions).next_state
    np.testing.assert_allclose(following, by_rule(states, actions), rtol=0, atol=2e-12)
    return following


def test_steps_of_every_regime(environment: RollingDie) -> None:
    states, actions = environment.sample(generator(0, "by rule"), 4000)
    regime = environment.pieces(states, actions).regime
    assert np.bincount(regime, minlength=len(environment.regimes)).min() > 20
    check(environment, states, actions)


def test_episodes_until_every_die_lies_still(environment: RollingDie) -> None:
    random = generator(0, "episodes by rule")
    states = environment.initial_states(range(16))
    for _ in range(600):
        states = check(environment, states, random.uniform(-1.1, 1.1, (len(states), 1)))
        states = states[np.any(states[:, 3:] != 0.0, axis=1)]
        if not len(states):
            return
    pytest.fail(f"{len(states)} dice still move after 12 s: {states.tolist()}")


def test_flat_landings_where_two_corners_touch_at_once(environment: RollingDie) -> None:
    random = generator(0, "flat landings")
    count = 600
    quarter = random.integers(-4, 5, count)
    tilt = random.choice([-1, 0, 1], count) * 10.0 ** random.uniform(-16, -9, count)
    theta = quarter * HALF + tilt
    low = 0.5 * (np.abs(np.sin(theta)) + np.abs(np.cos(theta)))
    y = low + random.choice([0, 1], count) * random.uniform(0, 0.01, count)
    vx, vy = random.uniform(-3, 3, count), random.uniform(-4, -0.2, count)
    omega = random.choice([0, 1], count) * random.uniform(-0.1, 0.1, count)
    states = np.stack([0 * y, y, theta, vx, vy, omega], axis=1)
    actions = random.choice([0, 1], (count, 1)) * random.uniform(-1, 1, (count, 1))
    check(environment, states, actions)
    assert ((environment.contact_report(states, actions).kind > 0).sum(axis=1) >= 2).mean() > 0.8


def test_a_vertical_drop_on_a_corner_and_on_a_side(environment: RollingDie) -> None:
    """No slip at all: u = 0 exactly, the slip phase is over at once."""
    states = np.array(
        [[0.0, math.sqrt(0.5) + 0.001, HALF / 2, 0.0, -1.0, 0.0], [0.0, 0.501, 0.0, 0.0, -1.0, 0.0]]
    )
    actions = np.zeros((2, 1))
    check(environment, states, actions)
    report = environment.contact_report(states, actions)
    assert PATHS[report.path[0, 0]] == "stick"
    assert report.impulse[0, 0].tolist() == pytest.approx([0.0, 1.6 * math.sqrt(1 + 2 * 9.81e-3)])
    assert PATHS[report.path[1, 0]] == "reverse"
    assert report.corner[1, 0] == 2


LYING = [
    ((4.0, 0.5, 0.0, 0.0, 0.0, 0.0), (4.0, 0.5, 0.0, 0.0)),
    ((4.0, 0.5, 7 * HALF, 0.09, 0.0, 0.0), (4.0 + 0.09**2 / 9.81, 0.5, 7 * HALF, 0.0)),
    ((4.0, 0.5, -HALF, -0.09, 0.0, 0.0), (4.0 - 0.09**2 / 9.81, 0.5, -HALF, 0.0)),
    ((4.0, 0.5, 0.0, 1.0, 0.0, 0.0), (4.0 + 0.02 - 9.81e-4, 0.5, 0.0, 1.0 - 0.0981)),
    ((4.0, 0.5, 0.0, -1.0, 0.0, 0.0), (4.0 - 0.02 + 9.81e-4, 0.5, 0.0, -1.0 + 0.0981)),
    ((4.0, 0.5005, 4e-4, 0.0, 0.02, 0.1), (4.0, 0.5, 0.0, 0.0)),
    # E is 0.0099 J here: still lying, although a free die would rise.
    ((4.0, 0.5, 0.0, 0.0, math.sqrt(0.0198), 0.0), (4.0, 0.5, 0.0, 0.0)),
]


@pytest.mark.parametrize(("state", "expected"), LYING)
def test_lying(
    environment: RollingDie, state: tuple[float, ...], expected: tuple[float, ...]
) -> None:
    for action in (0.0, 1.0, -1.0):
        actions = np.array([[action]])
        following = environment.step(np.array([state]), actions).next_state[0]
        assert following[:4].tolist() == pytest.approx(expected, abs=1e-15)
        assert following[4:].tolist() == [0.0, 0.0]
        assert following[1] == 0.5
        assert environment.contact_report(np.array([state]), actions).kind[0, 0] == 3


def test_just_above_the_rest_energy_it_is_free(environment: RollingDie) -> None:
    state = np.array([[4.0, 0.5, 0.0, 0.0, math.sqrt(0.0202), 0.0]])
    assert environment.step(state, np.zeros((1, 1))).next_state[0, 1] > 0.5


def test_settled_from_the_start_needs_v2_plus_2g_gap_below_vs2(environment: RollingDie) -> None:
    """The edge of rule 2 for a die that stands on a corner, from above in v and in gap."""
    stand = math.sqrt(0.5)
    for v, drop, settled in (
        (0.0499, 0.0, True),
        (0.0501, 0.0, False),
        (0.0, 0.0499, True),
        (0.0, 0.0501, False),
        (0.03, 0.0399, True),
        (0.03, 0.0401, False),
    ):
        state = np.array([[0.0, stand + drop**2 / (2 * 9.81), HALF / 2, 0.0, v, 0.0]])
        report = environment.contact_report(state, np.zeros((1, 1)))
        from_start = report.kind.size > 0 and report.kind[0, 0] == 2 and report.moment[0, 0] == 0.0
        assert from_start == settled


def test_a_slow_touch_settles_and_a_faster_one_bounces(environment: RollingDie) -> None:
    stand = math.sqrt(0.5)
    for v, kind in ((-0.0499, 2), (-0.0501, 1)):
        # Straight above a corner, so that it arrives after 0.3 ms with just that rate.
        gap = -v * 3e-4 - 9.81 * 3e-4**2 / 2
        state = np.array([[0.0, stand + gap, HALF / 2, 0.0, v + 9.81 * 3e-4, 0.0]])
        report = environment.contact_report(state, np.zeros((1, 1)))
        assert report.kind[0, 0] == kind


def test_after_its_last_touch_it_keeps_its_state(monkeypatch: pytest.MonkeyPatch) -> None:
    """Rule 6, in the kernel's own Python code: 64 touches happen nowhere, so it is given one."""
    kernel = die_motion.move.py_func  # type: ignore[attr-defined]
    die = FlyingBody(0.0, 0.501, 0.0, 1.0, -1.0, 0.0, 0.02)
    trace = np.zeros((die_motion.MAX_CONTACTS, FIELDS))
    whole = kernel(die, None, trace, 0.0)
    assert whole == die_motion.move(die, None, None, 0.0)
    assert (trace[:, KIND] > 0.0).sum() == 2

    monkeypatch.setattr(die_motion, "MAX_TOUCHES", 1)
    trace[:] = 0.0
    stopped = kernel(die, None, trace, 0.0)
    (event,) = trace[trace[:, KIND] > 0.0]
    moment = (math.sqrt(1.0 + 2.0 * 9.81 * 0.001) - 1.0) / 9.81
    assert stopped.time == pytest.approx(0.02 - moment)
    # Where it touched, with the velocity that the one impact gave it.
    pt, pn = event[-2:]
    expected = [moment, 0.5, 0.0, 1.0 + pt, pn - math.sqrt(1.0 + 2.0 * 9.81 * 0.001)]
    assert list(stopped[:5]) == pytest.approx(expected)
    assert stopped != whole


def test_no_step_comes_near_64_touches(environment: RollingDie) -> None:
    """Nearly flat dice at any speed, where touches are quickest to follow each other."""
    random = generator(0, "many touches")
    count = 20_000
    tilt = random.choice([-1, 1], count) * 10.0 ** random.uniform(-12, -1, count)
    low = 0.5 * (np.abs(np.sin(tilt)) + np.abs(np.cos(tilt)))
    vx, vy, omega = random.choice([-1, 1], (3, count)) * 10.0 ** random.uniform(-3, 1.5, (3, count))
    states = np.stack([0 * tilt, low, tilt, vx, -np.abs(vy), omega], axis=1)
    kinds = environment.contact_report(states, random.uniform(-1, 1, (count, 1))).kind
    assert 5 <= kinds.shape[1] <= 20
