"""HalfCheetah as a task: start, reward, features, errors; and that only its own row decides."""

import numpy as np
import pytest

from physics.environment import FloatArray, UnsolvedStepError
from physics.randomness import generator
from physics.robots.report import empty_report, report_rows
from physics.tasks.half_cheetah import HalfCheetah

ENVIRONMENT = HalfCheetah()


def under_way(count: int) -> tuple[FloatArray, FloatArray]:
    return ENVIRONMENT.sample(generator(3, "half cheetah"), count)


def test_it_declares_what_the_paper_needs() -> None:
    assert (ENVIRONMENT.state_size, ENVIRONMENT.action_size) == (14, 4)
    assert (ENVIRONMENT.horizon, ENVIRONMENT.max_reward) == (200, 10.0)
    assert ENVIRONMENT.reward_is_differentiable


def test_no_start_is_below_the_ground_and_a_fifth_was_raised() -> None:
    starts = ENVIRONMENT.initial_states(range(2000))
    lowest = ENVIRONMENT.sphere_centres(starts)[..., 1].min(axis=1) - 0.046
    assert lowest.min() > -1e-15
    raised = np.abs(lowest) < 1e-15
    assert 0.17 < raised.mean() < 0.21
    others = np.delete(starts, 1, axis=1)
    assert np.abs(others[:, :6]).max() <= 0.1
    assert np.abs(starts[~raised, 1]).max() <= 0.1
    assert others[:, 6:].std() == pytest.approx(0.1, rel=0.05)


def test_reward_and_its_gradients() -> None:
    states, actions = under_way(100)
    linearization = ENVIRONMENT.differentiate(states, actions)
    clipped = np.clip(actions, -1.0, 1.0)
    speed = (linearization.transition.next_state[:, 0] - states[:, 0]) / 0.05
    np.testing.assert_allclose(
        linearization.transition.reward, speed - 0.1 * (clipped**2).sum(axis=1), rtol=1e-12
    )
    along_x = np.eye(14)[0]
    np.testing.assert_allclose(
        linearization.reward_state_gradient, np.tile(-20 * along_x, (100, 1))
    )
    np.testing.assert_allclose(
        linearization.reward_next_state_gradient, np.tile(20 * along_x, (100, 1))
    )
    np.testing.assert_allclose(
        linearization.reward_action_gradient, np.where(np.abs(actions) <= 1, -0.2 * actions, 0.0)
    )
    assert not linearization.transition.terminated.any()


def test_the_network_sees_all_but_x_and_the_pitch_as_an_angle() -> None:
    state = generator(0, "features").standard_normal((1, 14))
    z, pitch, rest = state[0, 1], state[0, 2], state[0, 3:]
    np.testing.assert_allclose(
        ENVIRONMENT.features(state)[0], [z, np.cos(pitch), np.sin(pitch), *rest]
    )


def test_nothing_depends_on_x() -> None:
    states, actions = under_way(50)
    moved = states + 3.0 * np.eye(14)[0]
    here, there = (ENVIRONMENT.differentiate(s, actions) for s in (states, moved))
    np.testing.assert_allclose(there.state_jacobian, here.state_jacobian, rtol=1e-9, atol=1e-9)
    np.testing.assert_allclose(here.state_jacobian[:, :, 0], np.tile(np.eye(14)[0], (50, 1)))


def test_a_state_nobody_can_solve_is_an_error_that_holds_it() -> None:
    states, actions = ENVIRONMENT.initial_states(range(3)), np.zeros((3, 4))
    states[1, 9] = 1e200
    for call in (
        ENVIRONMENT.step,
        ENVIRONMENT.differentiate,
        ENVIRONMENT.contact_report,
        ENVIRONMENT.pieces,
    ):
        with pytest.raises(UnsolvedStepError, match=r"HalfCheetah: no solution .* 1e\+200"):
            call(states, actions)


def test_bad_coordinates_are_refused() -> None:
    q, a = np.zeros((2, 7)), np.zeros((2, 4))
    with pytest.raises(ValueError, match=r"q must be float64 \[batch, 7\]"):
        ENVIRONMENT.mass_matrix(np.zeros((2, 14)))
    with pytest.raises(ValueError, match=r"v must be float64 \[batch, 7\]"):
        ENVIRONMENT.smooth_forces(q, np.zeros((2, 6)), a)
    with pytest.raises(ValueError, match="equal numbers of rows, not 2 and 1"):
        ENVIRONMENT.smooth_forces(q, np.zeros((1, 7)), a)
    with pytest.raises(ValueError, match="must be finite"):
        ENVIRONMENT.smooth_forces(q, np.full((2, 7), np.nan), a)


def test_the_report_is_of_the_step() -> None:
    states, actions = under_way(200)
    report = ENVIRONMENT.contact_report(states, actions)
    shapes = [array.shape[1:] for array in report]
    assert shapes == [(5, 16), (5, 16), (5, 16), (5, 16), (5, 8), (5,), (5, 24)]
    after = ENVIRONMENT.step(states, actions).next_state
    heights = ENVIRONMENT.sphere_centres(after)[..., 1] - 0.046
    np.testing.assert_allclose(report.gap[:, -1], heights, rtol=0, atol=1e-12)
    closed = report.mode[:, :, :16] != 0
    assert (report.normal_impulse[~closed] == 0.0).all()
    assert (report.normal_impulse[closed] != 0.0).mean() > 0.99
    piece = ENVIRONMENT.pieces(states, actions).piece
    modes = np.ascontiguousarray(piece[:, :15]).view(np.int8).reshape(200, 5, 24)
    np.testing.assert_array_equal(modes, report.mode)


def test_impulses_to_draw_carry_the_weight_and_stand_on_the_ground() -> None:
    states = ENVIRONMENT.initial_states(range(20))
    actions = np.zeros((20, 4))
    for _ in range(400):
        states = ENVIRONMENT.step(states, actions).next_state
    for arrows in ENVIRONMENT.contact_impulses(states, actions):
        assert len(arrows) >= 2
        np.testing.assert_allclose(arrows[:, 1], 0.0, atol=1e-9)
        np.testing.assert_allclose(arrows[:, 2:].sum(axis=0), [0.0, 14.0 * 9.81 * 0.05], atol=1e-9)
    states[:, 1] += 1.0
    assert all(len(arrows) == 0 for arrows in ENVIRONMENT.contact_impulses(states, actions))


@pytest.mark.parametrize("filling", [np.nan, 1e300])
def test_no_bit_comes_from_memory_that_was_there_before(filling: float) -> None:
    """The kernels' records are not cleared: what they read, they have written."""
    states, actions = under_way(64)
    dirty = np.zeros(1, ENVIRONMENT.body_type)
    dirty.view(np.float64)[:] = filling
    mechanism, h = ENVIRONMENT.mechanism, ENVIRONMENT.substep_seconds
    report = empty_report(mechanism, 64, ENVIRONMENT.substeps)
    assert report_rows(mechanism, dirty, h, states, actions, report) == -1
    for one, other in zip(report, ENVIRONMENT.contact_report(states, actions), strict=True):
        np.testing.assert_array_equal(one, other)


def test_two_sticking_contacts_of_one_link_have_a_derivative() -> None:
    """On its back, on the end of the torso and the head: impulses can be split in many ways.

    Next to such a state it is now the one, now the other that holds still, so it lies on no smooth
    piece; but the pieces meet there with equal slopes.
    """
    states, actions = np.zeros((1, 14)), np.array([[0.02, -0.03, 0.01, 0.04]])
    states[0, 1:3] = 0.1, np.pi + 0.2
    for _ in range(300):
        states = ENVIRONMENT.step(states, np.zeros((1, 4))).next_state
    mode = ENVIRONMENT.contact_report(states, actions).mode[0, -1]
    assert np.flatnonzero(mode).tolist() == [1, 2]
    linearization = ENVIRONMENT.differentiate(states, actions)
    exact = np.concatenate([linearization.state_jacobian, linearization.action_jacobian], axis=2)
    x, width = np.concatenate([states, actions], axis=1), 1e-6
    for i in range(18):
        ends = [x + side * width * np.eye(18)[i] for side in (1.0, -1.0)]
        above, below = (
            ENVIRONMENT.step(end[:, :14].copy(), end[:, 14:].copy()).next_state for end in ends
        )
        np.testing.assert_allclose(
            (above - below)[0] / (2 * width), exact[0, :, i], rtol=1e-7, atol=1e-7
        )
