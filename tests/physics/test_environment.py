"""The contract that every task keeps, and every later one by standing in the catalogue."""

from typing import Any

import numpy as np
import pytest
import torch
from numpy.typing import NDArray

import physics
from physics.drawing import Polygon
from physics.environment import Environment, FloatArray
from physics.randomness import generator

BATCH = 64
STEP_SECONDS = {
    "MassPoint": 0.01,
    "CartPole": 0.02,
    "CartPoleSwingUp": 0.02,
    "Pendulum": 0.05,
    "MountainCar": 1 / 30,
    "Acrobot": 0.2,
    "RollingDie": 0.02,
    "HalfCheetah": 0.05,
    "Hopper": 0.008,
    "Walker2d": 0.008,
    "BallWall": 0.04,
    "mujoco/HalfCheetah": 0.05,
    "mujoco/Hopper": 0.008,
    "mujoco/Walker2d": 0.008,
    "mujoco/Swimmer": 0.04,
    "mujoco/InvertedDoublePendulum": 0.05,
    "mujoco/Reacher": 0.02,
}
WITH_CONTACTS = {"RollingDie", "HalfCheetah", "Hopper", "Walker2d"}

pytestmark = pytest.mark.parametrize("environment", physics.names(), indirect=True, scope="module")


@pytest.fixture(scope="module")
def environment(request: pytest.FixtureRequest) -> Environment:
    return physics.make(request.param)


@pytest.fixture(scope="module")
def sampled(environment: Environment) -> tuple[FloatArray, FloatArray]:
    return environment.sample(generator(1, "contract"), BATCH)


@pytest.fixture
def states(sampled: tuple[FloatArray, FloatArray]) -> FloatArray:
    return sampled[0].copy()


@pytest.fixture
def actions(sampled: tuple[FloatArray, FloatArray]) -> FloatArray:
    return sampled[1].copy()


def test_the_task_declares_itself(environment: Environment) -> None:
    assert environment.version >= 1
    assert environment.horizon >= 1
    assert np.isfinite(environment.max_reward)
    assert environment.step_seconds == STEP_SECONDS[environment.name]
    assert len(set(environment.regimes)) == len(environment.regimes) > 0
    assert all(0 <= i < environment.state_size for i in environment.angles)
    assert all(0 <= i < environment.state_size for i in environment.hidden)
    assert all(0 <= i < environment.state_size for i in environment.bounds)
    assert all(low < high for low, high in environment.bounds.values())


def test_shapes_and_types(
    environment: Environment, states: FloatArray, actions: FloatArray
) -> None:
    n, m = environment.state_size, environment.action_size
    linearization = environment.differentiate(states, actions)
    next_state, reward, terminated = linearization.transition
    assert next_state.shape == (BATCH, n)
    assert reward.shape == terminated.shape == (BATCH,)
    assert terminated.dtype == np.bool_
    derivatives = linearization[1:]
    assert [d.shape[1:] for d in derivatives] == [(n, n), (n, m), (n,), (m,), (n,)]
    for array in (next_state, reward, *derivatives):
        assert array.dtype == np.float64
        assert np.isfinite(array).all()


def test_a_derivative_changes_no_bit_of_the_step(
    environment: Environment, states: FloatArray, actions: FloatArray
) -> None:
    stepped = environment.step(states, actions)
    linearized = environment.differentiate(states, actions).transition
    for one, other in zip(stepped, linearized, strict=True):
        np.testing.assert_array_equal(one, other)


def test_impulses_of_contacts_are_arrows(
    environment: Environment, states: FloatArray, actions: FloatArray
) -> None:
    arrows = environment.contact_impulses(states, actions)
    assert len(arrows) == BATCH
    assert all(row.ndim == 2 and row.shape[1] == 4 and np.isfinite(row).all() for row in arrows)
    assert all((row[:, 3] > 0.0).all() for row in arrows)
    has_contacts = environment.name.removeprefix("mujoco/") in WITH_CONTACTS
    assert any(len(row) for row in arrows) == has_contacts


def test_the_input_is_left_alone(
    environment: Environment, states: FloatArray, actions: FloatArray
) -> None:
    before = states.copy(), actions.copy()
    environment.differentiate(states, actions)
    np.testing.assert_array_equal(states, before[0])
    np.testing.assert_array_equal(actions, before[1])


def test_a_row_does_not_feel_the_others(
    environment: Environment, states: FloatArray, actions: FloatArray
) -> None:
    def everything(rows: slice) -> list[NDArray[Any]]:
        linearization = environment.differentiate(states[rows], actions[rows])
        features = environment.features(linearization.transition.next_state)
        return [*linearization.transition, *linearization[1:], features]

    whole = everything(slice(None))
    for rows in (slice(0, 1), slice(7, 8), slice(3, 20), slice(None, None, -1), slice(1, None, 3)):
        for part, array in zip(everything(rows), whole, strict=True):
            np.testing.assert_array_equal(part, array[rows])


def test_an_empty_batch_is_a_batch(environment: Environment) -> None:
    states, actions = np.empty((0, environment.state_size)), np.empty((0, environment.action_size))
    assert environment.differentiate(states, actions).state_jacobian.shape[0] == 0
    assert environment.features(states).shape == (0, environment.feature_size)


def test_actions_beyond_the_box_are_clipped(
    environment: Environment, states: FloatArray, actions: FloatArray
) -> None:
    beyond = np.where(actions >= 0.0, 1.7, -2.3)
    clipped = environment.step(states, np.sign(beyond))
    for one, other in zip(environment.step(states, beyond), clipped, strict=True):
        np.testing.assert_array_equal(one, other)
    linearization = environment.differentiate(states, beyond)
    assert not linearization.action_jacobian.any()
    assert not linearization.reward_action_gradient.any()


def test_at_the_edge_of_the_box_the_derivative_is_the_interior_one(
    environment: Environment, states: FloatArray, actions: FloatArray
) -> None:
    edge = np.sign(actions)
    at = environment.differentiate(states, edge)
    inside = environment.differentiate(states, edge * (1 - 1e-13))
    pieces = environment.pieces(states, edge).piece, environment.pieces(states, edge * 0.999).piece
    same = (pieces[0] == pieces[1]).all(axis=1)
    assert same.any()
    rtol = environment.tolerance  # of exact derivatives 1e-6
    np.testing.assert_allclose(
        at.action_jacobian[same], inside.action_jacobian[same], rtol=rtol, atol=1e3 * rtol**2
    )
    assert at.action_jacobian[same].any()


def test_start_states_depend_on_their_own_seed_alone(environment: Environment) -> None:
    starts = environment.initial_states([5, 3, 5, 2**40])
    np.testing.assert_array_equal(starts[0], starts[2])
    np.testing.assert_array_equal(starts[1:2], environment.initial_states([3]))
    np.testing.assert_array_equal(starts, environment.initial_states(np.array([5, 3, 5, 2**40])))
    assert starts.shape == (4, environment.state_size)
    assert starts.dtype == np.float64
    assert environment.initial_states([]).shape == (0, environment.state_size)


@pytest.mark.parametrize("seed", [-1, 0.5, "0", None])
def test_a_bad_seed_is_refused(environment: Environment, seed: int) -> None:
    with pytest.raises(ValueError, match="seed must be an integer from 0 on"):
        environment.initial_states([seed])


def test_bad_input_is_refused(
    environment: Environment, states: FloatArray, actions: FloatArray
) -> None:
    n = environment.state_size
    not_a_number, infinite = states.copy(), actions.copy()
    not_a_number[3, n - 1] = np.nan
    infinite[9, 0] = np.inf
    cases: list[tuple[Any, Any, str]] = [
        (states.tolist(), actions, rf"states must be a numpy array, float64 \[batch, {n}\]"),
        (states.astype(np.float32), actions, rf"states must be float64 .* not float32 \[64, {n}\]"),
        (states.astype(np.int64), actions, rf"not int64 \[64, {n}\]"),
        (states.astype(complex), actions, rf"not complex128 \[64, {n}\]"),
        (states.astype(">f8"), actions, rf"not >f8 \[64, {n}\]"),
        (torch.from_numpy(states), actions, r"states must be a numpy array, .* not Tensor"),
        (states, torch.from_numpy(actions), r"actions must be a numpy array, .* not Tensor"),
        (None, actions, r"states must be a numpy array, .* not NoneType"),
        (states[0], actions, rf"states must be float64 .*, not float64 \[{n}\]"),
        (np.zeros((BATCH, n + 1)), actions, rf"not float64 \[64, {n + 1}\]"),
        (states, np.zeros((BATCH, environment.action_size + 1)), "actions must be float64"),
        (states, actions.astype(np.int64), "actions must be float64 .* not int64"),
        (states, actions[:5], "the same number of rows, not 64 and 5"),
        (not_a_number, actions, "must be finite, but row 3 has"),
        (states, infinite, "must be finite, but row 9 has"),
        (states, -infinite, "must be finite, but row 9 has"),
    ]
    for call in (environment.step, environment.differentiate, environment.contact_impulses):
        for bad_states, bad_actions, complaint in cases:
            with pytest.raises(ValueError, match=complaint):
                call(bad_states, bad_actions)


def test_read_only_and_strided_input_are_welcome(
    environment: Environment, states: FloatArray, actions: FloatArray
) -> None:
    expected = environment.step(states, actions).next_state
    frozen = states.copy()
    frozen.flags.writeable = False
    np.testing.assert_array_equal(environment.step(frozen, actions).next_state, expected)
    columns = np.asfortranarray(states)
    np.testing.assert_array_equal(environment.step(columns, actions).next_state, expected)


def test_features_agree_with_torch(environment: Environment, states: FloatArray) -> None:
    features = environment.features(states)
    assert features.shape == (BATCH, environment.feature_size)
    tensor = environment.features(torch.from_numpy(states))
    np.testing.assert_allclose(features, tensor.numpy(), rtol=1e-14, atol=1e-14)


def test_feature_slopes_are_the_derivative(environment: Environment, states: FloatArray) -> None:
    tensor = torch.from_numpy(states).requires_grad_()
    features = environment.features(tensor)
    sources, slopes = environment.feature_sources, environment.feature_slopes(features)
    np.testing.assert_allclose(
        environment.feature_slopes(environment.features(states)),
        slopes.detach().numpy(),
        rtol=1e-13,
        atol=1e-13,
    )
    for i, source in enumerate(sources):
        (gradient,) = torch.autograd.grad(features[:, i].sum(), tensor, retain_graph=True)
        expected = torch.zeros_like(gradient)
        expected[:, source] = slopes[:, i]
        torch.testing.assert_close(gradient, expected, rtol=1e-13, atol=1e-13)


def test_a_random_policy_stays_finite(environment: Environment) -> None:
    random = generator(0, "random policy")
    states = environment.initial_states(range(16))
    for _ in range(environment.horizon):
        actions = random.uniform(-1, 1, (16, environment.action_size))
        following, reward, terminated = environment.step(states, actions)
        assert np.isfinite(following).all()
        if environment.name != "mujoco/Swimmer":  # its mark is of whole episodes, not of a step
            assert (reward <= environment.max_reward).all()
        restarts = environment.initial_states(random.integers(2**60, size=16))
        states = np.where(terminated[:, None], restarts, following)


def test_no_state_is_beyond_the_declared_bounds(environment: Environment) -> None:
    coordinates = list(environment.bounds)
    low, high = np.array([environment.bounds[i] for i in coordinates]).reshape(-1, 2).T
    states, actions = environment.sample(generator(3, "bounds"), 4000)
    for visited in (
        environment.initial_states(range(200)),
        environment.step(states, actions).next_state,
        environment.step(states, np.sign(actions)).next_state,
    ):
        assert (visited[:, coordinates] >= low).all()
        assert (visited[:, coordinates] <= high).all()


def test_the_sample_reaches_every_regime(environment: Environment) -> None:
    states, actions = environment.sample(generator(2, "contract"), 4000)
    pieces = environment.pieces(states, actions)
    assert pieces.piece.shape[0] == pieces.regime.shape[0] == len(states)
    assert set(pieces.regime.tolist()) == set(range(len(environment.regimes)))


def test_drawing(environment: Environment) -> None:
    drawing = environment.draw(environment.initial_states([0])[0])
    left, bottom, right, top = drawing.view
    assert left < right
    assert bottom < top
    image = drawing.rgb_array(width=120)
    assert image.dtype == np.uint8
    height = image.shape[0]
    assert image.shape == (height, 120, 3)
    assert height % 2 == 0
    assert abs(height - 120 * (top - bottom) / (right - left)) <= 1.0 + 1e-9
    assert len(np.unique(image.reshape(-1, 3), axis=0)) > 2
    assert drawing.as_data()["shapes"][0]["shape"] in {"capsule", "polygon"}


def test_the_view_holds_the_moving_body_all_episode_long(environment: Environment) -> None:
    """The middle of everything that moves is in view, wherever random and extreme actions lead."""
    random = generator(0, "in view")
    states = environment.initial_states(range(8))
    for step in range(environment.horizon):
        if step % 20 == 0:
            actions = random.choice([-1.0, 1.0], (8, environment.action_size))
        transition = environment.step(states, actions)
        states = np.where(transition.terminated[:, None], states, transition.next_state)
        drawing = environment.draw(states[step % 8])
        left, bottom, right, top = drawing.view
        for shape in drawing.shapes:
            if shape.role == "body":
                points = shape.points if isinstance(shape, Polygon) else (shape.start, shape.end)
                x, y = np.mean(points, axis=0)
                assert left < x < right
                assert bottom < y < top
