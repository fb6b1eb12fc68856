"""Tasks of models and functions: they work, and what is wrong with them is said."""

import subprocess
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import torch

import physics
from physics.audit.audit import audit
from physics.catalogue import EXTRAS
from physics.environment import Environment, NotFiniteError
from physics.mujoco import task
from physics.randomness import generator
from tests.physics.mujoco.models import ARM, FREE, distance, nearness, nearness_in_numpy


def arm(**changes: Any) -> Environment:
    """The arm, with other arguments."""
    arguments: dict[str, Any] = {
        "model": ARM, "reward": nearness, "name": "Arm", "horizon": 100, "max_reward": 0.0,
        "substeps": 2, "measure": distance,
    }  # fmt: skip
    return task(**{**arguments, **changes})()


def test_its_sizes_follow_from_the_model() -> None:
    made = arm()
    assert (made.state_size, made.action_size, made.feature_size) == (7, 2, 8)
    assert made.angles == {0: 1}, "the shoulder turns round, the elbow has a range"
    assert made.step_seconds == 0.02
    assert made.regimes == ("free", "clipped", "limit"), "nothing of it can touch"
    assert arm(angles={"elbow": 2}, hidden=["shoulder"]).feature_size == 7


def test_the_box_is_the_range_of_controls() -> None:
    made = arm(reward=lambda s, a, following: 0.0 * a.sum())
    states = np.zeros((3, 7))
    followed = made.step(states, np.array([[0.0, -1.0], [1.0, -1.0], [0.0, 1.0]])).next_state
    np.testing.assert_array_equal(followed[0, :4], 0.0)
    assert abs(followed[1, 2]) > 1e-3
    assert abs(followed[2, 3]) > 1e-3


def test_the_measures_are_those_of_the_next_state() -> None:
    made = arm()
    states, actions = made.sample(generator(0, "arm"), 20)
    followed = made.step(states, actions).next_state
    tip = [0.4 * (np.cos(q) + np.cos(q + p)) for q, p in followed[:, :2]]
    height = [-0.4 * (np.sin(q) + np.sin(q + p)) for q, p in followed[:, :2]]
    np.testing.assert_allclose(followed[:, 4], np.array(tip) - 0.3, atol=1e-12)
    np.testing.assert_allclose(followed[:, 6], np.array(height) - 0.4, atol=1e-12)


def test_its_audit_passes() -> None:
    made = arm()
    for row in audit(made, count=10):
        assert row.passed(10, made.tolerance), row


def test_rewards_in_numpy_are_those_in_torch() -> None:
    one, other = arm(), arm(reward=nearness_in_numpy, written_in="numpy")
    states, actions = one.sample(generator(0, "arm"), 80)
    ours, theirs = one.differentiate(states, actions), other.differentiate(states, actions)
    np.testing.assert_allclose(ours.transition.reward, theirs.transition.reward, rtol=1e-13)
    for exact, differenced in zip(ours[3:], theirs[3:], strict=True):
        np.testing.assert_allclose(exact, differenced, rtol=1e-6, atol=1e-8)


def test_a_row_does_not_feel_the_others() -> None:
    made = arm()
    states, actions = made.sample(generator(0, "arm"), 70)
    whole = made.differentiate(states, actions)
    part = made.differentiate(states[5:9], actions[5:9])
    for one, other in zip(
        [*whole.transition, *whole[1:]], [*part.transition, *part[1:]], strict=True
    ):
        np.testing.assert_array_equal(one[5:9], other)
    assert made.step(states[:0], actions[:0]).reward.shape == (0,)
    assert made.differentiate(states[:0], actions[:0]).reward_action_gradient.shape == (0, 2)


def test_an_episode_ends_and_starts_as_declared() -> None:
    made = arm(
        terminated=lambda following: following[0] > 0.5,
        start=lambda random: random.uniform(0.0, 1.0, 4),
    )
    states = made.initial_states(range(40))
    assert ((states[:, :4] > 0.0) & (states[:, :4] < 1.0)).all()
    ends = made.step(states, np.zeros((40, 2)))
    np.testing.assert_array_equal(ends.terminated, ends.next_state[:, 0] > 0.5)
    assert 0 < ends.terminated.sum() < 40


def test_a_reward_without_gradient_has_none() -> None:
    made = arm(
        reward=lambda s, a, following: torch.sign(following[4]), reward_is_differentiable=False
    )
    found = made.differentiate(*made.sample(generator(0, "arm"), 5))
    assert not any(array.any() for array in found[3:])


@pytest.mark.parametrize(
    ("text", "complaint"),
    [
        (
            "<mujoco>\n<worldbody>\n<geom sise='1'/></worldbody></mujoco>",
            "line 3: MuJoCo cannot comp.*sise",
        ),
        ("<mujoco>\n<worldbody>\n", "line 2: MuJoCo cannot compile this model: XML parse error"),
        ("<mujoco>\n<actuator><motor joint='a'/></actuator></mujoco>", "line 2: .*target 'a'"),
        ("<mujoco/>", ": nothing moves in this model: give a body a joint"),
        (ARM[: ARM.index("<actuator>")] + "</mujoco>", ": this model has no actuator"),
    ],
)
@pytest.mark.parametrize("from_file", [True, False])
def test_a_model_that_is_none_is_refused_with_its_place(
    text: str, complaint: str, from_file: bool, tmp_path: Path
) -> None:
    (tmp_path / "bad.xml").write_text(text)
    where = r".*bad\.xml" if from_file else "the MJCF text"
    with pytest.raises(ValueError, match=f"^{where}(, )?{complaint}"):
        arm(model=tmp_path / "bad.xml" if from_file else text)


def test_a_missing_file_is_told_with_the_folder_it_is_sought_from() -> None:
    with pytest.raises(ValueError, match=r"^no\.xml: no such file \(from .*with_name"):
        arm(model="no.xml")


@pytest.mark.parametrize(
    ("changes", "complaint"),
    [
        ({"reward": lambda s, a, n: n}, r"^Arm is not a valid task:\n- reward .* \[\] .* \[7\]"),
        ({"reward": lambda s, a, n: n[9]}, r"^Arm is not a valid task:\n- reward raised Index"),
        ({"reward": lambda s, a: s[0]}, r"- reward raised TypeError"),
        ({"reward": nearness_in_numpy}, r"reward raised TypeError: (.|\n)*by written_in='numpy'"),
        ({"terminated": lambda n: n[0]}, "- terminated must .* not .* of torch.float64"),
        (
            {"written_in": "numpy", "reward": lambda s, a, n: n},
            r"^Arm is not a valid task:\n- reward must return a number, not an array \[7\] of",
        ),
        (
            {"written_in": "numpy", "reward": nearness_in_numpy, "terminated": lambda n: n[0]},
            "- terminated must return True or False, not float64",
        ),
        ({"written_in": "jax"}, r"^Arm: written_in must be 'torch' or 'numpy', not 'jax'"),
        ({"start": lambda random: np.zeros(3)}, r"Arm: what start returns must be float64 \[4\]"),
        ({"hidden": ["wrist"]}, r"^Arm: no joint 'wrist' .* \(there are: shoulder, elbow\)"),
        ({"substeps": 0}, "^Arm: substeps must be an integer from 1 on, not 0"),
        ({"plane": "zx"}, "^Arm: plane must be one of 'xz', 'xy', 'yz', not 'zx'"),
        ({"difference": 0.0}, "^Arm: difference must be a number above 0, not 0.0"),
        ({"measure": lambda m, d: 1.0}, r"^Arm: measure must return float64 \[k\], not float 1.0"),
        ({"horizon": 0}, "^Arm is not a valid task:\n- horizon must be an integer from 1 on"),
    ],
)  # fmt: skip
def test_a_mistake_names_task_and_function(changes: dict[str, Any], complaint: str) -> None:
    with pytest.raises(ValueError, match=complaint):
        arm(**changes)


def test_a_step_that_leaves_the_numbers_is_an_error_and_no_reset() -> None:
    made = arm()
    states = made.initial_states([0, 1])
    states[1, 2] = 1e200
    with pytest.raises(NotFiniteError, match="Arm: ") as caught:
        made.step(states, np.ones((2, 2)))
    assert caught.value.rows == (1,)


def test_a_free_joint_is_in_the_state_as_mujoco_has_it() -> None:
    made = task(
        FREE.replace("INTEGRATOR", "Euler"), lambda s, a, n: n[2], name="Tumbling", horizon=50,
        max_reward=2.0,
    )()  # fmt: skip
    assert (made.state_size, made.feature_size) == (12 + 10 + 1, 12 + 10 + 1 + 1)
    start = made.initial_states([0])
    np.testing.assert_array_equal(start[0, 3:7], [1.0, 0.0, 0.0, 0.0])


@pytest.mark.parametrize("name", EXTRAS["mujoco"])
def test_without_the_engine_a_sentence_says_what_to_install(name: str) -> None:
    code = (
        "import sys; sys.modules['mujoco'] = None\n"
        "import physics\n"
        f"try: physics.make({name!r})\n"
        "except ValueError as error: print(error)"
    )
    answer = subprocess.run(
        [sys.executable, "-c", code], capture_output=True, text=True, check=True
    )
    assert answer.stdout.startswith(name)
    assert answer.stdout.strip().endswith("need the package mujoco: pip install 'd3pg[mujoco]'")


def test_nobody_who_does_not_use_it_loads_the_engine() -> None:
    code = (
        "import physics, sys, gymnasium; physics.names(); physics.make('Pendulum').compile()\n"
        "import physics.mujoco; print('mujoco' in sys.modules)\n"
        "physics.make('mujoco/Reacher'); print('mujoco' in sys.modules, 'torch' in sys.modules)"
    )
    answer = subprocess.run(
        [sys.executable, "-c", code], capture_output=True, text=True, check=True
    )
    assert answer.stdout.split() == ["False", "True", "False"]


def test_physics_hands_out_the_package() -> None:
    assert physics.mujoco.task is task
