"""Parameters: how they are declared, given and written."""

import copy
import pickle
from collections.abc import Mapping

import pytest

from physics.parameter import Parameter, declared, label, parse
from tests.physics.small_tasks import Plain


class Spring(Plain):
    name = "Spring"
    stiffness = Parameter(1.0, "N/m", least=0.0, greatest=10.0)
    damping = Parameter(0.5, "kg/s", least=0.0, greatest=2.0)


class StiffSpring(Spring):
    name = "StiffSpring"
    stiffness = 9.0


def test_a_task_has_the_defaults_and_another_the_values_given() -> None:
    task = Spring()
    other = task.with_parameters(damping=1)
    assert (task.parameters, task.label) == ({"stiffness": 1.0, "damping": 0.5}, "Spring")
    assert other.parameters == {"stiffness": 1.0, "damping": 1.0}
    assert other.label == "Spring(damping=1)"
    assert other.with_parameters(stiffness=2.5).label == "Spring(damping=1, stiffness=2.5)"


def test_a_derived_task_may_make_a_parameter_a_constant() -> None:
    assert list(declared(StiffSpring)) == ["damping"]
    assert StiffSpring().stiffness == 9.0


def test_a_task_with_parameters_can_be_copied_and_sent() -> None:
    task = Spring().with_parameters(damping=1)
    for other in (copy.deepcopy(task), pickle.loads(pickle.dumps(task))):  # noqa: S301
        assert other.parameters == task.parameters


def test_a_task_is_never_changed() -> None:
    with pytest.raises(AttributeError, match=r"with_parameters\(damping=1\.0\)"):
        Spring().damping = 1.0


def test_all_mistakes_are_told() -> None:
    with pytest.raises(ValueError, match="Spring: ") as caught:
        Spring().with_parameters(dampin=1.0, stiffness=11, damping="much")  # type: ignore[arg-type]
    told = str(caught.value)
    assert "there is no parameter 'dampin'; did you mean 'damping'? (known: stiffness, damp" in told
    assert "stiffness must be a number from 0 to 10 N/m, not 11" in told
    assert "damping must be a number from 0 to 2 kg/s, not 'much'" in told
    for value in (True, float("nan"), float("inf")):
        with pytest.raises(ValueError, match="stiffness must be a number"):
            Spring().with_parameters(stiffness=value)


@pytest.mark.parametrize(
    ("values", "text"),
    [
        ({}, "Spring"),
        ({"b": 0.1 + 0.2, "a": 3}, "Spring(a=3, b=0.30000000000000004)"),
        ({"a": -1e-9}, "Spring(a=-1e-09)"),
        ({"a": 1e300}, "Spring(a=1e+300)"),
    ],
)
def test_a_label_is_read_as_it_was_written(values: Mapping[str, float], text: str) -> None:
    assert label("Spring", values) == text
    assert parse(text) == ("Spring", values)


@pytest.mark.parametrize("text", ["Spring(a)", "Spring(a=b)", "Spring(a=1, a=2)", "Spring(a==1)"])
def test_a_label_that_cannot_be_read_is_refused(text: str) -> None:
    with pytest.raises(ValueError, match="expected name=number, each name once"):
        parse(text)
