"""The physical parameters of a robot, and its mechanism with other values of them.

All links keep their shapes. The mass is that of the whole robot, distributed as in its description.
One factor scales the friction of every contact, which may differ between contacts, and another
scales the gear of every motor.
"""

from collections.abc import Mapping
from dataclasses import replace

from physics.parameter import Parameter
from physics.record import Records
from physics.robots.model.description import Robot
from physics.robots.model.mechanism import build


def parameters_of(robot: Robot) -> tuple[Parameter, ...]:
    """The parameters of a robot that may be changed."""
    return (
        Parameter(robot.gravity, "m/s^2", 0.0, 100.0, "gravity", "gravity"),
        Parameter(robot.total_mass, "kg", 0.1, 1e3, "mass of the robot", "mass"),
        Parameter(1.0, "1", 0.0, 10.0, "factor of every friction", "friction_scale"),
        Parameter(1.0, "1", 0.0, 10.0, "factor of every torque", "torque_scale"),
    )


def changed_mechanism(robot: Robot, values: Mapping[str, float]) -> Records:
    """The mechanism of a robot with these values: a read-only array [1] of its record."""
    changed = replace(robot, gravity=values["gravity"], total_mass=values["mass"])
    mechanism = build(changed).copy()
    mechanism[0]["friction"] *= values["friction_scale"]
    mechanism[0]["gear"] *= values["torque_scale"]
    mechanism.setflags(write=False)
    return mechanism
