"""The catalogue, and what importing the package costs."""

import subprocess
import sys

import pytest

import physics
from physics.catalogue import OWN


def test_every_name_makes_its_task() -> None:
    assert physics.names()[:1] == ["MassPoint"]
    for name in physics.names():
        assert physics.make(name).name == name


def test_an_unknown_name_is_answered_with_the_nearest() -> None:
    with pytest.raises(ValueError, match=r"unknown environment 'pendullum'; did you mean 'Pend"):
        physics.make("pendullum")
    with pytest.raises(ValueError, match=r"unknown environment 'Zzz' \(known: MassPoint"):
        physics.make("Zzz")


@pytest.mark.parametrize(
    ("value", "complaint"),
    [
        (
            "no_such_module:Task",
            r"Mine \(no_such_module:Task\) cannot be made: ModuleNotFoundError",
        ),
        ("physics.tasks.pendulum:Nothing", r"Mine .* cannot be made: AttributeError"),
        ("physics.environment:Environment", r"Mine .* cannot be made: TypeError: .*abstract"),
        (
            "physics.tasks.pendulum:Pendulum",
            r"makes <.*Pendulum object.*>, which is not a task of that name",
        ),
        ("builtins:dict", r"entry point 'Mine' makes {}, which is not a task of that name"),
    ],
)
def test_an_entry_that_makes_no_task_is_refused_by_name(
    monkeypatch: pytest.MonkeyPatch, value: str, complaint: str
) -> None:
    monkeypatch.setitem(OWN, "Mine", value)
    with pytest.raises(ValueError, match=complaint):
        physics.make("Mine")


def test_compiling_reports_each_task() -> None:
    reported = list(physics.compile_kernels(physics.names()))
    assert [name for name, _ in reported] == physics.names()
    assert all(seconds >= 0.0 for _, seconds in reported)


@pytest.mark.parametrize("statement", ["import physics", "import physics; physics.names()"])
def test_importing_is_light(statement: str) -> None:
    heavy = "sorted({'torch', 'numba', 'gymnasium', 'mujoco', 'jax'} & set(sys.modules))"
    answer = subprocess.run(
        [sys.executable, "-c", f"{statement}; import sys; print({heavy})"],
        capture_output=True,
        text=True,
        check=True,
    )
    assert answer.stdout.strip() == "[]"


def test_making_a_task_loads_no_torch() -> None:
    code = "import physics, sys; physics.make('Pendulum').compile(); print('torch' in sys.modules)"
    answer = subprocess.run(
        [sys.executable, "-c", code], capture_output=True, text=True, check=True
    )
    assert answer.stdout.strip() == "False"


def test_an_unknown_attribute_is_an_attribute_error() -> None:
    with pytest.raises(AttributeError, match="no attribute 'nothing'"):
        _ = physics.nothing
