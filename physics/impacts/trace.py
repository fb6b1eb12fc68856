"""The events at the contacts of one step, for audits and drawings.

A trace is an array `[contacts, FIELDS]` of events in the order of their moments; a row of kind 0 is
still free. The first fields of an event name the branches that the motion took there: two steps lie
on the same smooth piece of the map if and only if all their events agree in these fields.
"""

from typing import NamedTuple

import numpy as np

from physics.environment import FloatArray, IntArray
from physics.kernels.compiled import compiled

Trace = FloatArray

IMPACT, SETTLED, LYING = 1.0, 2.0, 3.0  # kinds of contact


class Event(NamedTuple):
    """One contact of one step, all numbers as floats."""

    kind: float
    """IMPACT, SETTLED or LYING."""
    corner: float
    """The index of the corner; -1 when lying."""
    path: float
    """Path of the impulse (impacts.impulse); when lying, 1 if it slides to the end of the step."""
    side: float
    """Sign of the slip that friction opposes, 0 where it makes no difference."""
    touched: float
    """1 if it came from a touch within the step, 0 if the step began with it."""
    landing: float
    """The corner whose landing ended a settled contact, else -1."""
    sunk: float
    """1 if the corner began below the ground, by more than rounding."""
    time_left: float
    """Remaining time of the step as the contact begins (s)."""
    x: float
    y: float
    """Where the corner is (m)."""
    tangential: float
    normal: float
    """The impulse on the body (N s)."""


KIND, PATH, LANDING = (Event._fields.index(name) for name in ("kind", "path", "landing"))
BRANCH_FIELDS = Event._fields.index("time_left")
FIELDS = len(Event._fields)

# Odd and large: codes of different branches coincide with probability 2^-64.
_MULTIPLIER = -7046029254386353131


@compiled
def note(trace: Trace, event: Event) -> None:
    """Write an event into the first free row."""
    for row in range(trace.shape[0]):
        if trace[row, KIND] == 0.0:
            for field in range(FIELDS):
                trace[row, field] = event[field]
            return


@compiled
def branch_code(trace: Trace) -> int:
    """One number for all branches of a trace; 0 without contact."""
    code = 0
    for row in range(trace.shape[0]):
        if trace[row, KIND] == 0.0:
            break
        for field in range(BRANCH_FIELDS):
            code = (code + int(trace[row, field]) + 2) * _MULTIPLIER
    return code


class ImpactReport(NamedTuple):
    """The contacts of each row's step, in order; k is the most that any row has."""

    kind: IntArray
    """[batch, k]: IMPACT, SETTLED, LYING, and 0 past a row's last contact."""
    corner: IntArray
    """[batch, k], -1 when lying."""
    path: IntArray
    """[batch, k], an index into `impulse.PATHS`; when lying, 1 if it slides to the end."""
    moment: FloatArray
    """[batch, k], seconds from the start of the step."""
    point: FloatArray
    """[batch, k, 2], where the corner is then (m)."""
    impulse: FloatArray
    """[batch, k, 2], on the body: along the ground, and upwards (N s)."""


def report_of(traces: FloatArray, step_seconds: float) -> ImpactReport:
    """The report of traces [batch, contacts, FIELDS]."""
    most = int((traces[..., 0] != 0.0).sum(axis=1).max(initial=0))
    field = dict(zip(Event._fields, np.moveaxis(traces[:, :most], -1, 0), strict=True))
    happened = field["kind"] != 0.0
    return ImpactReport(
        kind=field["kind"].astype(np.int64),
        corner=np.where(happened, field["corner"], -1).astype(np.int64),
        path=field["path"].astype(np.int64),
        moment=np.where(happened, step_seconds - field["time_left"], 0.0),
        point=np.stack([field["x"], field["y"]], axis=-1),
        impulse=np.stack([field["tangential"], field["normal"]], axis=-1),
    )
