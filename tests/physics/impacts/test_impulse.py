"""Contact impulses: Routh's path followed in small steps, and the laws of impact."""

import numpy as np
import pytest

from physics.impacts.impulse import (
    LATE_REVERSE,
    LATE_STICK,
    NONE,
    PATHS,
    REVERSE,
    SLIDE,
    STICK,
    Contact,
    Impulse,
    impulse_derivative,
    routh_impulse,
    settling_impulse,
)
from physics.randomness import generator

COUNT = 3000


def contacts(purpose: str, approach: tuple[float, float] = (-5.0, -0.05)) -> list[Contact]:
    """Contacts of points all around a square of unit mass and side."""
    random = generator(0, purpose)
    angle, reach = random.uniform(0, 2 * np.pi, COUNT), random.uniform(0.3, 0.71, COUNT)
    rx, ry = reach * np.cos(angle), reach * np.sin(angle)
    numbers = [
        1 + 6 * ry**2,
        1 + 6 * rx**2,
        -6 * rx * ry,
        random.normal(0, 2, COUNT),
        random.uniform(*approach, COUNT),
    ]
    return [Contact(*row) for row in np.transpose(numbers).tolist()]


def after(contact: Contact, impulse: Impulse) -> tuple[float, float]:
    """Slip and rate after an impulse."""
    A, B, C, u, v = contact
    pt, pn = impulse.tangential, impulse.normal
    return u + A * pt + C * pn, v + C * pt + B * pn


def work(contact: Contact, impulse: Impulse) -> float:
    """Kinetic energy gained: each part of the impulse times the mean velocity along it."""
    u, v = after(contact, impulse)
    return impulse.tangential * (contact.u + u) / 2 + impulse.normal * (contact.v + v) / 2


@pytest.mark.parametrize(("friction", "restitution"), [(0.5, 0.6), (0.2, 1.0), (0.9, 0.3)])
def test_an_impact_follows_rouths_path(friction: float, restitution: float) -> None:
    """Coulomb's law applied over and over to a normal impulse that grows in 40,000 small steps."""
    some = contacts("routh")[:400]
    A, B, C, u, v = (np.array(column) for column in zip(*some, strict=True))
    dpn = -v / 15_000.0
    pt, pn, compression = np.zeros(400), np.zeros(400), np.full(400, np.nan)
    for _ in range(40_000):
        # The friction that would stop the slip within this step, if the cone allows so much.
        hold = -(u + C * dpn) / (A * dpn)
        dpt = dpn * np.clip(hold, -friction, friction)
        going = np.isnan(compression) | (pn < (1 + restitution) * compression)
        pt, pn = pt + going * dpt, pn + going * dpn
        u, v = u + going * (A * dpt + C * dpn), v + going * (C * dpt + B * dpn)
        compression = np.where(np.isnan(compression) & (v >= 0), pn, compression)
    assert not going.any()
    for row, contact in enumerate(some):
        impulse = routh_impulse(contact, friction, restitution)
        scale = 4e-4 * -contact.v
        assert impulse.normal == pytest.approx(pn[row], abs=scale)
        assert impulse.tangential == pytest.approx(pt[row], abs=scale)


def test_an_impact_keeps_the_laws() -> None:
    seen = set()
    for contact in contacts("laws"):
        impulse = routh_impulse(contact, 0.5, 0.6)
        u, v = after(contact, impulse)
        assert abs(impulse.tangential) <= 0.5 * impulse.normal * (1 + 1e-12)
        assert work(contact, impulse) <= 1e-12
        assert v > 0
        if impulse.path in (STICK, LATE_STICK):
            assert abs(u) < 1e-12
        elif impulse.path == SLIDE:
            assert u * contact.u >= -1e-12
        else:
            assert u * contact.u < 0
        seen.add(impulse.path)
    assert seen == {SLIDE, STICK, LATE_STICK, REVERSE, LATE_REVERSE}


def test_where_poisson_and_newton_agree_and_where_not() -> None:
    differing = 0
    for contact in contacts("poisson"):
        straight = contact._replace(C=0.0)
        for same in (routh_impulse(straight, 0.5, 0.6), routh_impulse(contact, 0.0, 0.6)):
            centred = straight if same.k != 0.0 else contact
            assert after(centred, same)[1] == pytest.approx(-0.6 * contact.v, abs=1e-12)
        rebound = after(contact, routh_impulse(contact, 0.5, 0.6))[1]
        differing += abs(rebound + 0.6 * contact.v) > 0.01
    assert differing > COUNT // 20


def test_without_restitution_the_rate_ends_at_zero() -> None:
    for contact in contacts("plastic"):
        assert abs(after(contact, routh_impulse(contact, 0.5, 0.0))[1]) < 1e-12


def test_a_settling_impulse_stops_the_approach() -> None:
    seen = set()
    for contact in contacts("settling", approach=(-0.3, 0.1)):
        slow = contact._replace(u=0.1 * contact.u)
        impulse = settling_impulse(slow, 0.5)
        u, v = after(slow, impulse)
        assert abs(impulse.tangential) <= 0.5 * impulse.normal * (1 + 1e-12)
        assert work(slow, impulse) <= 1e-12
        if impulse.path == NONE:
            assert v == slow.v >= 0
        else:
            assert abs(v) < 1e-12
            assert u * impulse.tangential <= 1e-12
        if impulse.path == STICK:
            assert abs(u) < 1e-12
        seen.add(impulse.path)
    assert seen == {NONE, SLIDE, STICK}


@pytest.mark.parametrize("restitution", [None, 0.6])
def test_the_derivative_is_that_of_the_path(restitution: float | None) -> None:
    def impulse_of(contact: Contact) -> Impulse:
        if restitution is None:
            return settling_impulse(contact, 0.5)
        return routh_impulse(contact, 0.5, restitution)

    random = generator(0, "direction")
    compared = dict.fromkeys(range(len(PATHS)), 0)
    for contact in contacts("derivative", approach=(-8.0, 0.0)):
        change = Contact(*random.normal(0, 1, 5).tolist())
        impulse = impulse_of(contact)
        h = 1e-5
        forth, back = (
            impulse_of(Contact(*(c + sign * h * d for c, d in zip(contact, change, strict=True))))
            for sign in (1, -1)
        )
        if not forth.path == back.path == impulse.path or forth.k != back.k:
            continue
        dpt, dpn = impulse_derivative(contact, impulse, change)
        scale = max(1.0, abs(dpt), abs(dpn))
        assert dpt == pytest.approx(
            (forth.tangential - back.tangential) / (2 * h), abs=2e-6 * scale
        )
        assert dpn == pytest.approx((forth.normal - back.normal) / (2 * h), abs=2e-6 * scale)
        compared[impulse.path] += 1
    expected = (SLIDE, STICK) if restitution is None else range(SLIDE, LATE_REVERSE + 1)
    assert all(compared[path] >= 20 for path in expected)


def test_sticking_from_no_slip_is_smooth() -> None:
    contact = Contact(4.0, 1.2, -0.4, 0.0, -1.0)
    impulse = routh_impulse(contact, 0.5, 0.6)
    assert impulse.path == STICK
    slope, _ = impulse_derivative(contact, impulse, Contact(0.0, 0.0, 0.0, 1.0, 0.0))
    for h in (1e-6, -1e-6):
        moved = routh_impulse(contact._replace(u=h), 0.5, 0.6)
        assert (moved.tangential - impulse.tangential) / h == pytest.approx(slope, rel=1e-8)
