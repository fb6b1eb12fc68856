"""The native vector environment is Gymnasium's SyncVectorEnv over the single one, bit for bit."""

import copy
import pickle
from typing import Any

import gymnasium
import numpy as np
import pytest
from gymnasium.error import ResetNeeded
from gymnasium.utils.env_checker import (
    check_reset_options,
    check_reset_return_type,
    check_returned_data_not_reused,
    data_equivalence,
)
from gymnasium.utils.passive_env_checker import check_action_space, check_observation_space
from gymnasium.vector import AutoresetMode, VectorEnv
from gymnasium.wrappers.vector import NormalizeObservation, RecordEpisodeStatistics
from numpy.typing import NDArray

import physics
from physics.environment import Environment
from physics.gym.registration import identifier
from physics.gym.vector_env import GymnasiumVectorEnvironment
from physics.randomness import generator

ROWS = 5
Vector = VectorEnv[Any, Any, Any]

every_mode = pytest.mark.parametrize("mode", list(AutoresetMode))


def native(name: str, rows: int = ROWS, **settings: Any) -> GymnasiumVectorEnvironment:
    made = gymnasium.make_vec(identifier(name), num_envs=rows, **settings)
    assert isinstance(made, GymnasiumVectorEnvironment)
    return made


def synchronous(name: str, mode: AutoresetMode, rows: int = ROWS, **settings: Any) -> Vector:
    return gymnasium.make_vec(
        identifier(name),
        num_envs=rows,
        vectorization_mode="sync",
        vector_kwargs={"autoreset_mode": mode},
        **settings,
    )


def actions(vector: Vector, steps: int) -> list[NDArray[np.float32]]:
    """Bold actions, which end episodes: each holds for some steps."""
    random = generator(0, "vector")
    held = [random.choice([-1.0, 0.4, 1.0], vector.action_space.shape) for _ in range(steps // 6)]
    return [held[step // 6].astype(np.float32) for step in range(6 * len(held))]


@every_mode
@pytest.mark.parametrize(
    ("name", "limit", "terminates"),
    [("CartPole", 30, True), ("Acrobot", 11, False), ("HalfCheetah", 7, False)],
)
def test_it_equals_gymnasiums_loop_over_single_ones(
    name: str, limit: int, terminates: bool, mode: AutoresetMode
) -> None:
    ours = native(name, max_episode_steps=limit, autoreset_mode=mode)
    theirs = synchronous(name, mode, max_episode_steps=limit)
    both: tuple[Any, Any] = (ours, theirs)
    assert ours.single_observation_space == theirs.single_observation_space
    assert ours.observation_space == theirs.observation_space
    assert ours.single_action_space == theirs.single_action_space
    assert ours.action_space == theirs.action_space
    assert ours.metadata == theirs.metadata
    seeds: Any = [3, 1, 4, 1, 5]
    assert data_equivalence(ours.reset(seed=seeds), theirs.reset(seed=seeds), exact=True)
    ends = np.zeros(2, np.int64)
    for action in actions(ours, 240):
        one, other = ours.step(action), theirs.step(action)
        assert data_equivalence(one, other, exact=True)
        assert one[0] in ours.observation_space
        ends += [one[2].sum(), one[3].sum()]
        ended = one[2] | one[3]
        if mode is AutoresetMode.DISABLED and ended.any():
            again = [each.reset(options={"reset_mask": ended.copy()}) for each in both]
            assert data_equivalence(again[0], again[1], exact=True)
    assert ends[1] > 0
    assert (ends[0] > 0) == terminates
    assert data_equivalence(ours.np_random_seed, theirs.np_random_seed)
    drawn = [[random.integers(2**62) for random in vector.np_random] for vector in both]
    assert drawn[0] == drawn[1]


@every_mode
def test_rows_restarted_under_way_equal_gymnasiums_loop(mode: AutoresetMode) -> None:
    both = (
        native("CartPole", max_episode_steps=9, autoreset_mode=mode),
        synchronous("CartPole", mode, max_episode_steps=9),
    )
    for each in both:
        each.reset(seed=3)
    for turn, action in enumerate(actions(both[0], 60)):
        one, other = (each.step(action) for each in both)
        assert data_equivalence(one, other, exact=True)
        mask = one[2] | one[3] | (np.arange(ROWS) == turn % ROWS)
        again = [each.reset(options={"reset_mask": mask.copy()}) for each in both]
        assert data_equivalence(again[0], again[1], exact=True)


@pytest.mark.parametrize("name", physics.names())
def test_each_row_walks_the_single_ones_episode(name: str) -> None:
    vector = native(name, rows=3)
    observations, infos = vector.reset(seed=7)
    singles = [gymnasium.make(identifier(name)) for _ in range(3)]
    for row, single in enumerate(singles):
        observation, _ = single.reset(seed=7 + row)
        np.testing.assert_array_equal(observations[row], observation)
    for action in actions(vector, 24):
        observations, rewards, terminated, truncated, infos = vector.step(action)
        for row, single in enumerate(singles):
            observation, reward, ends, cut, info = single.step(action[row])
            np.testing.assert_array_equal(observations[row], observation)
            assert (rewards[row], terminated[row], truncated[row]) == (reward, ends, cut)
            for key, value in info.items():
                np.testing.assert_array_equal(infos[key][row], value)
        if terminated.any():
            break


def test_a_batch_is_one_call(monkeypatch: pytest.MonkeyPatch) -> None:
    calls: list[int] = []
    differentiate = Environment.differentiate

    def counted(task: Environment, states: Any, actions: Any) -> Any:
        calls.append(len(states))
        return differentiate(task, states, actions)

    monkeypatch.setattr(Environment, "differentiate", counted)
    vector = native("Pendulum", rows=16)
    vector.reset(seed=0)
    for action in actions(vector, 6):
        vector.step(action)
    assert calls == [16] * 6


def test_without_jacobians_the_step_is_the_same() -> None:
    plain, full = native("Pendulum", jacobians=False), native("Pendulum")
    plain.reset(seed=0)
    full.reset(seed=0)
    action = actions(plain, 6)[0]
    one, other = plain.step(action), full.step(action)
    np.testing.assert_array_equal(one[0], other[0])
    assert set(one[4]) == {"state", "_state"}


@pytest.mark.parametrize(
    ("asked", "limit"),
    [({}, 200), ({"max_episode_steps": None}, 200), ({"max_episode_steps": 9}, 9)],
)
def test_the_time_limit_follows_the_spec(asked: dict[str, Any], limit: int) -> None:
    vector = native("Pendulum", rows=1, **asked)
    vector.reset(seed=0)
    cut = [bool(vector.step(np.zeros((1, 1)))[3][0]) for _ in range(limit)]
    assert cut == [False] * (limit - 1) + [True]


def test_the_time_limit_can_be_left_out() -> None:
    vector = native("Pendulum", rows=2, max_episode_steps=-1)
    vector.reset(seed=0)
    assert not any(vector.step(np.zeros((2, 1)))[3].any() for _ in range(500))


@every_mode
def test_gymnasiums_checks(mode: AutoresetMode) -> None:
    vector: Any = native("Pendulum", rows=1, autoreset_mode=mode)
    check_action_space(vector.action_space)
    check_observation_space(vector.observation_space)
    check_reset_return_type(vector)
    check_reset_options(vector)
    check_returned_data_not_reused(vector)


@every_mode
def test_gymnasiums_vector_wrappers(mode: AutoresetMode) -> None:
    def recorded(vector: Vector) -> RecordEpisodeStatistics[Any, Any]:
        wrapped = RecordEpisodeStatistics(vector)
        wrapped.reset(seed=0)
        for action in actions(vector, 120):
            _, _, terminated, truncated, _ = wrapped.step(action)
            ended = terminated | truncated
            if mode is AutoresetMode.DISABLED and ended.any():
                wrapped.reset(options={"reset_mask": ended})
        return wrapped

    ours = recorded(native("CartPole", max_episode_steps=20, autoreset_mode=mode))
    assert ours.episode_count > 5
    assert max(ours.length_queue) == 20
    if (
        mode is not AutoresetMode.DISABLED
    ):  # there, Gymnasium's loop takes the mask from the wrapper
        theirs = recorded(synchronous("CartPole", mode, max_episode_steps=20))
        assert list(ours.length_queue) == list(theirs.length_queue)
        assert list(ours.return_queue) == list(theirs.return_queue)


def test_observations_can_be_normalised() -> None:
    wrapped = NormalizeObservation(native("Pendulum"))
    wrapped.reset(seed=0)
    for action in actions(wrapped, 60):
        observations = wrapped.step(action)[0]
    assert np.abs(observations).max() < 10.0


def test_rows_may_start_in_given_states() -> None:
    vector = native("Pendulum", rows=3)
    _, infos = vector.reset(seed=0, options={"state": [0.5, -1.0]})
    np.testing.assert_array_equal(infos["state"], [[0.5, -1.0]] * 3)
    states = np.array([[0.1, 0.2], [0.3, 0.4], [np.nan, 0.0]])
    mask = np.array([True, False, False])
    observations, infos = vector.reset(options={"state": states, "reset_mask": mask})
    np.testing.assert_array_equal(infos["state"], [[0.1, 0.2], [0.0, 0.0], [0.0, 0.0]])
    np.testing.assert_array_equal(infos["_state"], mask)
    expected = np.array([[0.1, 0.2], [0.5, -1.0], [0.5, -1.0]])
    np.testing.assert_array_equal(observations, vector.task.features(expected))


@pytest.mark.parametrize(
    ("seed", "options", "complaint"),
    [
        ([1, 2], {}, "there must be 3 seeds, one a row, not 2"),
        (None, {"sate": 1}, r"unknown reset options: 'sate' \(known: reset_mask, state\)"),
        (None, {"state": np.zeros((2, 2))}, r"must have shape \(2,\) or \(3, 2\), not \(2, 2\)"),
        (
            None,
            {"state": np.full((3, 2), 9.0)},
            r"coordinate 1 must lie in \[-8.0, 8.0\], not be 9",
        ),
        (None, {"reset_mask": [True] * 3}, "must be a numpy array of bool"),
        (None, {"reset_mask": np.ones(3, np.int8)}, "must be a numpy array of bool"),
        (None, {"reset_mask": np.ones(2, np.bool_)}, r"must have shape \(3,\)"),
        (None, {"reset_mask": np.zeros(3, np.bool_)}, "at least one True"),
    ],
)
def test_a_bad_reset_is_refused(seed: Any, options: dict[str, Any], complaint: str) -> None:
    vector, untouched = native("Pendulum", rows=3), native("Pendulum", rows=3)
    vector.reset(seed=0)
    untouched.reset(seed=0)
    with pytest.raises(ValueError, match=complaint):
        vector.reset(seed=seed, options=options)
    assert data_equivalence(vector.reset(), untouched.reset(), exact=True)


def test_a_bad_seed_changes_no_row() -> None:
    vector, untouched = native("Pendulum", rows=3), native("Pendulum", rows=3)
    vector.reset(seed=0)
    untouched.reset(seed=0)
    with pytest.raises(gymnasium.error.Error, match="-1"):
        vector.reset(seed=[7, -1, 8])
    assert data_equivalence(vector.reset(), untouched.reset(), exact=True)


def test_what_is_not_started_does_not_move() -> None:
    vector = native("Pendulum", rows=2, autoreset_mode="Disabled", max_episode_steps=1)
    with pytest.raises(ResetNeeded, match="call reset"):
        vector.step(np.zeros((2, 1)))
    with pytest.raises(ResetNeeded, match="the first reset must start every row"):
        vector.reset(options={"reset_mask": np.array([True, False])})
    vector.reset(seed=0)
    vector.step(np.zeros((2, 1)))
    with pytest.raises(ResetNeeded, match=r"rows \[0, 1\] have ended"):
        vector.step(np.zeros((2, 1)))


@pytest.mark.parametrize(
    ("settings", "complaint"),
    [
        ({"num_envs": 0}, "num_envs must be a whole number from 1 on, not 0"),
        ({"max_episode_steps": 0}, "max_episode_steps must be a whole number from 1 on, not 0"),
        ({"autoreset_mode": "Never"}, "'Never' is not a valid AutoresetMode"),
        ({"render_mode": "human"}, "render_mode must be None or 'rgb_array'"),
    ],
)
def test_bad_settings_are_refused(settings: dict[str, Any], complaint: str) -> None:
    with pytest.raises(ValueError, match=complaint):
        GymnasiumVectorEnvironment("Pendulum", **settings)


@pytest.mark.parametrize("shape", [(2,), (3, 1), (2, 2), ()])
def test_bad_actions_are_refused(shape: tuple[int, ...]) -> None:
    vector = native("Pendulum", rows=2)
    vector.reset(seed=0)
    with pytest.raises(ValueError, match=r"actions must have shape \(2, 1\), not"):
        vector.step(np.zeros(shape))


def test_frames_of_every_row() -> None:
    vector = native("MassPoint", rows=2, render_mode="rgb_array")
    vector.reset(seed=0)
    frames = vector.render()
    assert frames is not None
    assert [frame.shape for frame in frames] == [(88, 480, 3)] * 2
    assert native("MassPoint").render() is None


def test_a_copy_goes_its_own_way() -> None:
    vector = native("CartPole", max_episode_steps=8)
    vector.reset(seed=0)
    walk = actions(vector, 24)
    for action in walk[:5]:
        vector.step(action)
    sent = pickle.loads(pickle.dumps(vector))  # noqa: S301 - our own
    copies = [copy.deepcopy(vector), sent]
    expected = [vector.step(action) for action in walk]
    for each in copies:
        assert data_equivalence([each.step(action) for action in walk], expected, exact=True)
        each.close()


def test_its_spec_makes_it_again() -> None:
    vector = native("Pendulum", rows=4, max_episode_steps=7)
    assert vector.spec is not None
    again = gymnasium.make_vec(gymnasium.envs.registration.EnvSpec.from_json(vector.spec.to_json()))
    assert data_equivalence(again.reset(seed=1), vector.reset(seed=1), exact=True)
