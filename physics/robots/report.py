"""The contacts of a step, substep by substep, for checks of the physics."""

from typing import NamedTuple

import numpy as np

from physics.environment import BoolArray
from physics.kernels.compiled import compiled
from physics.record import Floats, Integers, Records
from physics.robots.dynamics.body import Body, load_action, load_state
from physics.robots.dynamics.constraints import measure
from physics.robots.dynamics.pose import place
from physics.robots.dynamics.residual import BOUND, residual
from physics.robots.dynamics.substep import advance, solve_substep
from physics.robots.lcp.contact_mode import OPEN
from physics.robots.model.mechanism import Mechanism


class ContactReport(NamedTuple):
    """A step's contacts: b rows of the batch, c spheres, l stops of joints."""

    gap: Floats
    """[b, substep, c], height of each sphere's lowest point at the end of the substep (m)."""
    normal_impulse: Floats
    """[b, substep, c] (N s)."""
    tangential_impulse: Floats
    """[b, substep, c], along +x on the robot (N s)."""
    slip: Floats
    """[b, substep, c], `Jt v'` of the spheres in contact, 0 of the others (m/s)."""
    stop_impulse: Floats
    """[b, substep, l], lower and upper stop of each joint in turn (N m s)."""
    residual: Floats
    """[b, substep], largest error of the substep's equations (dynamics/residual.py)."""
    mode: Integers
    """[b, substep, c + l], each constraint's mode (contact_mode.py): OPEN, STICK (for a stop:
    active), SLIDE_AHEAD, SLIDE_BACK."""


def empty_report(mechanism: Records, batch: int, substeps: int) -> ContactReport:
    """An empty report, with all impulses 0 and all modes OPEN."""
    spheres = mechanism["radius"].shape[1]
    stops = mechanism["stop_joint"].shape[1]

    def zeros(width: int) -> Floats:
        return np.zeros((batch, substeps, width))

    return ContactReport(
        gap=zeros(spheres),
        normal_impulse=zeros(spheres),
        tangential_impulse=zeros(spheres),
        slip=zeros(spheres),
        stop_impulse=zeros(stops),
        residual=np.zeros((batch, substeps)),
        mode=np.full((batch, substeps, spheres + stops), OPEN),
    )


@compiled
def _report_impulses(
    mechanism: Mechanism, body: Body, row: int, substep: int, report: ContactReport
) -> None:
    problem, spheres = body.problem, mechanism.radius.shape[0]
    for i in range(problem.count):
        k = body.candidate[i]
        report.mode[row, substep, k] = problem.mode[i]
        if k >= spheres:
            report.stop_impulse[row, substep, k - spheres] = problem.impulse[2 * i]
        elif problem.mode[i] != OPEN:
            report.normal_impulse[row, substep, k] = problem.impulse[2 * i]
            report.tangential_impulse[row, substep, k] = problem.impulse[2 * i + 1]
            for j in range(body.next_v.shape[0]):
                report.slip[row, substep, k] += body.J[2 * i + 1, j] * body.next_v[j]


@compiled
def report_rows(
    mechanisms: Records,
    bodies: Records,
    h: float,
    states: Floats,
    actions: Floats,
    report: ContactReport,
) -> int:
    """Fill an empty report; return -1, or the first row that could not be solved."""
    mechanism, body = mechanisms[0], bodies[0]
    for row in range(states.shape[0]):
        load_state(mechanism, states, row, body)
        load_action(mechanism, actions, row, body)
        for substep in range(report.residual.shape[1]):
            solve_substep(mechanism, h, body)
            report.residual[row, substep] = residual(mechanism, body)
            if not report.residual[row, substep] <= BOUND:
                return row
            _report_impulses(mechanism, body, row, substep, report)
            advance(body, h)
            place(mechanism, body.q, body.pose)
            measure(mechanism, body.q, body.pose, body.margin)
            for k in range(report.gap.shape[2]):
                report.gap[row, substep, k] = body.margin[k]
    return -1


@compiled
def world_points(
    mechanisms: Records,
    bodies: Records,
    states: Floats,
    links: Integers,
    points: Floats,
    places: Floats,
) -> None:
    """Fill places [batch, p, 2] (x, z) of points [p, 2] of links [p] for states [batch, 2n]."""
    mechanism, body = mechanisms[0], bodies[0]
    for row in range(states.shape[0]):
        load_state(mechanism, states, row, body)
        place(mechanism, body.q, body.pose)
        for k in range(links.shape[0]):
            c, s = body.pose.turn[links[k], 0], body.pose.turn[links[k], 1]
            x, z = points[k, 0], points[k, 1]
            places[row, k, 0] = body.pose.origin[links[k], 0] + (c * x + s * z)
            places[row, k, 1] = body.pose.origin[links[k], 1] + (c * z - s * x)


@compiled
def find_sunk(
    mechanisms: Records, no_bodies: Records, states: Floats, depth: float, sunk: BoolArray
) -> bool:
    """Mark states [batch] with a sphere in the ground or a joint in its stop by more than `depth`.

    It is called at every step and makes its own body; `no_bodies` [0] has the type.

    Returns:
        Whether there is any.
    """
    mechanism, bodies = mechanisms[0], np.empty(1, no_bodies.dtype)
    found = False
    for row in range(states.shape[0]):
        body = bodies[0]  # indexed in the loop, which keeps `bodies` alive
        load_state(mechanism, states, row, body)
        place(mechanism, body.q, body.pose)
        measure(mechanism, body.q, body.pose, body.margin)
        sunk[row] = False
        for k in range(body.margin.shape[0]):
            sunk[row] |= body.margin[k] < -depth
        found |= sunk[row]
    return found
