"""`d3pg serve`: each setting is a flag, and what is given becomes the service's environment."""

import os
from collections.abc import Mapping, Sequence

import pytest
from typer.testing import CliRunner

from service.cli.app import app
from service.cli.host.serving import is_secret
from service.settings import Settings, variable_of

runner = CliRunner()


class Started(Exception):  # noqa: N818
    """In place of the service."""


@pytest.fixture
def environment(monkeypatch: pytest.MonkeyPatch) -> dict[str, str]:
    """The variables that the service is started with."""
    given: dict[str, str] = {}

    def start(program: str, arguments: Sequence[str], variables: Mapping[str, str]) -> None:
        assert list(arguments[:3]) == [program, "-m", "service"]
        given.update(variables, arguments=" ".join(arguments[3:]))
        raise Started

    monkeypatch.setattr(os, "execve", start)
    for name in Settings.model_fields:
        monkeypatch.delenv(variable_of(name), raising=False)
    return given


FLAGS = {name: field for name, field in Settings.model_fields.items() if not is_secret(field)}


def test_each_setting_is_a_flag(environment: dict[str, str]) -> None:
    values = dict.fromkeys(FLAGS, "5")
    flags = [f"--{name.replace('_', '-')}={value}" for name, value in values.items()]
    assert isinstance(runner.invoke(app, ["serve", *flags]).exception, Started)
    for name, value in values.items():
        assert environment[variable_of(name)] == value


def test_a_secret_is_no_flag() -> None:
    """It would stand in the shell's history and in the list of processes."""
    secrets = Settings.model_fields.keys() - FLAGS.keys()
    assert secrets == {"token", "webhook_secret"}
    for name in secrets:
        result = runner.invoke(app, ["serve", f"--{name.replace('_', '-')}=something-secret"])
        assert result.exit_code == 2


def test_json_is_asked_of_the_service(environment: dict[str, str]) -> None:
    for flags in ([], ["--json"]):
        assert isinstance(runner.invoke(app, ["serve", *flags]).exception, Started)
        assert environment.pop("arguments") == " ".join(flags)


def test_a_task_file_may_be_given_again(environment: dict[str, str]) -> None:
    flags = ["--tasks", "a.py", "--tasks", "b/c.py", "--min-workers", "0"]
    assert isinstance(runner.invoke(app, ["serve", *flags]).exception, Started)
    assert environment["D3PG_TASKS"] == "a.py,b/c.py"
    assert environment["D3PG_MIN_WORKERS"] == "0"


def test_what_is_not_given_is_not_set(environment: dict[str, str]) -> None:
    assert isinstance(runner.invoke(app, ["serve", "--port", "8001"]).exception, Started)
    assert {name for name in environment if name.startswith("D3PG_")} >= {"D3PG_PORT"}
    others = {variable_of(name) for name in Settings.model_fields} - {"D3PG_PORT"}
    assert not others & environment.keys()


@pytest.mark.parametrize("width", ["60", "100"])
def test_help_describes_every_flag(width: str) -> None:
    shown = runner.invoke(app, ["serve", "--help"], env={"COLUMNS": width}).output
    words = " ".join(shown.replace("│", " ").split())
    for name, field in FLAGS.items():
        assert f"--{name.replace('_', '-')} " in words
        assert " ".join(str(field.description).split()[:3]) in words
    assert "8000 if unset." in words
    assert "Undefined" not in words


def test_a_port_is_a_number() -> None:
    result = runner.invoke(app, ["serve", "--port", "http"])
    assert result.exit_code == 2
    assert "--port" in result.output
