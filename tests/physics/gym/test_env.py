"""The tasks through `gymnasium.make`: checkers, time limits, starts, spaces, videos."""

import copy
import pickle
import subprocess
import warnings
from pathlib import Path
from typing import Any

import gymnasium
import numpy as np
import pytest
from gymnasium.error import ResetNeeded
from gymnasium.utils.env_checker import check_env
from gymnasium.wrappers import RecordVideo, TimeAwareObservation
from imageio_ffmpeg import get_ffmpeg_exe
from numpy.typing import NDArray
from stable_baselines3.common.env_checker import check_env as check_env_of_stable_baselines

import physics
from physics.environment import FloatArray, UnsolvedStepError
from physics.gym.env import GymnasiumEnvironment
from physics.gym.registration import identifier
from physics.randomness import generator

every_task = pytest.mark.parametrize("name", physics.names())


def make(name: str, **settings: Any) -> gymnasium.Env[FloatArray, Any]:
    return gymnasium.make(identifier(name), **settings)


def bare(name: str, **settings: Any) -> GymnasiumEnvironment:
    environment = make(name, **settings).unwrapped
    assert isinstance(environment, GymnasiumEnvironment)
    return environment


def walk(
    environment: gymnasium.Env[FloatArray, Any], steps: int
) -> list[tuple[FloatArray, float, bool, bool]]:
    """Steps under one fixed action, as far as the episode goes."""
    action = np.full(environment.action_space.shape or (), 0.3, np.float32)
    walked: list[tuple[FloatArray, float, bool, bool]] = []
    while len(walked) < steps and not (walked and (walked[-1][2] or walked[-1][3])):
        observation, reward, terminated, truncated, _ = environment.step(action)
        walked.append((observation, float(reward), terminated, truncated))
    return walked


def frames_of(video: Path, shape: tuple[int, int, int]) -> NDArray[np.uint8]:
    """The frames [count, *shape] of a film."""
    raw = subprocess.run(
        [get_ffmpeg_exe(), "-i", video, "-f", "rawvideo", "-pix_fmt", "rgb24", "-"],
        capture_output=True,
        check=True,
    )
    return np.frombuffer(raw.stdout, np.uint8).reshape(-1, *shape)


@every_task
def test_gymnasiums_own_check(name: str) -> None:
    environment = bare(name, render_mode="rgb_array")
    space = environment.observation_space
    assert isinstance(space, gymnasium.spaces.Box)
    with warnings.catch_warnings():
        if not space.is_bounded():
            # A cart's speed has no bound; Gymnasium's own tasks declare and warn the same.
            warnings.filterwarnings("ignore", ".*A Box observation space m.*imum value is -?inf")
        check_env(environment)


@every_task
def test_stable_baselines_own_check(name: str) -> None:
    check_env_of_stable_baselines(make(name, render_mode="rgb_array"), skip_render_check=False)


@every_task
def test_it_walks_the_tasks_own_episode(name: str) -> None:
    task, made = physics.make(name), make(name)
    observation, information = made.reset(seed=7)
    state: FloatArray = task.initial_states([7])
    random = generator(0, "gymnasium")
    for elapsed in range(1, task.horizon + 1):
        np.testing.assert_array_equal(information["state"], state[0])
        np.testing.assert_array_equal(observation, task.features(state)[0])
        assert observation in made.observation_space
        action = random.uniform(-1.0, 1.0, (1, task.action_size))
        expected = task.differentiate(state, action)
        observation, reward, terminated, truncated, information = made.step(action[0])
        assert reward == expected.transition.reward[0]
        np.testing.assert_array_equal(information["state_jacobian"], expected.state_jacobian[0])
        np.testing.assert_array_equal(information["action_jacobian"], expected.action_jacobian[0])
        assert terminated == expected.transition.terminated[0]
        assert truncated == (elapsed == task.horizon)
        if terminated:
            break
        state = expected.transition.next_state


def test_the_time_limit_is_gymnasiums() -> None:
    longer = make("Pendulum", max_episode_steps=1000)
    longer.reset(seed=0)
    walked = walk(longer, 2000)
    assert len(walked) == 1000
    assert walked[-1][3]
    endless = make("Pendulum", max_episode_steps=-1)
    endless.reset(seed=0)
    assert len(walk(endless, 1500)) == 1500
    assert make("Pendulum").spec.max_episode_steps == 200  # type: ignore[union-attr]
    assert bare("Pendulum").spec.max_episode_steps is None  # type: ignore[union-attr]


def test_time_can_be_observed() -> None:
    aware = TimeAwareObservation(make("Pendulum"))
    observation, _ = aware.reset(seed=0)
    assert observation in aware.observation_space
    times = [observation[-1], *(aware.step(np.zeros(1))[0][-1] for _ in range(200))]
    assert times == list(range(201))


@every_task
def test_any_float_is_an_action(name: str) -> None:
    random = generator(0, "any float")
    action = random.uniform(-1.2, 1.2, bare(name).task.action_size).astype(np.float32)
    moved = []
    for given in (action, action.astype(np.float64), action.tolist()):
        environment = make(name)
        environment.reset(seed=1)
        moved.append(environment.step(given))
    np.testing.assert_array_equal(moved[0][0], moved[1][0])
    np.testing.assert_array_equal(moved[0][0], moved[2][0])
    assert moved[0][0].dtype == np.float64
    assert moved[0][1] == moved[1][1] == moved[2][1]


@pytest.mark.parametrize(
    ("action", "complaint"),
    [
        (np.zeros(2), r"actions must have shape \(1,\), not \(2,\)"),
        (np.zeros((1, 1)), r"actions must have shape \(1,\), not \(1, 1\)"),
        (0.5, r"actions must have shape \(1,\), not \(\)"),
        (np.array([np.nan]), "finite|nan"),
    ],
)
def test_a_bad_action_is_refused(action: Any, complaint: str) -> None:
    environment = make("Pendulum")
    environment.reset(seed=0)
    with pytest.raises(ValueError, match=complaint):
        environment.step(action)


def test_spaces_are_as_tight_as_the_task() -> None:
    def box(name: str) -> tuple[list[float], list[float]]:
        space = bare(name).observation_space
        assert isinstance(space, gymnasium.spaces.Box)
        return space.low.tolist(), space.high.tolist()

    assert box("Pendulum") == ([-1.0, -1.0, -8.0], [1.0, 1.0, 8.0])
    assert box("MountainCar") == ([-1.2, -0.07], [0.6, 0.07])
    assert box("Acrobot")[1] == [1.0, 1.0, 1.0, 1.0, 4 * np.pi, 9 * np.pi]
    assert box("CartPole")[1] == [np.inf, np.inf, 1.0, 1.0, np.inf]
    assert bare("HalfCheetah").action_space == gymnasium.spaces.Box(-1.0, 1.0, (4,), np.float32)


@every_task
def test_an_episode_may_start_in_a_given_state(name: str) -> None:
    task, environment = physics.make(name), make(name)
    states = task.initial_states([3, 4])
    states = task.step(states, np.full((2, task.action_size), 0.5)).next_state
    for state in states:
        observation, information = environment.reset(options={"state": state.tolist()})
        np.testing.assert_array_equal(information["state"], state)
        np.testing.assert_array_equal(observation, task.features(state[None])[0])
        action = np.full(task.action_size, -0.25)
        expected = task.step(state[None], action[None]).next_state[0]
        np.testing.assert_array_equal(environment.step(action)[4]["state"], expected)


def test_a_given_state_leaves_the_seeds_alone() -> None:
    one, other = make("Pendulum"), make("Pendulum")
    one.reset(seed=5)
    other.reset(seed=5, options={"state": [0.1, 0.2]})
    other.reset(options={"state": [0.1, 0.2]})
    np.testing.assert_array_equal(one.reset()[0], other.reset()[0])


@pytest.mark.parametrize(
    ("options", "complaint"),
    [
        ({"state": [0.0]}, r"options\['state'\] must have shape \(2,\), not \(1,\)"),
        ({"state": [[0.0, 0.0]]}, r"must have shape \(2,\), not \(1, 2\)"),
        ({"state": [np.nan, 0.0]}, "must be finite"),
        ({"state": [np.inf, 0.0]}, "must be finite"),
        ({"state": ["fast", 0.0]}, "must be 2 numbers, not"),
        ({"state": None}, r"must have shape \(2,\)|must be 2 numbers|must be finite"),
        (
            {"state": [5.0, 0.1]},
            r"no state of MountainCar: coordinate 0 must lie in \[-1.2, 0.6\], not be 5.0; coordi",
        ),
        ({"stat": [0.0, 0.0], 3: 1}, r"unknown reset options: 'stat', 3 \(known: state\)"),
    ],
)
def test_a_bad_start_is_refused(options: dict[str, Any], complaint: str) -> None:
    environment = make("MountainCar")
    environment.reset(seed=2)
    with pytest.raises(ValueError, match=complaint):
        environment.reset(seed=9, options=options)
    expected = bare("MountainCar")
    expected.reset(seed=2)
    np.testing.assert_array_equal(environment.step([0.5])[0], expected.step([0.5])[0])
    np.testing.assert_array_equal(environment.reset()[0], expected.reset()[0])


def test_a_start_from_which_no_step_is_found_is_refused(monkeypatch: pytest.MonkeyPatch) -> None:
    environment = bare("Pendulum")

    def unsolved(*_: Any) -> None:
        raise UnsolvedStepError("no solution")

    monkeypatch.setattr(environment.task, "step", unsolved)
    with pytest.raises(ValueError, match="no state of Pendulum: no solution"):
        environment.reset(options={"state": [0.0, 0.0]})


def test_nothing_moves_before_a_reset() -> None:
    environment = bare("Pendulum", render_mode="rgb_array")
    with pytest.raises(ResetNeeded, match="call reset"):
        environment.step([0.0])
    with pytest.raises(ResetNeeded, match="call reset"):
        environment.render()


def test_jacobians_can_be_left_out() -> None:
    plain, full = make("Pendulum", jacobians=False), make("Pendulum")
    plain.reset(seed=0)
    full.reset(seed=0)
    one, other = plain.step([0.5]), full.step([0.5])
    np.testing.assert_array_equal(one[0], other[0])
    assert set(one[4]) == {"state"}
    assert set(other[4]) == {"state", "state_jacobian", "action_jacobian"}


def test_a_window_is_gymnasiums_own() -> None:
    with pytest.raises(ValueError, match="must be None or 'rgb_array', not 'human'"):
        GymnasiumEnvironment("Pendulum", render_mode="human")
    frames = make("Pendulum", render_mode="rgb_array_list")
    frames.reset(seed=0)
    frames.step([0.0])
    rendered: Any = frames.render()
    assert len(rendered) == 2


@every_task
def test_a_copy_goes_its_own_way(name: str) -> None:
    environment = make(name)
    environment.reset(seed=1)
    walk(environment, 3)
    sent = pickle.loads(pickle.dumps(environment))  # noqa: S301 - our own
    copies = [copy.deepcopy(environment), sent]
    expected = walk(environment, 3)
    start = environment.reset()[0]
    for each in copies:
        for one, other in zip(walk(each, 3), expected, strict=True):
            np.testing.assert_array_equal(one[0], other[0])
            assert one[1:] == other[1:]
        np.testing.assert_array_equal(each.reset()[0], start)
        each.close()
        each.close()


@pytest.mark.parametrize("name", ["MassPoint", "RollingDie"])
def test_an_episode_becomes_a_video(name: str, tmp_path: Path) -> None:
    recorded: Any = RecordVideo(make(name, render_mode="rgb_array"), str(tmp_path / "videos"))
    recorded.reset(seed=0)
    walk(recorded, 4)
    frame: Any = recorded.unwrapped.render()
    recorded.close()
    (video,) = tmp_path.glob("videos/*.mp4")
    film = frames_of(video, frame.shape)
    assert len(film) == 5
    assert np.abs(film[-1].astype(float) - frame).mean() < 10.0
