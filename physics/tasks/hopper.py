"""Hopper: hop forward on one leg, with hard contact, and do not fall.

MuJoCo's hopper (Erez, Tassa and Todorov 2011; Todorov et al. 2012) as Gymnasium's Hopper-v5 has it:
geometry, masses, joints, motors and friction of its hopper.xml, its reward, start and end. Four
substeps of 0.002 s under one action, each as in robots/dynamics/substep.py.

    s = (q, v),    q = (rootx, rootz, rooty, thigh, leg, foot)
    r = (x' - x) / 0.008 + 1 - 0.001 |clip(a)|^2       without the 1 in a step that ends the episode
    ends unless rootz' > 0.7, |rooty'| < 0.2, and all others but rootx within (-100, 100)

Glossary:
    rootx, rootz   place of the torso's middle (m), at height 1.25 when it stands
    rooty          pitch (rad), positive with the nose down
    thigh, ...     joint angles (rad), 0 when it stands, negative where the link swings forward
    a              motors of the three joints, 200 N m each

Contact points are the end spheres of all capsules but those inside a neighbour's
(robots/model/spheres.py): the torso's two, the knee, the heel and the toe.

Differences from MuJoCo: contacts and stops are hard, and have no margin; friction is Coulomb's,
between spheres and ground, with the larger of the two coefficients as in MuJoCo (1, for the foot
2); links do not touch each other; substeps are semi-implicit, MuJoCo's are Runge-Kutta; no start
lies beyond a stop, while in MuJoCo the noise puts half of the joints there; networks see speeds
above 10 unclipped.
"""

from math import inf, pi, radians

import numpy as np

from physics.environment import FloatArray
from physics.robots.end import Health
from physics.robots.model.description import Capsule, Joint, Link, Robot, mass_of
from physics.robots.reward import Running
from physics.robots.task import RobotTask

HEIGHT = 1.25


def _joint(lower: float, upper: float) -> Joint:
    """A joint with stops in degrees."""
    return Joint(
        radians(lower),
        radians(upper),
        stiffness=0.0,
        damping=1.0,
        armature=1.0,
        gear=200.0,
        axis=-1.0,
    )


LINKS = (
    Link(
        "torso",
        parent=None,
        place=(0.0, 0.0),
        capsules=(Capsule("torso", (0.0, 0.0), 0.2, 0.0, 0.05),),
        joint=None,
    ),
    Link(
        "thigh",
        parent="torso",
        place=(0.0, -0.2),
        capsules=(Capsule("thigh", (0.0, -0.225), 0.225, 0.0, 0.05),),
        joint=_joint(-150.0, 0.0),
    ),
    Link(
        "leg",
        parent="thigh",
        place=(0.0, -0.45),
        capsules=(Capsule("leg", (0.0, -0.25), 0.25, 0.0, 0.04),),
        joint=_joint(-150.0, 0.0),
    ),
    Link(
        "foot",
        parent="leg",
        place=(0.0, -0.5),
        capsules=(Capsule("foot", (0.065, 0.0), 0.195, -pi / 2, 0.06, friction=2.0),),
        joint=_joint(-45.0, 45.0),
    ),
)
ROBOT = Robot(LINKS, total_mass=mass_of(LINKS, density=1000.0), gravity=9.81, friction=1.0)


class Hopper(RobotTask):
    """The hopper, standing at the start."""

    name = "Hopper"
    version = 1
    horizon = 1000
    max_reward = 4.0
    rounding = 2e-13  # the rounding of heights, divided by the substep
    robot = ROBOT
    substep_seconds = 0.002
    substeps = 4
    reward = Running(control_cost=0.001, bonus=1.0)
    end = Health({1: (0.7, inf), 2: (-0.2, 0.2), **dict.fromkeys(range(3, 12), (-100.0, 100.0))})

    def initial_state(self, generator: np.random.Generator) -> FloatArray:
        """MuJoCo's start, with joints no further than their stops."""
        state = generator.uniform(-5e-3, 5e-3, self.state_size)
        state[1] += HEIGHT
        return self.raised(self.stopped(state))

    def sample(self, generator: np.random.Generator, count: int) -> tuple[FloatArray, FloatArray]:
        """As for any robot, but those that come to rest stand: lying ones are at kinks."""
        states, actions = super().sample(generator, count)
        starts = self.initial_states(generator.integers(2**60, size=len(states[2::4])))
        states[2::4] = self.set_down(generator, starts)
        return states, actions
