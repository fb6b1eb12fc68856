"""The rolling die again, slowly: its rules in plain Python, one die at a time.

Shares nothing with the kernels but the numbers of the task: corners by angle, moments by dense
sampling of gap and rate with Brent's method between, impulses by following Routh's path.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import brentq

G, MU, E, SETTLING_SPEED, REST_ENERGY, STEP = 9.81, 0.5, 0.6, 0.05, 0.01, 0.02
SAMPLES = 200


@dataclass(frozen=True)
class Die:
    """A die and the angular acceleration of its step."""

    x: float
    y: float
    theta: float
    vx: float
    vy: float
    omega: float
    alpha: float

    @property
    def energy(self) -> float:
        """Excess energy."""
        return self.vy**2 / 2 + self.omega**2 / 12 + G * (self.y - 0.5)

    def after(self, t: float) -> Die:
        """Flight."""
        return replace(
            self,
            x=self.x + self.vx * t,
            y=self.y + self.vy * t - G * t**2 / 2,
            theta=self.theta + self.omega * t + self.alpha * t**2 / 2,
            vy=self.vy - G * t,
            omega=self.omega + self.alpha * t,
        )

    def lever(self, i: int) -> tuple[float, float]:
        """Corner i from the centre."""
        angle = self.theta + math.pi / 4 + i * math.pi / 2
        return math.sqrt(0.5) * math.cos(angle), math.sqrt(0.5) * math.sin(angle)

    def gap(self, i: int) -> float:
        """Height of corner i."""
        return self.y + self.lever(i)[1]

    def rate(self, i: int) -> float:
        """Rate of the gap of corner i."""
        return self.vy + self.omega * self.lever(i)[0]

    def slip(self, i: int) -> float:
        """Speed of corner i along the ground."""
        return self.vx - self.omega * self.lever(i)[1]

    def pushed(self, i: int, pt: float, pn: float) -> Die:
        """The die after an impulse at corner i."""
        rx, ry = self.lever(i)
        omega = self.omega + 6 * (rx * pn - ry * pt)
        return replace(self, vx=self.vx + pt, vy=self.vy + pn, omega=omega)


def step(state: Sequence[float], action: float) -> NDArray[np.float64]:
    """One step of 0.02 s by rules 1 to 6."""
    x, y, theta, vx, vy, omega = (float(number) for number in state)
    die = Die(x, y, theta, vx, vy, omega, alpha=6 * max(-1.0, min(1.0, action)))
    die = _moved(die, STEP)
    return np.array([die.x, die.y, die.theta, die.vx, die.vy, die.omega])


def _moved(die: Die, tau: float) -> Die:
    if die.energy < REST_ENERGY:
        return _lying(die, tau)
    settled = [
        (die.gap(i), i)
        for i in range(4)
        if die.rate(i) ** 2 + 2 * G * die.gap(i) < SETTLING_SPEED**2
    ]
    if settled:
        die, tau, ended = _settled(die, min(settled)[1], tau)
        if ended:
            return die
    for _ in range(64):
        touches = [(moment, i) for i in range(4) if (moment := _touch(die, i, tau)) is not None]
        if not touches:
            return die.after(tau)
        first = min(touches)[0]
        moment, i = next(touch for touch in touches if touch[0] - first < 1e-12)
        die, tau = die.after(moment), tau - moment
        if -die.rate(i) >= SETTLING_SPEED:
            die = die.pushed(i, *_impact(die, i))
        elif die.energy < REST_ENERGY:
            return _lying(die, tau)
        else:
            die, tau, ended = _settled(die, i, tau)
            if ended:
                return die
    return die


def _lying(die: Die, tau: float) -> Die:
    f = G * MU
    if abs(die.vx) <= f * tau:
        x, vx = die.x + die.vx * abs(die.vx) / (2 * f), 0.0
    else:
        x = die.x + die.vx * tau - math.copysign(f * tau**2 / 2, die.vx)
        vx = die.vx - math.copysign(f * tau, die.vx)
    theta = round(die.theta / (math.pi / 2)) * (math.pi / 2)
    return replace(die, x=x, y=0.5, theta=theta, vx=vx, vy=0.0, omega=0.0)


def _touch(die: Die, i: int, tau: float) -> float | None:
    """First moment in [0, tau] at which corner i has gap <= 0 and v < 0."""
    if die.gap(i) <= 0 and die.rate(i) < 0:
        return 0.0
    if min(die.y, die.after(tau).y) > 0.8:
        return None

    def gap(t: float) -> float:
        return die.after(t).gap(i)

    def rate(t: float) -> float:
        return die.after(t).rate(i)

    times = np.linspace(0, tau, SAMPLES)
    angles = (
        die.theta + die.omega * times + die.alpha * times**2 / 2 + math.pi / 4 + i * math.pi / 2
    )
    gaps = die.y + die.vy * times - G * times**2 / 2 + math.sqrt(0.5) * np.sin(angles)
    rates = die.vy - G * times + (die.omega + die.alpha * times) * math.sqrt(0.5) * np.cos(angles)
    for t0, t1, g0, g1, v0, v1 in zip(
        times, times[1:], gaps, gaps[1:], rates, rates[1:], strict=False
    ):
        if min(g0, g1) > 1e-4 and g0 + v0 * (t1 - t0) > 1e-4:
            continue  # one interval, 1e-4 s, cannot bend a path by so much
        if g0 > 0 >= g1:
            return _root(gap, t0, t1)
        if g0 > 0 and v0 < 0 <= v1:  # a dip between two samples above the ground
            bottom = _root(rate, t0, t1)
            if gap(bottom) <= 0:
                return _root(gap, t0, bottom)
        if g0 <= 0 and g1 <= 0 and v1 < 0:  # it was leaving, and is back
            top = _root(rate, t0, t1) if v0 > 0 else t0
            return _root(gap, top, t1) if gap(top) > 0 else top
    return None


def _root(function: Callable[[float], float], low: float, high: float) -> float:
    if function(low) * function(high) > 0:  # both rounded onto the ground
        return high
    return float(brentq(function, low, high, xtol=1e-16, rtol=1e-15))


def _impact(die: Die, i: int) -> tuple[float, float]:
    """Routh's path: pt as a function of pn."""
    rx, ry = die.lever(i)
    A, B, C = 1 + 6 * ry**2, 1 + 6 * rx**2, -6 * rx * ry
    u, v = die.slip(i), die.rate(i)
    s = float(np.sign(u))
    never = s * C >= MU * A
    ps = math.inf if never else abs(u) / (MU * A - s * C)
    after = -C / A if abs(C) <= MU * A else -MU * float(np.sign(C))

    def tangential(pn: float) -> float:
        return -MU * s * min(pn, ps) + after * max(0.0, pn - ps)

    pc = float(
        brentq(lambda pn: v + C * tangential(pn) + B * pn, 0, -100 * v, xtol=1e-16, rtol=1e-15)
    )
    return tangential(1.6 * pc), 1.6 * pc


def _settled(die: Die, i: int, tau: float) -> tuple[Die, float, bool]:
    """Settled contact of corner i: the die, the time left, whether the step ends."""
    rx, ry = die.lever(i)
    A, B, C = 1 + 6 * ry**2, 1 + 6 * rx**2, -6 * rx * ry

    def moved(h: float) -> Die:
        forced = replace(die, vy=die.vy - G * h, omega=die.omega + die.alpha * h)
        u, v = forced.slip(i), forced.rate(i)
        if v < 0:
            pt, pn = np.linalg.solve([[A, C], [C, B]], [-u, -v])
            if abs(pt) > MU * pn:
                k = MU * np.sign(pt)
                pn = -v / (B + k * C)
                pt = k * pn
            forced = forced.pushed(i, float(pt), float(pn))
        return replace(
            forced,
            x=die.x + h * forced.vx,
            y=die.y + h * forced.vy,
            theta=die.theta + h * forced.omega,
        )

    for j in range(4):
        if j != i and moved(tau).gap(j) < 0:
            low, high = 0.0, tau
            while low < (middle := (low + high) / 2) < high:
                low, high = (middle, high) if moved(middle).gap(j) >= 0 else (low, middle)
            return moved(low), tau - low, False
    return moved(tau), 0.0, True
