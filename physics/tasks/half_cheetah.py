"""HalfCheetah: run forward on two legs of two links, with hard contact.

MuJoCo's half cheetah (Wawrzynski 2009; Todorov et al. 2012) with each foot welded to its shin. Five
substeps of 0.01 s under one action, each as in robots/dynamics/substep.py.

    s = (q, v),    q = (rootx, rootz, rooty, bthigh, bshin, fthigh, fshin)
    r = (x' - x) / 0.05 - 0.1 |clip(a)|^2

Glossary:
    rootx, rootz   place of the torso's middle (m), rootz as an offset from 0.7 m
    rooty          pitch (rad), positive with the nose down
    bthigh, ...    joint angles (rad), b the back leg, f the front leg
    a              motors of the four joints, gears 120, 90, 120, 60 N m

Ranges, springs, dampers and gears of the joints are MuJoCo's; masses and inertias follow from the
capsules, as in MuJoCo. Frames and units are those of robots/model/description.py.

Contact points are the end spheres of all capsules, in the order torso, head, bthigh, bshin, bfoot,
fthigh, fshin, ffoot; the end along +axis comes first (for the torso, the front one).
"""

import math

import numpy as np

from physics.environment import FloatArray
from physics.robots.model.description import Capsule, Joint, Link, Robot
from physics.robots.reward import Running
from physics.robots.task import RobotTask

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


class HalfCheetah(RobotTask):
    """The half cheetah, dropped on its feet at the start."""

    name = "HalfCheetah"
    version = 1
    horizon = 200
    max_reward = 10.0
    robot = ROBOT
    substep_seconds = 0.01
    substeps = 5
    reward = Running(control_cost=0.1)

    def initial_state(self, generator: np.random.Generator) -> FloatArray:
        """MuJoCo's start, raised until no sphere is below the ground."""
        q = generator.uniform(-0.1, 0.1, self.state_size // 2)
        v = 0.1 * generator.standard_normal(self.state_size // 2)
        return self.raised(np.concatenate([q, v]))
