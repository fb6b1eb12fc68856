"""Drawings of models, and MuJoCo's own pictures of them."""

import os
import subprocess
import sys
from typing import Any

import numpy as np
import pytest

import physics
from physics.drawing import Capsule, Polygon
from physics.mujoco import MujocoTask, task
from tests.physics.mujoco.models import ARM, FREE, distance, nearness


def arm(**changes: Any) -> MujocoTask:
    """The arm, stretched along x."""
    return task(ARM, nearness, name="Arm", horizon=9, max_reward=0.0, measure=distance, **changes)()


def test_shapes_are_the_geoms_in_the_plane() -> None:
    drawing = arm().draw(np.zeros(7))
    upper, lower, target = drawing.shapes
    assert isinstance(upper, Capsule)
    assert sorted([upper.start, upper.end]) == [pytest.approx((0, 0)), pytest.approx((0.4, 0))]
    assert (upper.radius, upper.role) == (0.04, "body")
    assert isinstance(lower, Capsule)
    assert lower.role == "link"
    assert isinstance(target, Capsule)
    assert target.start == target.end == pytest.approx((0.3, 0.4))
    assert target.role == "target"
    turned = arm().draw(np.array([-np.pi / 2, 0, 0, 0, 0, 0, 0])).shapes[0]
    assert isinstance(turned, Capsule)
    assert max(turned.start[1], turned.end[1]) == pytest.approx(0.4)
    above = arm(plane="xy").draw(np.zeros(7)).shapes[2]
    assert isinstance(above, Capsule)
    assert above.start == pytest.approx((0.3, 0.0))


def test_a_box_is_its_outline_and_the_ground_a_line_below() -> None:
    tumbling = task(
        FREE.replace("INTEGRATOR", "Euler"), lambda s, a, n: n[2], name="Tumbling", horizon=9,
        max_reward=2.0,
    )()  # fmt: skip
    start = tumbling.initial_states([0])[0]
    ground, box, *_ = tumbling.draw(start).shapes
    assert isinstance(ground, Capsule)
    assert ground.role == "ground"
    assert ground.start[1] + ground.radius == pytest.approx(0.0)
    assert isinstance(box, Polygon)
    assert sorted(box.points) == [
        pytest.approx(corner) for corner in [(-0.1, 0.7), (-0.1, 1.3), (0.1, 0.7), (0.1, 1.3)]
    ]
    moved = start.copy()
    moved[:3] += [5.0, 0.0, 0.0]
    left, _, right, _ = tumbling.draw(moved).view
    assert left < 5.0 < right, "the view moves along"


def test_a_model_without_geoms_has_a_view() -> None:
    bare = task(
        '<mujoco><worldbody><body><inertial pos="0 0 0" mass="1" diaginertia="1 1 1"/>'
        '<joint name="slide" type="slide" axis="1 0 0"/></body></worldbody>'
        '<actuator><motor joint="slide"/></actuator></mujoco>',
        lambda s, a, n: -(n[0] ** 2), name="Bare", horizon=9, max_reward=0.0,
    )()  # fmt: skip
    left, bottom, right, top = bare.draw(bare.initial_states([0])[0]).view
    assert left < 0.0 < right
    assert bottom < 0.0 < top


@pytest.mark.parametrize(("library", "works"), [("egl", None), ("glfw", False)])
def test_mujocos_renderer_or_a_sentence(library: str, works: bool | None) -> None:
    """Whether EGL works depends on the machine; without a screen GLFW does not."""
    code = (
        "import physics\ntask = physics.make('mujoco/Reacher')\n"
        "try: print(task.photograph(task.initial_states([0])[0], 64, 48).shape)\n"
        "except RuntimeError as error: print(error)"
    )
    environment = {**os.environ, "MUJOCO_GL": library}
    environment.pop("DISPLAY", None)
    answer = subprocess.run(
        [sys.executable, "-c", code], capture_output=True, text=True, check=True, env=environment
    )
    said = answer.stdout.strip()
    assert said == "(48, 64, 3)" or "MuJoCo's renderer needs OpenGL" in said
    if works is False:
        assert "MUJOCO_GL=egl" in said


def test_contacts_are_arrows_from_the_ground() -> None:
    hopper = physics.make("mujoco/Hopper")
    states = hopper.initial_states([0, 1])
    for _ in range(20):
        states = hopper.step(states, np.zeros((2, 3))).next_state
    lifted = states.copy()
    lifted[:, 1] += 1.0
    for arrows in hopper.contact_impulses(states, np.zeros((2, 3))):
        assert len(arrows) >= 1
        assert (np.abs(arrows[:, 1]) < 0.02).all(), "at the ground"
        weight = sum(hopper.model.body_mass) * 9.81  # type: ignore[attr-defined]
        assert 0.2 < arrows[:, 3].sum() / (weight * hopper.step_seconds) < 5.0
    assert [len(each) for each in hopper.contact_impulses(lifted, np.zeros((2, 3)))] == [0, 0]
