"""The tasks in Gymnasium's registry: there in any order of imports, and free until used."""

import copy
import dataclasses
import os
import pickle
import subprocess
import sys
from pathlib import Path

import gymnasium
import pytest
from gymnasium.envs.registration import EnvSpec

import physics
from physics.gym.registration import TaskSpec, identifier, register
from physics.tasks.pendulum import Pendulum

ROOT = Path(__file__).parents[3]


def fresh(code: str, *paths: Path) -> str:
    """What a new interpreter prints."""
    answer = subprocess.run(
        [sys.executable, "-W", "error", "-c", code],
        capture_output=True,
        text=True,
        check=False,
        cwd=ROOT,
        env={**os.environ, "PYTHONPATH": os.pathsep.join(map(str, [*paths, ROOT]))},
    )
    assert answer.returncode == 0, answer.stderr
    return answer.stdout.strip()


@pytest.fixture
def installed(tmp_path: Path) -> Path:
    """A folder as `pip install` leaves it, with good and bad tasks of someone else's."""
    (tmp_path / "others_tasks.py").write_text(
        "from physics.tasks.pendulum import Pendulum\n"
        "class Slow(Pendulum):\n    name = 'Slow'\n    horizon = 77\n"
    )
    (tmp_path / "broken_task.py").write_text("raise RuntimeError('broken')\n")
    metadata = tmp_path / "others_tasks-1.0.dist-info"
    metadata.mkdir()
    (metadata / "METADATA").write_text("Metadata-Version: 2.1\nName: others-tasks\nVersion: 1.0\n")
    (metadata / "entry_points.txt").write_text(
        "[d3pg.environments]\nSlow = others_tasks:Slow\nBroken = broken_task:Broken\n"
    )
    return tmp_path


@pytest.mark.parametrize(
    "imports",
    [
        "import physics, gymnasium",
        "import gymnasium, physics",
        "import gymnasium.envs.registration; import physics.drawing",
        "import physics.tasks.pendulum; from gymnasium import make",
        "import importlib.util, physics; importlib.util.find_spec('gymnasium')",
    ],
)
def test_any_order_of_imports(imports: str) -> None:
    made = "import gymnasium; print(gymnasium.make('d3pg/MassPoint-v0').spec.id)"
    assert fresh(f"{imports}; {made}") == "d3pg/MassPoint-v0"


def test_the_prefix_imports_for_you() -> None:
    code = "import gymnasium; print(gymnasium.make('physics:d3pg/MassPoint-v0').spec.id)"
    assert fresh(code) == "d3pg/MassPoint-v0"
    code = "import gymnasium; print(gymnasium.make_vec('physics:d3pg/MassPoint-v0').spec.id)"
    assert fresh(code) == "d3pg/MassPoint-v0"


def test_importing_both_loads_no_simulator() -> None:
    code = "import physics, gymnasium, sys; print({'numba', 'torch'} & set(sys.modules))"
    assert fresh(code) == "set()"


@pytest.mark.parametrize("name", physics.names())
def test_the_spec_of_every_task(name: str) -> None:
    spec = gymnasium.spec(identifier(name))
    assert spec.max_episode_steps == physics.make(name).horizon
    assert spec.namespace == "d3pg"
    assert spec.nondeterministic is False
    assert gymnasium.make(spec).spec == spec
    assert gymnasium.make_vec(spec).spec is not None


def test_registering_again_changes_nothing() -> None:
    before = dict(gymnasium.registry)
    register()
    assert gymnasium.registry == before


def test_a_spec_can_be_copied_sent_and_written() -> None:
    def untouched() -> TaskSpec:
        return TaskSpec("d3pg/Pendulum-v0", entry_point="a:b", kwargs={"task": "Pendulum"})

    for other in (
        copy.deepcopy(untouched()),
        pickle.loads(pickle.dumps(untouched())),  # noqa: S301 - our own
        EnvSpec.from_json(untouched().to_json()),
    ):
        assert other.max_episode_steps == 200
        assert other == untouched()
        assert untouched() == other
    assert untouched() != TaskSpec("d3pg/Acrobot-v0", entry_point="a:b", kwargs={})
    assert untouched() != "d3pg/Pendulum-v0"
    given = TaskSpec("d3pg/Pendulum-v0", entry_point="a:b", max_episode_steps=5)
    assert dataclasses.replace(given, entry_point="c:d").max_episode_steps == 5


def test_a_task_of_a_file_is_made_by_its_spec(tmp_path: Path) -> None:
    file = tmp_path / "my_tasks.py"
    file.write_text(
        "from physics.tasks.pendulum import Pendulum\n"
        "class Slow(Pendulum):\n    name = 'own/Slow'\n    horizon = 77\n"
    )
    spec = pickle.loads(pickle.dumps(physics.spec_of(f"{file}:Slow")))  # noqa: S301 - our own
    env = gymnasium.make(spec, gravity=5.0)
    assert env.spec is not None
    assert (env.spec.id, env.spec.max_episode_steps) == ("d3pg/own-Slow-v0", 77)
    assert env.unwrapped.task.label == "own/Slow(gravity=5)"  # type: ignore[attr-defined]
    assert gymnasium.make(env.spec).spec == env.spec
    assert gymnasium.make_vec(spec, num_envs=2).reset(seed=0)[0].shape == (2, 3)
    assert env.spec.id not in gymnasium.registry


def test_a_spec_of_a_class_or_an_object() -> None:
    for task in (Pendulum, physics.make("Pendulum", mass=2.0)):
        env = gymnasium.make(physics.spec_of(task), max_episode_steps=1000)
        assert env.spec is not None
        assert env.spec.max_episode_steps == 1000
        assert physics.spec_of(task).max_episode_steps == 200
    with pytest.raises(ValueError, match=r"nowhere\.py cannot be read"):
        physics.spec_of("nowhere.py:Arm")


@pytest.mark.parametrize("name", ["mujoco/Reacher", "Pendulum(mass=2)"])
def test_a_fresh_spec_makes_vectors(name: str) -> None:
    vector = gymnasium.make_vec(physics.spec_of(name), num_envs=2)
    assert vector.spec is not None
    assert vector.spec.max_episode_steps == physics.make(name).horizon


def test_the_registry_prints() -> None:
    printed = gymnasium.pprint_registry(disable_print=True)
    assert printed is not None
    assert "d3pg/HalfCheetah-v0" in printed


def test_an_unknown_task_gets_a_hint() -> None:
    with pytest.raises(gymnasium.error.NameNotFound, match="Did you mean: `Pendulum`"):
        gymnasium.make("d3pg/Pendullum-v0")


def test_installed_tasks_are_registered(installed: Path) -> None:
    code = (
        "import gymnasium, physics; env = gymnasium.make('d3pg/Slow-v0')\n"
        "print(env.spec.max_episode_steps, env.reset(seed=1)[0].shape)"
    )
    assert fresh(code, installed) == "77 (3,)"


def test_an_installed_module_may_be_the_first_import(installed: Path) -> None:
    code = (
        "import gymnasium, others_tasks\n"
        "print(gymnasium.make('d3pg/Slow-v0').unwrapped.task.__class__ is others_tasks.Slow)"
    )
    assert fresh(code, installed) == "True"


def test_a_broken_task_fails_when_it_is_made(installed: Path) -> None:
    code = (
        "import physics, gymnasium; gymnasium.pprint_registry(disable_print=True)\n"
        "try: gymnasium.make('d3pg/Broken-v0')\n"
        "except ValueError as error: print(error)"
    )
    said = fresh(code, installed)
    assert "Broken" in said
    assert "RuntimeError: broken" in said


def test_a_name_that_gymnasium_cannot_take_is_told(
    installed: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("physics.gym.registration.names", lambda: ["Two words", "Pendulum"])
    with pytest.warns(UserWarning, match="the task 'Two words' is not registered"):
        register()
    assert "d3pg/Two words-v0" not in gymnasium.registry
