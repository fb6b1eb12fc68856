"""Task files: what is taken from one, and what is said of one that cannot be used."""

import hashlib
import sys
from pathlib import Path

import numpy as np
import pytest

import physics
from physics.task_file import Reference, TaskFile, load, make_all

ARM = """
import numpy as np
import torch

from physics.drawing import Drawing
from physics.environment import Environment
from physics.parameter import Parameter
from physics.tasks.pendulum import Pendulum
from physics.torch_environment import TorchEnvironment


class Arm(TorchEnvironment):
    name = "Arm"
    version = 1
    state_size = 2
    action_size = 1
    horizon = 50
    max_reward = 0.0
    stiffness = Parameter(1.0, "N/m", least=0.0, greatest=10.0)

    def dynamics(self, state, action):
        push = action[0] - self.stiffness * state[0]
        return torch.stack([state[0] + 0.1 * state[1], state[1] + 0.1 * push])

    def reward(self, state, action, next_state):
        return -(next_state**2).sum()

    def initial_state(self, generator):
        return generator.uniform(-1.0, 1.0, 2)

    def draw(self, state):
        return Drawing((-1.0, -1.0, 1.0, 1.0), ())
"""
ANOTHER = """

class LongArm(Arm):
    name = "long-arm"
    horizon = 100


class _Unfinished(Arm):
    pass
"""


@pytest.fixture
def file(tmp_path: Path) -> Path:
    path = tmp_path / "my_tasks.py"
    path.write_text(ARM)
    return path


def refusal(path: Path, task: str = "") -> str:
    with pytest.raises(ValueError, match=r".") as caught:
        physics.make(f"{path}:{task}" if task else str(path))
    return str(caught.value)


def test_a_task_is_made_from_its_file(file: Path) -> None:
    states, actions = np.array([[0.5, 0.2]]), np.array([[0.3]])
    for reference in (str(file), f"{file}:Arm"):
        found = physics.make(reference).differentiate(states, actions)
        np.testing.assert_allclose(found.transition.next_state, [[0.52, 0.18]])
        np.testing.assert_allclose(found.state_jacobian, [[[1.0, 0.1], [-0.1, 1.0]]])


def test_a_parameter_follows_the_name_of_the_task(file: Path) -> None:
    task = physics.make(f"{file}:Arm(stiffness=3)")
    assert task.label == "Arm(stiffness=3)"
    next_state = task.step(np.array([[0.5, 0.2]]), np.zeros((1, 1))).next_state
    np.testing.assert_allclose(next_state, [[0.52, 0.05]])


def test_the_version_is_of_the_text_and_not_of_the_place(file: Path, tmp_path: Path) -> None:
    digest = hashlib.sha256(ARM.encode()).hexdigest()
    assert TaskFile.read(file).digest == digest
    assert physics.make(str(file)).version == int(digest[:7], 16) + 1
    put = TaskFile.read(file).put(tmp_path / "elsewhere")
    assert put.read_text() == ARM
    assert physics.make(str(put)).version == physics.make(str(file)).version


def test_a_changed_file_is_a_new_version(file: Path) -> None:
    before = physics.make(str(file))
    file.write_text(ARM.replace("horizon = 50", "horizon = 60"))
    after = physics.make(str(file))
    assert (before.horizon, after.horizon) == (50, 60)
    assert before.version != after.version


def test_the_tasks_of_a_file_are_those_it_defines(file: Path) -> None:
    file.write_text(ARM + ANOTHER + "\nSTIFF = Arm().with_parameters(stiffness=9.0)\n")
    assert list(load(file)) == ["Arm", "LongArm", "STIFF"]
    assert [task.label for task in make_all(file)] == ["Arm", "long-arm", "Arm(stiffness=9)"]
    for name in ("LongArm", "long-arm"):
        assert physics.make(f"{file}:{name}").horizon == 100


def test_one_of_several_must_be_named(file: Path) -> None:
    file.write_text(ARM + ANOTHER)
    assert f"defines 2 tasks (Arm, LongArm): name one, such as {file}:Arm" in refusal(file)
    assert f"{file} defines no task 'Leg' (it defines: Arm, LongArm)" in refusal(file, "Leg")


@pytest.mark.parametrize(
    ("text", "complaint"),
    [
        ("x = 1\ny = x.shape\n", ", line 2: AttributeError: 'int' object has no attribute 'shape'"),
        ("x = 1\ny = (\n", ", line 2: SyntaxError: '(' was never closed"),
        ("import no_such_package\n", ", line 1: ModuleNotFoundError: No module named"),
        ("raise SystemExit(3)\n", ", line 1: SystemExit: 3"),
        ("x = 1\n", " defines no task: a task is a class derived from TorchEnvironment"),
        (ARM.replace("def reward", "def rewards"), "docs/add-a-task.md); Arm lacks reward"),
        (ARM.replace(".sum()", ""), "- reward must return a tensor [] of torch.float64, not [2]"),
        (ARM.replace(".sum()", ""), "(my_tasks.py, line 25)"),
        (ARM.replace(".sum()", ""), "my_tasks.py, line 12: Arm is not a valid task:"),
        (ARM.replace("    horizon = 50\n", ""), "- horizon is missing: it must be an integer"),
        (ARM.replace("stiffness = Par", "step = Par"), "- the parameter step needs another name: "),
        (
            ARM.replace("Parameter(1.0", "Parameter(11.0"),
            "- the default of stiffness must be a num",
        ),
    ],
)
def test_what_is_wrong_is_said_with_the_line(file: Path, text: str, complaint: str) -> None:
    file.write_text(text)
    told = refusal(file)
    assert complaint in told
    assert str(file) in told


def test_a_file_that_is_none_is_refused(tmp_path: Path) -> None:
    assert "cannot be read: No such file" in refusal(tmp_path / "nothing.py")
    (tmp_path / "binary.py").write_bytes(b"\xff\xfe")
    assert "is not UTF-8 text" in refusal(tmp_path / "binary.py")


def test_a_file_stands_alone(file: Path) -> None:
    file.with_name("helpers.py").write_text("x = 1\n")
    file.write_text("import helpers\n" + ARM)
    assert "cannot import the files beside it: move what it needs of helpers.py" in refusal(file)


def test_what_raised_is_run_again_and_what_ran_is_not(file: Path) -> None:
    runs: list[str] = []
    sys.modules["runs_of_my_tasks"] = type("Module", (), {"runs": runs})  # type: ignore[assignment]
    file.write_text("import runs_of_my_tasks as m\nm.runs.append('')\nassert m.runs[1:]\n" + ARM)
    try:
        refusal(file)
        assert load(file)["Arm"] is load(file)["Arm"]
    finally:
        del sys.modules["runs_of_my_tasks"]
    assert len(runs) == 2


@pytest.mark.parametrize(
    ("text", "reference"),
    [
        ("a/my_tasks.py:Arm", Reference(Path("a/my_tasks.py"), "Arm")),
        ("my_tasks.py", Reference(Path("my_tasks.py"), "")),
        ("my_tasks.py:lab/Arm", Reference(Path("my_tasks.py"), "lab/Arm")),
        ("Pendulum", None),
    ],
)
def test_references(text: str, reference: Reference | None) -> None:
    assert Reference.parse(text) == reference
