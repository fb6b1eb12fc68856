"""Other robots on the same engine; run uncompiled, as a program, it prints what it found.

A ball (one link, two spheres in one place), a hopper (a leg of three links), and a comb (with 38
spheres), described as data and never compiled: compiling the engine for their sizes would take
longer than interpreting it.
"""

import json
import math
import sys
from typing import Any

import numpy as np

from physics.environment import FloatArray
from physics.record import dtype
from physics.robots.dynamics.body import Body, load_action, load_state, unload
from physics.robots.dynamics.residual import residual
from physics.robots.dynamics.substep import advance, solve_substep
from physics.robots.dynamics.substep_derivative import (
    Tangent,
    differentiate_substep,
    load_tangent,
    unload_tangent,
)
from physics.robots.model.description import Capsule, Joint, Link, Robot
from physics.robots.model.mechanism import build, sizes
from physics.robots.reward import Running
from physics.robots.task import RobotTask

H = 0.01
BALL = Robot(
    links=(Link("ball", None, (0.0, 0.1), (Capsule("ball", (0.0, 0.0), 0.0, 0.0, 0.1),), None),),
    total_mass=1.0,
    gravity=9.81,
    friction=0.3,
)


def _leg(name: str, parent: str, place: tuple[float, float], half: float) -> Link:
    joint = Joint(-1.0, 1.0, stiffness=20.0, damping=1.0, armature=0.05, gear=40.0)
    return Link(name, parent, place, (Capsule(name, (0.0, -half), half, 0.0, 0.05),), joint)


HOPPER = Robot(
    links=(
        Link("torso", None, (0.0, 1.1), (Capsule("torso", (0.0, 0.2), 0.2, 0.0, 0.05),), None),
        _leg("thigh", "torso", (0.0, 0.0), 0.225),
        _leg("shin", "thigh", (0.0, -0.45), 0.25),
        Link(
            "foot",
            "shin",
            (0.0, -0.5),
            (Capsule("foot", (0.06, -0.1), 0.195, math.pi / 2, 0.06),),
            Joint(-0.7, 0.7, stiffness=10.0, damping=1.0, armature=0.05, gear=20.0),
        ),
    ),
    total_mass=4.0,
    gravity=9.81,
    friction=0.9,
)

COMB = Robot(
    links=(
        Link(
            "comb",
            None,
            (0.0, 0.0),
            tuple(Capsule(f"{i}", (0.1 * i - 0.85, 0.0), 0.1, 0.0, 0.02) for i in range(18)),
            None,
        ),
        _leg("leg", "comb", (0.0, 0.0), 0.03),
    ),
    total_mass=1.0,
    gravity=9.81,
    friction=0.9,
)


class Comb(RobotTask):
    """A comb that is moved."""

    name, version, horizon, max_reward = "Comb", 1, 10, 1.0
    robot, substep_seconds, substeps = COMB, 0.01, 2
    reward = Running(control_cost=0.1)

    def initial_state(self, generator: np.random.Generator) -> FloatArray:
        """At rest."""
        del generator
        return np.zeros(self.state_size)


class Simulation:
    """A robot's step of some substeps, on one state at a time."""

    def __init__(self, robot: Robot, substeps: int) -> None:
        """Build it."""
        self.mechanism: Any = build(robot)[0]
        self.bodies = np.zeros(1, dtype(Body, **sizes(robot)))
        self.tangents = np.zeros(1, dtype(Tangent, **sizes(robot)))
        self.substeps = substeps
        self.worst_residual = 0.0

    def step(self, state: FloatArray, action: FloatArray) -> tuple[FloatArray, list[int]]:
        """The state after, and what was in contact how."""
        body, signature = self.bodies[0], []
        load_state(self.mechanism, state[None], 0, body)
        load_action(self.mechanism, action[None], 0, body)
        for _ in range(self.substeps):
            solve_substep(self.mechanism, H, body)
            self.worst_residual = max(self.worst_residual, residual(self.mechanism, body))
            count = int(body.problem.count)
            modes = zip(body.candidate[:count], body.problem.mode[:count], strict=True)
            signature += [*sorted(10 * int(k) + int(mode) for k, mode in modes if mode), -1]
            advance(body, H)
        after = np.empty((1, len(state)))
        unload(self.mechanism, body, after, 0)
        return after[0], signature

    def jacobian(self, state: FloatArray, action: FloatArray) -> FloatArray:
        """d state after / d (state, action)."""
        body, tangent = self.bodies[0], self.tangents[0]
        load_state(self.mechanism, state[None], 0, body)
        load_action(self.mechanism, action[None], 0, body)
        load_tangent(self.mechanism, action[None], 0, tangent)
        for _ in range(self.substeps):
            solve_substep(self.mechanism, H, body)
            differentiate_substep(self.mechanism, H, body, tangent)
            advance(body, H)
        by_state = np.empty((1, len(state), len(state)))
        by_action = np.empty((1, len(state), len(action)))
        unload_tangent(self.mechanism, tangent, by_state, by_action, 0)
        return np.concatenate([by_state[0], by_action[0]], axis=1)


def slide(speed: float) -> list[float]:
    """d vx' / d (vx, vz) of the ball, sliding on the ground at a speed (m/s)."""
    state = np.array([0.0, 0.0, 0.0, speed, -0.5, 0.0])
    jacobian = Simulation(BALL, 1).jacobian(state, np.empty(0))
    return [float(entry) for entry in jacobian[3, 3:5]]


def hop(steps: int) -> dict[str, Any]:
    """Drop the hopper, move its joints, and compare Jacobians along the way."""
    simulation, random = Simulation(HOPPER, 2), np.random.default_rng(0)
    state = np.zeros(12)
    state[:6] = 0.1 * random.normal(size=6)
    state[2] = 0.3
    errors, contacts, compared = [], 0, 0
    for _ in range(steps):
        action = random.uniform(-1.0, 1.0, 3)
        after, signature = simulation.step(state, action)
        exact, x, width = simulation.jacobian(state, action), np.append(state, action), 1e-6
        near = np.empty_like(exact)
        signatures = []
        for i in range(len(x)):
            ends = [x + side * width * np.eye(len(x))[i] for side in (1.0, -1.0)]
            (above, one), (below, other) = (simulation.step(e[:12], e[12:]) for e in ends)
            near[:, i] = (above - below) / (2 * width)
            signatures += [one, other]
        if all(each == signature for each in signatures):
            errors.append(np.abs(near - exact).max() / np.abs(exact).max())
            contacts += any(mode >= 0 for mode in signature)
            compared += 1
        state = after
    return {
        "worst": float(max(errors)),
        "compared": compared,
        "contacts": contacts,
        "residual": float(simulation.worst_residual),
    }


def drop() -> dict[str, Any]:
    """Let the comb fall on its first tooth, on its last, and not at all."""
    task = Comb()
    states = np.zeros((3, task.state_size))
    states[:, 1], states[:, 2] = (0.4, 0.4, 0.6), (-0.3, 0.3, 0.3)
    states = np.array([task.raised(state - 0.3 * np.eye(8)[1]) for state in states])
    states[2, 1] += 0.1
    states[:, 5] = -1.0
    actions = np.zeros((3, task.action_size))
    report, pieces = task.contact_report(states, actions), task.pieces(states, actions)
    return {
        "pushed": [np.flatnonzero(row[0]).tolist() for row in report.normal_impulse],
        "pieces": np.unique(pieces.piece, axis=0, return_inverse=True)[1].ravel().tolist(),
        "regimes": [task.regimes[index] for index in pieces.regime],
        "constraints": report.mode.shape[2],
    }


if __name__ == "__main__":
    json.dump(
        {"ahead": slide(2.0), "back": slide(-2.0), "hop": hop(40), "drop": drop()}, sys.stdout
    )
