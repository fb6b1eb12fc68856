"""Hopper and Walker2d against MuJoCo's models of them and Gymnasium's tasks."""

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import gymnasium
import numpy as np
import pytest

import physics
from physics.environment import FloatArray
from physics.randomness import generator
from physics.robots.model.spheres import end_spheres
from physics.robots.task import RobotTask
from physics.tasks.hopper import Hopper
from physics.tasks.walker2d import Walker2d

mujoco: Any = pytest.importorskip("mujoco")

COUNT = 500
FILES = {"Hopper": "hopper.xml", "Walker2d": "walker2d_v5.xml"}


@pytest.fixture(params=[Hopper, Walker2d], ids=lambda task: task.name)
def environment(request: pytest.FixtureRequest) -> RobotTask:
    task: RobotTask = request.param()
    return task


@pytest.fixture
def peer(environment: RobotTask) -> tuple[Any, Any]:
    """The model that Gymnasium loads."""
    folder = Path(gymnasium.__file__).parent / "envs/mujoco/assets"
    model = mujoco.MjModel.from_xml_path(str(folder / FILES[environment.name]))
    return model, mujoco.MjData(model)


@pytest.fixture
def task(environment: RobotTask) -> Iterator[Any]:
    """Gymnasium's task."""
    made: Any = gymnasium.make(f"{environment.name}-v5")
    yield made.unwrapped
    made.close()


def states_and_actions(environment: RobotTask) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Poses of every pitch within and beyond the joints' range, at speed, under any action."""
    random, n = generator(0, "mujoco"), environment.state_size // 2
    q = random.uniform(-1.5, 1.5, (COUNT, n))
    q[:, 2] *= 3.0
    a = random.uniform(-1.3, 1.3, (COUNT, environment.action_size))
    return q, 5.0 * random.standard_normal((COUNT, n)), a


def test_mass_matrix(environment: RobotTask, peer: tuple[Any, Any]) -> None:
    model, data = peer
    q, _, _ = states_and_actions(environment)
    theirs = np.zeros((COUNT, model.nv, model.nv))
    for row in range(COUNT):
        data.qpos[:] = q[row]
        mujoco.mj_forward(model, data)
        mujoco.mj_fullM(model, data, theirs[row])
    np.testing.assert_allclose(environment.mass_matrix(q), theirs, rtol=0, atol=1e-8)


def test_smooth_forces(environment: RobotTask, peer: tuple[Any, Any]) -> None:
    model, data = peer
    q, v, a = states_and_actions(environment)
    theirs = np.zeros((COUNT, model.nv))
    for row in range(COUNT):
        data.qpos[:], data.qvel[:], data.ctrl[:] = q[row], v[row], a[row]
        mujoco.mj_forward(model, data)
        theirs[row] = data.qfrc_smooth
    np.testing.assert_allclose(environment.smooth_forces(q, v, a), theirs, rtol=0, atol=1e-8)


def test_free_flight_is_mujocos_but_for_the_implicit_dampers(
    environment: RobotTask, peer: tuple[Any, Any]
) -> None:
    """One step is four of `(M + h D) v' = M v + h (forces + D v)`, from MuJoCo's terms."""
    model, data = peer
    h, n = environment.substep_seconds, environment.state_size // 2
    assert h == model.opt.timestep
    states = environment.initial_states(range(50))
    states[:, 1] += 2.0
    states[:, 3:n] -= 0.5
    states[:, n:] *= 200.0
    actions = 0.2 * generator(0, "flight").uniform(-1.0, 1.0, (50, environment.action_size))
    damping = np.diag(model.dof_damping)
    assert (environment.contact_report(states, actions).mode == 0).all()
    for row, action in enumerate(actions):
        q, v = states[row, :n].copy(), states[row, n:].copy()
        for _ in range(environment.substeps):
            data.qpos[:], data.qvel[:], data.ctrl[:] = q, v, action
            mujoco.mj_forward(model, data)
            mass = np.zeros((n, n))
            mujoco.mj_fullM(model, data, mass)
            impulse = mass @ v + h * (data.qfrc_smooth + damping @ v)
            v = np.linalg.solve(mass + h * damping, impulse)
            q = q + h * v
        ours = environment.step(states[row : row + 1], actions[row : row + 1]).next_state[0]
        np.testing.assert_allclose(ours, np.concatenate([q, v]), rtol=0, atol=1e-8)


def test_stops_motors_and_friction_are_mujocos(
    environment: RobotTask, peer: tuple[Any, Any]
) -> None:
    model, _ = peer
    joints = [link.joint for link in environment.robot.links if link.joint is not None]
    np.testing.assert_allclose([(j.lower, j.upper) for j in joints], model.jnt_range[3:])
    np.testing.assert_allclose([j.gear for j in joints], model.actuator_gear[:, 0])
    floor = model.geom("floor").id
    for sphere, mu in zip(
        end_spheres(environment.robot), np.repeat(model.geom_friction[1:, 0], 2), strict=True
    ):
        own = sphere.capsule.friction or environment.robot.friction
        assert own == max(mu, model.geom_friction[floor, 0])


def test_capsules_are_where_mujocos_are(environment: RobotTask, peer: tuple[Any, Any]) -> None:
    """As drawn, in the order of the bodies, the end along +axis first."""
    model, data = peer
    n = environment.state_size // 2
    q, v, _ = states_and_actions(environment)
    for state in np.concatenate([q, v], axis=1)[:20]:
        data.qpos[:] = state[:n]
        mujoco.mj_forward(model, data)
        drawn: Any = environment.draw(state).shapes[-(model.ngeom - 1) :]
        for geom, shape in enumerate(drawn, start=1):
            reach = model.geom_size[geom, 1] * data.geom_xmat[geom].reshape(3, 3)[:, 2]
            for end, sign in ((shape.start, 1.0), (shape.end, -1.0)):
                centre = data.geom_xpos[geom] + sign * reach
                np.testing.assert_allclose(end, centre[[0, 2]], atol=1e-9)


def test_spheres_left_out_are_above_others(environment: RobotTask) -> None:
    """In any pose, the lowest point of all capsules is one of a sphere that may touch."""
    q, v, _ = states_and_actions(environment)
    heights = environment.sphere_centres(np.concatenate([q, v], axis=1))[..., 1]
    touching = (heights - environment.mechanism["radius"][0]).min(axis=1)
    for row, state in enumerate(np.concatenate([q, v], axis=1)):
        capsules: Any = environment.draw(state).shapes[
            -sum(len(x.capsules) for x in environment.robot.links) :
        ]
        lowest = min(min(c.start[1], c.end[1]) - c.radius for c in capsules)
        assert touching[row] == pytest.approx(lowest, abs=1e-9)


def test_rewards_and_ends_are_gymnasiums(environment: RobotTask, task: Any) -> None:
    """The same of the same state, action and next state."""
    n = environment.state_size // 2
    states, actions = environment.sample(generator(0, "rewards"), 400)
    after = environment.step(states, actions)
    assert 0.1 < after.terminated.mean() < 0.9
    assert environment.step_seconds == pytest.approx(task.dt)
    for row in range(400):
        task.set_state(after.next_state[row, :n], after.next_state[row, n:])
        assert task.is_healthy == (not after.terminated[row])
        speed = (after.next_state[row, 0] - states[row, 0]) / task.dt
        reward, _ = task._get_rew(speed, np.clip(actions[row], -1.0, 1.0))
        assert after.reward[row] == pytest.approx(reward, rel=1e-12, abs=1e-12)


def test_starts_are_gymnasiums_within_the_stops(environment: RobotTask, task: Any) -> None:
    n = environment.state_size // 2
    starts = environment.initial_states(range(2000))
    stand = np.concatenate([task.init_qpos, task.init_qvel])
    assert np.abs(starts - stand).max() < 5e-3
    knees = [i for i in range(3, n) if i not in (5, 8)]
    free = np.delete(starts - stand, knees, axis=1)
    assert free.std() == pytest.approx(5e-3 / 3**0.5, rel=0.02)
    assert (starts[:, knees] == 0.0).mean() == pytest.approx(0.5, abs=0.03)
    assert starts[:, knees].max() <= 0.0
    assert not environment.step(starts, np.zeros((2000, environment.action_size))).terminated.any()
    assert environment.horizon == gymnasium.spec(f"{environment.name}-v5").max_episode_steps


def test_it_is_in_the_catalogue(environment: RobotTask) -> None:
    assert type(physics.make(environment.name)) is type(environment)
