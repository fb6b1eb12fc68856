"""A planar robot as a drawing: its capsules over flat ground."""

import math

from physics.drawing import Capsule, Drawing, box
from physics.record import Floats
from physics.robots.model.description import Robot

HALF_WIDTH = 1.5
"""How far the view reaches to either side of the root (m)."""


def draw_robot(robot: Robot, x: float, centres: Floats) -> Drawing:
    """Draw a robot around `x`, given the centres [any, 2] of the ends of its capsules.

    The ground has a mark every metre, so that a view that follows the robot shows how it moves.
    """
    ground = box((x, -0.1), 2 * HALF_WIDTH, 0.2, "ground")
    marks = [
        box((float(mark), -0.05), 0.03, 0.1, "joint")
        for mark in range(math.ceil(x - HALF_WIDTH), math.floor(x + HALF_WIDTH) + 1)
    ]
    ends = iter(centres.tolist())
    capsules = [
        Capsule(tuple(next(ends)), tuple(next(ends)), capsule.radius, role)
        for link in robot.links
        for capsule in link.capsules
        for role in ("body" if link.parent is None else "link",)
    ]
    view = (x - HALF_WIDTH, -0.2, x + HALF_WIDTH, 1.9)
    return Drawing(view=view, shapes=(ground, *marks, *capsules))
