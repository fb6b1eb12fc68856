"""Walker2d: walk forward on two legs, with hard contact, and do not fall.

MuJoCo's planar walker (Levine and Koltun 2013; Todorov et al. 2012) as Gymnasium's Walker2d-v5 has
it: geometry, masses, joints, motors and friction of its walker2d_v5.xml, its reward, start and end.
Four substeps of 0.002 s under one action, each as in robots/dynamics/substep.py.

    s = (q, v),    q = (rootx, rootz, rooty, thigh, leg, foot, thigh_left, leg_left, foot_left)
    r = (x' - x) / 0.008 + 1 - 0.001 |clip(a)|^2       without the 1 in a step that ends the episode
    ends unless 0.8 < rootz' < 2 and |rooty'| < 1

Glossary:
    rootx, rootz   place of the torso's middle (m), at height 1.25 when it stands
    rooty          pitch (rad), positive with the nose down
    thigh, ...     joint angles (rad), 0 when it stands, negative where the link swings forward
    a              motors of the six joints, 100 N m each

Contact points are the end spheres of all capsules but those inside a neighbour's
(robots/model/spheres.py): the torso's two, then the knee, the toe and the heel of each leg.

Differences from MuJoCo: contacts and stops are hard; friction is Coulomb's, between spheres and
ground, with the larger of the two coefficients as in MuJoCo (0.9, for the feet 1.9); substeps are
semi-implicit, MuJoCo's are Runge-Kutta; no start lies beyond a stop, while in MuJoCo the noise puts
half of the joints there; networks see speeds above 10 unclipped. As in MuJoCo, the legs pass each
other.
"""

from math import pi, radians

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
        damping=0.1,
        armature=0.01,
        gear=100.0,
        axis=-1.0,
    )


def _leg(side: str) -> tuple[Link, ...]:
    """The links of one leg; `side` ends the names of the left leg's links."""
    thigh, leg, foot = (f"{name}{side}" for name in ("thigh", "leg", "foot"))
    return (
        Link(
            thigh,
            parent="torso",
            place=(0.0, -0.2),
            capsules=(Capsule(thigh, (0.0, -0.225), 0.225, 0.0, 0.05),),
            joint=_joint(-150.0, 0.0),
        ),
        Link(
            leg,
            parent=thigh,
            place=(0.0, -0.45),
            capsules=(Capsule(leg, (0.0, -0.25), 0.25, 0.0, 0.04),),
            joint=_joint(-150.0, 0.0),
        ),
        Link(
            foot,
            parent=leg,
            place=(0.0, -0.5),
            capsules=(Capsule(foot, (0.1, 0.0), 0.1, -pi / 2, 0.06, friction=1.9),),
            joint=_joint(-45.0, 45.0),
        ),
    )


TORSO = Link(
    "torso",
    parent=None,
    place=(0.0, 0.0),
    capsules=(Capsule("torso", (0.0, 0.0), 0.2, 0.0, 0.05),),
    joint=None,
)
LINKS = (TORSO, *_leg(""), *_leg("_left"))
ROBOT = Robot(LINKS, total_mass=mass_of(LINKS, density=1000.0), gravity=9.81, friction=0.9)


class Walker2d(RobotTask):
    """The walker, standing at the start."""

    name = "Walker2d"
    version = 1
    horizon = 1000
    max_reward = 6.0
    rounding = 2e-13  # the rounding of heights, divided by the substep
    robot = ROBOT
    substep_seconds = 0.002
    substeps = 4
    reward = Running(control_cost=0.001, bonus=1.0)
    end = Health({1: (0.8, 2.0), 2: (-1.0, 1.0)})

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
