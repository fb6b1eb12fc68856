"""MuJoCo's half cheetah as data, each foot welded to its shin (Wawrzynski 2009; Todorov 2012).

Frames and units are those of robot.py. Ranges, springs, dampers and gears of the joints are
MuJoCo's; masses and inertias follow from the capsules, as there.
"""

import math

from physics.robots.description import Capsule, Joint, Link, Robot

RADIUS = 0.046

ROBOT = Robot(
    links=(
        Link(
            "torso",
            parent=None,
            place=(0.0, 0.7),
            capsules=(
                Capsule("torso", (0.0, 0.0), 0.5, math.pi / 2, RADIUS),
                Capsule("head", (0.6, 0.1), 0.15, 0.87, RADIUS),
            ),
            joint=None,
        ),
        Link(
            "bthigh",
            parent="torso",
            place=(-0.5, 0.0),
            capsules=(Capsule("bthigh", (0.1, -0.13), 0.145, -3.8, RADIUS),),
            joint=Joint(-0.52, 1.05, stiffness=240.0, damping=6.0, armature=0.1, gear=120.0),
        ),
        Link(
            "bshin",
            parent="bthigh",
            place=(0.16, -0.25),
            capsules=(
                Capsule("bshin", (-0.14, -0.07), 0.15, -2.03, RADIUS),
                Capsule("bfoot", (-0.28 + 0.03, -0.14 - 0.097), 0.094, -0.27, RADIUS),
            ),
            joint=Joint(-0.785, 0.785, stiffness=180.0, damping=4.5, armature=0.1, gear=90.0),
        ),
        Link(
            "fthigh",
            parent="torso",
            place=(0.5, 0.0),
            capsules=(Capsule("fthigh", (-0.07, -0.12), 0.133, 0.52, RADIUS),),
            joint=Joint(-1.0, 0.7, stiffness=180.0, damping=4.5, armature=0.1, gear=120.0),
        ),
        Link(
            "fshin",
            parent="fthigh",
            place=(-0.14, -0.24),
            capsules=(
                Capsule("fshin", (0.065, -0.09), 0.106, -0.6, RADIUS),
                Capsule("ffoot", (0.13 + 0.045, -0.18 - 0.07), 0.07, -0.6, RADIUS),
            ),
            joint=Joint(-1.2, 0.87, stiffness=120.0, damping=3.0, armature=0.1, gear=60.0),
        ),
    ),
    total_mass=14.0,
    gravity=9.81,
    friction=0.4,
)
