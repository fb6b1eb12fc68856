"""HalfCheetah once more, slowly: its five equations in relative angles, from MuJoCo's file.

Shares nothing with the simulator but the smooth part (M and the smooth forces, which another test
holds against MuJoCo): spheres from the published geometry, Jacobians by complex steps, and the
complementarity problem solved by trying active sets.
"""

from itertools import product

import numpy as np
import numpy.typing as npt

from physics.environment import FloatArray
from physics.tasks.half_cheetah import HalfCheetah

H, MU, RADIUS = 0.01, 0.4, 0.046
DAMPING = np.diag([0, 0, 0, 6, 4.5, 4.5, 3])
STIFFNESS = np.diag([0.0, 0, 0, 240, 180, 180, 120])
LOWER = np.array([-0.52, -0.785, -1.0, -1.2])
UPPER = np.array([1.05, 0.785, 0.7, 0.87])
# body, centre in its frame, half length, angle of the axis
CAPSULES = [
    ("torso", (0.0, 0.0), 0.5, np.pi / 2),
    ("torso", (0.6, 0.1), 0.15, 0.87),
    ("bthigh", (0.1, -0.13), 0.145, -3.8),
    ("bshin", (-0.14, -0.07), 0.15, -2.03),
    ("bfoot", (0.03, -0.097), 0.094, -0.27),
    ("fthigh", (-0.07, -0.12), 0.133, 0.52),
    ("fshin", (0.065, -0.09), 0.106, -0.6),
    ("ffoot", (0.045, -0.07), 0.07, -0.6),
]
# the joints that turn each sphere's body
TURNS = {
    "torso": [2],
    "bthigh": [2, 3],
    "bshin": [2, 3, 4],
    "bfoot": [2, 3, 4],
    "fthigh": [2, 5],
    "fshin": [2, 5, 6],
    "ffoot": [2, 5, 6],
}
BODIES = {
    "bthigh": ("torso", (-0.5, 0.0)),
    "bshin": ("bthigh", (0.16, -0.25)),
    "bfoot": ("bshin", (-0.28, -0.14)),
    "fthigh": ("torso", (0.5, 0.0)),
    "fshin": ("fthigh", (-0.14, -0.24)),
    "ffoot": ("fshin", (0.13, -0.18)),
}

Complex = npt.NDArray[np.complex128]
Vector = tuple[float, float]


def turned(angle: complex, vector: Vector) -> Complex:
    c, s = np.cos(angle), np.sin(angle)
    return np.array([c * vector[0] + s * vector[1], c * vector[1] - s * vector[0]])


def spheres(q: Complex) -> Complex:
    """Centres [16, 2]."""
    origin = {"torso": np.array([q[0], q[1] + 0.7])}
    for body, (parent, place) in BODIES.items():
        origin[body] = origin[parent] + turned(q[TURNS[parent]].sum(), place)
    centres = []
    for body, place, half, angle in CAPSULES:
        turn = q[TURNS[body]].sum()
        axis = turned(turn, (np.sin(angle), np.cos(angle)))
        middle = origin[body] + turned(turn, place)
        centres += [middle + half * axis, middle - half * axis]
    return np.array(centres)


def constraint_rows(q: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Distances [24], normal rows [24, 7], tangential rows [16, 7]."""
    step = 1e-30
    J = np.stack([spheres(q + 1j * step * np.eye(7)[i]).imag / step for i in range(7)], axis=-1)
    tangential = J[:, 0]
    for capsule, (body, *_) in enumerate(CAPSULES):
        tangential[2 * capsule : 2 * capsule + 2, TURNS[body]] -= RADIUS
    stops = np.eye(7)[3:]
    rooms = np.concatenate([q[3:] - LOWER, UPPER - q[3:]])
    distance = np.concatenate([spheres(q.astype(complex)).real[:, 1] - RADIUS, rooms])
    return distance, np.concatenate([J[:, 1], stops, -stops]), tangential


def velocities(
    inverse: FloatArray, free: FloatArray, q: FloatArray, candidates: list[int]
) -> list[FloatArray]:
    """All v' that solve the complementarity problem of the candidates, each with its active set."""
    distance, normal, tangential = constraint_rows(q)
    found = []
    modes = [
        ("open", "stick", "ahead", "back") if k < 16 else ("open", "stick") for k in candidates
    ]
    for chosen in product(*modes):
        rows, directions, right = [], [], []
        for k, mode in zip(candidates, chosen, strict=True):
            if mode != "open":
                slope = {"stick": 0.0, "ahead": -MU, "back": MU}[mode]
                rows.append(normal[k])
                directions.append(normal[k] + slope * tangential[k] if k < 16 else normal[k])
                right.append(-distance[k] / H)
            if mode == "stick" and k < 16:
                rows.append(tangential[k])
                directions.append(tangential[k])
                right.append(0.0)
        v = free
        p = np.zeros(0)
        if rows:
            R, C = np.array(rows), np.array(directions)
            p = np.linalg.lstsq(R @ inverse @ C.T, np.array(right) - R @ free, rcond=1e-11)[0]
            v = free + inverse @ C.T @ p
        if _is_solution(v, p, candidates, chosen, distance, normal, tangential):
            found.append(v)
    return found


def _is_solution(
    v: FloatArray,
    p: FloatArray,
    candidates: list[int],
    chosen: tuple[str, ...],
    distance: FloatArray,
    normal: FloatArray,
    tangential: FloatArray,
) -> bool:
    impulses = iter(p)
    for k, mode in zip(candidates, chosen, strict=True):
        approach = normal[k] @ v + distance[k] / H
        if mode == "open":
            if approach < -1e-10:
                return False
            continue
        pn = next(impulses)
        if abs(approach) > 1e-10 or pn < -1e-10:
            return False
        if k < 16:
            slip = tangential[k] @ v
            if mode == "stick" and (abs(next(impulses)) > MU * pn + 1e-10 or abs(slip) > 1e-10):
                return False
            if slip * {"stick": 0.0, "ahead": 1.0, "back": -1.0}[mode] < -1e-10:
                return False
    return True


def substep(environment: HalfCheetah, s: FloatArray, a: FloatArray) -> tuple[FloatArray, int, int]:
    """The state after h, how many active sets solve it, how many constraints were candidates.

    Raises:
        AssertionError: if no active set solves it, or two do with different velocities.
    """
    q, v = s[:7], s[7:]
    M = environment.mass_matrix(q[None])[0]
    forces = environment.smooth_forces(q[None], v[None], a[None])[0] + DAMPING @ v
    inverse = np.linalg.inv(M + H * DAMPING + H**2 * STIFFNESS)
    free = inverse @ (M @ v + H * forces)
    distance, normal, _ = constraint_rows(q)
    candidates: list[int] = []
    next_v, solutions = free, 1
    while True:
        violated = np.flatnonzero(normal @ next_v + distance / H < -1e-10)
        new = [int(k) for k in violated if k not in candidates]
        if not new:
            return np.concatenate([q + H * next_v, next_v]), solutions, len(candidates)
        candidates += new
        found = velocities(inverse, free, q, candidates)
        assert found, f"no active set of {candidates} solves {s.tolist()}"
        spread = np.ptp(found, axis=0).max()
        assert spread < 1e-8, f"{len(found)} solutions, {spread} apart, at {s.tolist()}"
        next_v, solutions = found[0], len(found)
