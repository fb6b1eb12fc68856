"""The articulated engine against mechanics' own definitions, by differences of M alone."""

import numpy as np
import pytest

from physics.environment import FloatArray
from physics.randomness import generator
from physics.tasks.half_cheetah import HalfCheetah

ENVIRONMENT = HalfCheetah()
COUNT, WIDTH = 50, 1e-5


@pytest.fixture
def coordinates() -> tuple[FloatArray, FloatArray]:
    random = generator(0, "articulated")
    return random.uniform(-3.0, 3.0, (COUNT, 7)), 3.0 * random.normal(size=(COUNT, 7))


def kinetic(q: FloatArray, v: FloatArray) -> FloatArray:
    energy: FloatArray = np.einsum("bi,bij,bj->b", v, ENVIRONMENT.mass_matrix(q), v) / 2.0
    return energy


def test_the_mass_matrix_is_symmetric_and_positive(
    coordinates: tuple[FloatArray, FloatArray],
) -> None:
    matrices = ENVIRONMENT.mass_matrix(coordinates[0])
    np.testing.assert_allclose(matrices, matrices.transpose(0, 2, 1), atol=1e-12)
    assert np.linalg.eigvalsh(matrices).min() > 0.05
    np.testing.assert_allclose(matrices[:, 0, 0], 14.0)


def test_velocity_forces_are_lagranges(coordinates: tuple[FloatArray, FloatArray]) -> None:
    """`c(q, v) - c(q, 0) = dM/dt v - d(v M v / 2)/dq`, with dampers taken out."""
    q, v = coordinates
    along = (ENVIRONMENT.mass_matrix(q + WIDTH * v) - ENVIRONMENT.mass_matrix(q - WIDTH * v)) / (
        2 * WIDTH
    )
    slope = np.empty_like(q)
    for i in range(7):
        step = WIDTH * np.eye(7)[i]
        slope[:, i] = (kinetic(q + step, v) - kinetic(q - step, v)) / (2 * WIDTH)
    expected = np.einsum("bij,bj->bi", along, v) - slope
    still, actions = np.zeros_like(v), np.zeros((COUNT, 4))
    difference = ENVIRONMENT.smooth_forces(q, still, actions) - ENVIRONMENT.smooth_forces(
        q, v, actions
    )
    dampers = np.array([0, 0, 0, 6, 4.5, 4.5, 3]) * v
    np.testing.assert_allclose(difference - dampers, expected, rtol=0, atol=1e-6)


def test_motors_act_on_their_joints_and_are_clipped(
    coordinates: tuple[FloatArray, FloatArray],
) -> None:
    q, v = coordinates
    actions = generator(1, "articulated").uniform(-2.0, 2.0, (COUNT, 4))
    driven = ENVIRONMENT.smooth_forces(q, v, actions)
    gained = driven - ENVIRONMENT.smooth_forces(q, v, np.zeros((COUNT, 4)))
    np.testing.assert_allclose(gained[:, :3], 0.0, atol=1e-12)
    gears = np.array([120.0, 90.0, 120.0, 60.0])
    np.testing.assert_allclose(gained[:, 3:], gears * np.clip(actions, -1, 1), atol=1e-9)


def test_weight_hangs_on_the_centre_of_mass(coordinates: tuple[FloatArray, FloatArray]) -> None:
    """Turning the whole body by the pitch moves it around the root: torque = -g d(m height)/d q."""
    q, _ = coordinates
    still = np.zeros((COUNT, 7))
    forces = ENVIRONMENT.smooth_forces(q, still, np.zeros((COUNT, 4)))
    matrices = ENVIRONMENT.mass_matrix(q)
    np.testing.assert_allclose(forces[:, 0], 0.0, atol=1e-12)
    np.testing.assert_allclose(forces[:, 1], -14.0 * 9.81)
    # M[z, pitch] is the first moment about the root
    np.testing.assert_allclose(forces[:, 2], -9.81 * matrices[:, 1, 2], atol=1e-9)
