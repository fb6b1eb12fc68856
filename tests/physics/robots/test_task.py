"""A robot, its substeps, a reward and an end make a task; what is wrong with them is told."""

from dataclasses import replace
from typing import Any

import pytest

from physics.robots.model.description import Joint
from physics.robots.task import RobotTask
from physics.tasks.half_cheetah import ROBOT, HalfCheetah


def declared(**attributes: Any) -> type:
    return type("Wrong", (RobotTask,), attributes)


def test_all_mistakes_of_a_declaration_are_told() -> None:
    with pytest.raises(ValueError, match="Wrong is not a valid robot's task") as caught:
        declared(substeps=2.5, substep_seconds=1, end=3)
    for complaint in (
        "robot must be of type Robot, not None",
        "substep_seconds must be of type float, not 1",
        "substeps must be of type int, not 2.5",
        "reward must be of type Reward, not None",
        "end must be of type End, not 3",
    ):
        assert f"\n- {complaint}" in str(caught.value)


def test_a_robot_that_cannot_be_is_refused_with_its_mistakes() -> None:
    torso, thigh, shin, *_ = ROBOT.links
    bent = replace(shin, joint=Joint(1.0, -1.0, 0.0, 0.0, 0.0, 1.0, axis=2.0))
    robot = replace(ROBOT, links=(torso, bent, thigh), total_mass=0.0)
    with pytest.raises(ValueError, match="Wrong is not a valid robot's task") as caught:
        declared(robot=robot, substeps=1, substep_seconds=0.01, reward=HalfCheetah.reward)
    for complaint in (
        "the stops of 'bshin' must be lower < upper",
        "the axis of 'bshin' must be 1 or -1, not 2.0",
        "the parent of 'bshin' must be one of 'torso', not 'bthigh'",
        "total_mass must be above 0 kg, not 0.0",
    ):
        assert f"\n- {complaint}" in str(caught.value)


def test_sizes_and_seconds_follow_from_the_declaration() -> None:
    assert (HalfCheetah.state_size, HalfCheetah.action_size) == (14, 4)
    assert HalfCheetah.step_seconds == 0.05


def test_pieces_tell_apart_as_many_constraints_as_there_are(other_robots: dict[str, Any]) -> None:
    """Of 40, on the first tooth and on the last; two bits each in 64 would leave out the last."""
    drop = other_robots["drop"]
    assert drop["constraints"] == 40
    assert drop["pushed"] == [[1], [35], []]
    assert sorted(drop["pieces"]) == [0, 1, 2]
    assert drop["regimes"] == ["sticking", "sticking", "free"]
