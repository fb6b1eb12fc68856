"""The commands, without a service: what they say when they are called wrongly."""

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from typer.core import TyperGroup
from typer.main import get_command
from typer.testing import CliRunner

from service.cli.app import app, main

runner = CliRunner()


@pytest.fixture(autouse=True)
def nowhere(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    """No token, and no service behind the port."""
    monkeypatch.delenv("D3PG_TOKEN", raising=False)
    monkeypatch.setenv("D3PG_DATA_DIR", str(tmp_path / "none"))
    monkeypatch.setenv("D3PG_URL", "http://127.0.0.1:1")


def test_a_figure_is_png_svg_or_pdf() -> None:
    result = runner.invoke(app, ["plot", "0" * 12, "-o", "figure.gif"], env={"COLUMNS": "300"})
    assert result.exit_code == 2
    assert ".png, .svg or .pdf" in result.output


@pytest.mark.parametrize(
    ("token", "expected"), [(None, "D3PG_TOKEN is not set"), ("x" * 20, "No service answers at")]
)
def test_a_refusal_is_a_sentence(
    token: str | None,
    expected: str,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    if token:
        monkeypatch.setenv("D3PG_TOKEN", token)
    monkeypatch.setattr("sys.argv", ["d3pg", "cancel", "0" * 12])
    with pytest.raises(SystemExit) as exit_:
        main()
    assert exit_.value.code == 1
    error = capsys.readouterr().err
    assert expected in error
    assert "d3pg serve" in " ".join(error.split())
    assert "Traceback" not in error


def test_an_interruption_is_130(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    def interrupted() -> None:
        raise KeyboardInterrupt

    monkeypatch.setattr("service.cli.app.find_token", interrupted)
    monkeypatch.setattr("sys.argv", ["d3pg", "token"])
    with pytest.raises(SystemExit) as exit_:
        main()
    assert exit_.value.code == 130
    assert "Traceback" not in capsys.readouterr().err


def test_every_command_explains_itself() -> None:
    shown = runner.invoke(app, ["--help"], env={"COLUMNS": "200"}).output
    for command in app.registered_commands:
        name = command.name or command.callback.__name__  # type: ignore[union-attr]
        assert name in shown
        assert runner.invoke(app, [name, "--help"]).exit_code == 0


def test_the_shell_can_complete() -> None:
    asked = {"_D3PG_COMPLETE": "complete_bash", "COMP_WORDS": "d3pg re", "COMP_CWORD": "1"}
    assert runner.invoke(app, prog_name="d3pg", env=asked).stdout.split() == ["resume", "retry"]


def commands_of(command: Any, name: str = "d3pg") -> Iterator[tuple[str, Any]]:
    """Every command at and below one, with what is typed for it."""
    is_group = isinstance(command, TyperGroup)
    if not is_group or command.invoke_without_command:
        yield name, command
    for word, each in command.commands.items() if is_group else ():
        yield from commands_of(each, f"{name} {word}")


COMMANDS = dict(commands_of(get_command(app)))


@pytest.mark.parametrize("name", COMMANDS)
def test_every_command_prints_json_on_demand(name: str) -> None:
    assert "--json" in [flag for option in COMMANDS[name].params for flag in option.opts]
