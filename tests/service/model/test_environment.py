"""What the service knows of tasks: found without listing what is installed each time."""

import pytest

import physics
from service.model.environment import best_return, environment_facts


def test_a_task_of_the_projects_own_is_found_without_a_listing(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    expected = best_return("Pendulum")

    def listing() -> list[str]:
        raise AssertionError("it was listed, which takes milliseconds for every curve")

    monkeypatch.setattr(physics, "names", listing)
    assert best_return("Pendulum") == expected
    assert environment_facts("Pendulum(gravity=8)").name == "Pendulum"


def test_an_unknown_task_is_refused_with_its_nearest() -> None:
    with pytest.raises(ValueError, match="Pendulum"):
        environment_facts("Pendulm")
