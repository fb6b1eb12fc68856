"""The impulse of one contact with Coulomb friction, and its derivative.

An impulse of tangential part `pt` and normal part `pn` at a contact changes its slip and its rate:

    u' = u + A pt + C pn        slip, along the ground
    v' = v + C pt + B pn        rate of the gap, v < 0 closes it

`routh_impulse` is an impact: Poisson's hypothesis (the restitution adds `e` times the normal
impulse of the compression) on Routh's path, which follows (pt, pn) as pn grows:

    slip     pt = k pn,  k = -mu sign(u),  until the slip ends at ps = -u / (C + k A)
    stick    u = 0, so pt = -(u + C pn) / A, if |C| <= mu A
    reverse  dpt/dpn = r = -mu sign(C) otherwise: friction cannot hold, the slip reverses

`settling_impulse` is a contact without rebound: (pt, pn) ends at u' = v' = 0 if friction can hold
it there; otherwise it slides with k = mu sign(pt of the stick), against its final slip.

Glossary: A, B, C inverse inertia felt at the contact, per unit mass (A B > C^2, B > mu |C|); u, v
before the impulse (m/s); mu friction; e restitution; k, r ratios pt / pn while slipping; ps, pc the
normal impulse at which the slip and the compression end.
Source: Wang and Mason, "Two-dimensional rigid-body collisions with frictional contacts",
Journal of Applied Mechanics 59, 1992.
"""

import math
from typing import NamedTuple

from physics.kernels.compiled import compiled

# The path that an impulse took. LATE: the slip stopped in the restitution, not in the compression.
NONE = 0
SLIDE = 1
STICK = 2
LATE_STICK = 3
REVERSE = 4
LATE_REVERSE = 5
PATHS = ("none", "slide", "stick", "late stick", "reverse", "late reverse")


class Contact(NamedTuple):
    """The quantities of a contact before its impulse, or a derivative of them."""

    A: float
    B: float
    C: float
    u: float
    v: float


class Impulse(NamedTuple):
    """An impulse and the path that led to it."""

    tangential: float
    normal: float
    path: int
    k: float  # ratio of the parts while the contact slips in its first direction
    r: float  # ratio of the parts after the slip has reversed
    restitution: float


@compiled
def sign(value: float) -> float:
    """Sign of a value, 0 for 0."""
    return 1.0 if value > 0.0 else -1.0 if value < 0.0 else 0.0


@compiled
def routh_impulse(contact: Contact, friction: float, restitution: float) -> Impulse:
    """Impulse of an impact, v < 0: Poisson's hypothesis on Routh's path."""
    A, B, C, u, v = contact
    s = sign(u)
    k, r = -friction * s, -friction * sign(C)
    holds = abs(C) <= friction * A
    ps = math.inf if s * C >= friction * A else -u / (C + k * A)
    late = -v <= (B + k * C) * ps  # the compression ends before the slip does
    if late:
        pc = -v / (B + k * C)
    elif holds:
        pc = (C * u - A * v) / (A * B - C * C)
    else:
        pc = ps - (v + (B + k * C) * ps) / (B + r * C)
    pn = (1.0 + restitution) * pc
    if pn <= ps:
        return Impulse(k * pn, pn, SLIDE, k, r, restitution)
    if holds:
        path = LATE_STICK if late else STICK
        return Impulse(-(u + C * pn) / A, pn, path, k, r, restitution)
    path = LATE_REVERSE if late else REVERSE
    return Impulse(k * ps + r * (pn - ps), pn, path, k, r, restitution)


@compiled
def settling_impulse(contact: Contact, friction: float) -> Impulse:
    """Impulse that ends the approach without rebound; none if the contact opens (v >= 0)."""
    A, B, C, u, v = contact
    if v >= 0.0:
        return Impulse(0.0, 0.0, NONE, 0.0, 0.0, 0.0)
    determinant = A * B - C * C
    pt = (C * v - B * u) / determinant
    pn = (C * u - A * v) / determinant
    if abs(pt) <= friction * pn:
        return Impulse(pt, pn, STICK, 0.0, 0.0, 0.0)
    k = friction * sign(pt)
    pn = -v / (B + k * C)
    return Impulse(k * pn, pn, SLIDE, k, 0.0, 0.0)


@compiled
def impulse_derivative(contact: Contact, impulse: Impulse, change: Contact) -> tuple[float, float]:
    """Derivative (dpt, dpn) of an impulse along a change of its contact, on the path it took."""
    A, B, C, u, v = contact
    dA, dB, dC, du, dv = change
    pt, pn, path, k, r, restitution = impulse
    if path == NONE:
        return 0.0, 0.0
    pc = pn / (1.0 + restitution)
    ps, dps = 0.0, 0.0
    if path >= REVERSE and k != 0.0:  # u = 0 reverses at once
        ps = -u / (C + k * A)
        dps = -(du + (dC + k * dA) * ps) / (C + k * A)
    if path == STICK:
        # (A B - C^2) pc = C u - A v
        dforce = dC * u + C * du - dA * v - A * dv
        dpc = (dforce - (dA * B + A * dB - 2.0 * C * dC) * pc) / (A * B - C * C)
    elif path == REVERSE:
        # v + (B + k C) ps + (B + r C) (pc - ps) = 0
        dslip = dv + (dB + k * dC) * ps + (B + k * C) * dps
        dpc = dps - (dslip + (dB + r * dC) * (pc - ps)) / (B + r * C)
    else:
        # v + (B + k C) pc = 0
        dpc = -(dv + (dB + k * dC) * pc) / (B + k * C)
    dpn = (1.0 + restitution) * dpc
    if path == SLIDE:
        return k * dpn, dpn
    if path <= LATE_STICK:
        # u + A pt + C pn = 0
        return -(du + dA * pt + dC * pn + C * dpn) / A, dpn
    return k * dps + r * (dpn - dps), dpn
