"""HalfCheetah's geometry, inertia and forces against MuJoCo's own, feet welded to the shins."""

from collections.abc import Iterator
from contextlib import chdir
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

import gymnasium
import numpy as np
import pytest

from physics.environment import FloatArray
from physics.randomness import generator
from physics.tasks.half_cheetah import HalfCheetah

mujoco: Any = pytest.importorskip("mujoco")

COUNT = 500


@pytest.fixture(scope="module", autouse=True)
def _no_log(tmp_path_factory: pytest.TempPathFactory) -> Iterator[None]:
    """MuJoCo writes what it warns of into the current folder: nothing, here."""
    folder = tmp_path_factory.mktemp("mujoco")
    with chdir(folder):
        yield
    logs = [file.read_text() for file in folder.iterdir()]
    assert not logs


@pytest.fixture(scope="module")
def peer() -> tuple[Any, Any]:
    """Gymnasium's half_cheetah.xml without the joints and motors of the feet."""
    path = Path(gymnasium.__file__).parent / "envs/mujoco/assets/half_cheetah.xml"
    tree = ElementTree.parse(path)  # noqa: S314 (a file of an installed package)
    for parent in list(tree.iter()):
        for child in list(parent):
            if child.tag in ("joint", "motor") and (child.get("joint") or child.get("name")) in (
                "bfoot",
                "ffoot",
            ):
                parent.remove(child)
    # MuJoCo 4 deprecates this attribute and logs so; the call after loading does the same.
    total_mass = float(tree.getroot().find("compiler").attrib.pop("settotalmass"))  # type: ignore[union-attr]
    model = mujoco.MjModel.from_xml_string(ElementTree.tostring(tree.getroot(), encoding="unicode"))
    mujoco.mj_setTotalmass(model, total_mass)
    data = mujoco.MjData(model)
    mujoco.mj_setConst(model, data)
    return model, data


def states_and_actions() -> tuple[FloatArray, FloatArray, FloatArray]:
    """Poses of every pitch within and beyond the joints' range, at speed, under any action."""
    random = generator(0, "mujoco")
    q = random.uniform(-1.5, 1.5, (COUNT, 7))
    q[:, 2] *= 3.0
    return q, 5.0 * random.standard_normal((COUNT, 7)), random.uniform(-1.3, 1.3, (COUNT, 4))


def test_mass_matrix(peer: tuple[Any, Any]) -> None:
    model, data = peer
    q, _, _ = states_and_actions()
    theirs = np.zeros((COUNT, 7, 7))
    for row in range(COUNT):
        data.qpos[:] = q[row]
        mujoco.mj_forward(model, data)
        mujoco.mj_fullM(model, data, theirs[row])
    np.testing.assert_allclose(HalfCheetah().mass_matrix(q), theirs, rtol=0, atol=1e-8)


def test_smooth_forces(peer: tuple[Any, Any]) -> None:
    model, data = peer
    q, v, a = states_and_actions()
    theirs = np.zeros((COUNT, 7))
    for row in range(COUNT):
        data.qpos[:], data.qvel[:], data.ctrl[:] = q[row], v[row], a[row]
        mujoco.mj_forward(model, data)
        theirs[row] = data.qfrc_smooth
    np.testing.assert_allclose(HalfCheetah().smooth_forces(q, v, a), theirs, rtol=0, atol=1e-8)


def test_free_flight_is_mujocos_but_for_the_implicit_springs(peer: tuple[Any, Any]) -> None:
    """One step is five of `(M + h D + h^2 K) v' = M v + h (forces + D v)`, from MuJoCo's terms."""
    model, data = peer
    environment, h = HalfCheetah(), 0.01
    states = environment.initial_states(range(50))
    states[:, 1] += 2.0
    states[:, 3:7] *= 3.0
    states[:, 7:] *= 10.0
    actions = 0.2 * generator(0, "flight").uniform(-1.0, 1.0, (50, 4))
    damping, stiffness = np.diag(model.dof_damping), np.diag(model.jnt_stiffness)
    for row, action in enumerate(actions):
        q, v = states[row, :7].copy(), states[row, 7:].copy()
        for _ in range(5):
            data.qpos[:], data.qvel[:], data.ctrl[:] = q, v, action
            mujoco.mj_forward(model, data)
            mass = np.zeros((7, 7))
            mujoco.mj_fullM(model, data, mass)
            inertia = mass + h * damping + h**2 * stiffness
            impulse = mass @ v + h * (data.qfrc_smooth + damping @ v)
            v = np.linalg.solve(inertia, impulse)
            q = q + h * v
        ours = environment.step(states[row : row + 1], actions[row : row + 1]).next_state[0]
        np.testing.assert_allclose(ours, np.concatenate([q, v]), rtol=0, atol=1e-8)


def test_the_spheres_are_the_ends_of_mujocos_capsules(peer: tuple[Any, Any]) -> None:
    """In the order of the bodies, the end along +axis first; MuJoCo's torso points backwards."""
    model, data = peer
    environment = HalfCheetah()
    states = environment.initial_states(range(20))
    names = ["torso", "head", "bthigh", "bshin", "bfoot", "fthigh", "fshin", "ffoot"]
    drawn = np.array(
        [
            [(shape.start, shape.end) for shape in environment.draw(state).shapes[-8:]]  # type: ignore[union-attr]
            for state in states
        ]
    )
    for row, state in enumerate(states):
        data.qpos[:] = state[:7]
        mujoco.mj_forward(model, data)
        for index, name in enumerate(names):
            geom = model.geom(name).id
            axis = data.geom_xmat[geom].reshape(3, 3)[:, 2] * (-1.0 if name == "torso" else 1.0)
            for end, sign in enumerate((1.0, -1.0)):
                centre = data.geom_xpos[geom] + sign * model.geom_size[geom, 1] * axis
                np.testing.assert_allclose(drawn[row, index, end], centre[[0, 2]], atol=1e-12)
    report = environment.contact_report(states, np.zeros((20, 4)))
    after = environment.step(states, np.zeros((20, 4))).next_state
    ends = np.array(
        [
            [(shape.start, shape.end) for shape in environment.draw(state).shapes[-8:]]  # type: ignore[union-attr]
            for state in after
        ]
    )
    np.testing.assert_allclose(
        report.gap[:, -1], ends.reshape(20, 16, 2)[:, :, 1] - 0.046, rtol=0, atol=1e-12
    )
