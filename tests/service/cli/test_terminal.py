"""What is printed steers no terminal, and a list fits a narrow one."""

import io
import json
import re

import pytest
from pydantic import BaseModel
from rich.console import Console

from service.cli import listing, terminal
from service.client import Client
from tests.service.cli.conftest import Command
from tests.service.conftest import changed

EVIL = "red\x1b[31m\x9b31m\x7f\u202e\r\U000e0001 end"
CONTROLS = re.compile("[\x00-\x08\x0b-\x1f\x7f-\x9f\u202e\U000e0001]")


class Named(BaseModel):
    """An answer."""

    name: str


def test_json_says_the_same_and_steers_nothing(capsys: pytest.CaptureFixture[str]) -> None:
    terminal.print_json(Named(name=EVIL))
    said = capsys.readouterr().out
    assert json.loads(said) == {"name": EVIL}
    assert not CONTROLS.search(said)


@pytest.mark.parametrize("command", [["show"], ["show", "--json"], ["ls", "--json"], ["watch"]])
def test_no_command_prints_what_steers_a_terminal(
    d3pg: Command, service: Client, command: list[str]
) -> None:
    sweep_id = service.submit(changed(name=EVIL, notes=EVIL)).id
    service.cancel(sweep_id)
    said = d3pg(command[0], *([] if command[0] == "ls" else [sweep_id]), *command[1:]).stdout
    assert not CONTROLS.search(said)
    assert "end" in said
    if command == ["show", "--json"]:
        assert json.loads(said)["name"] == EVIL


@pytest.mark.parametrize(("width", "is_wide"), [(60, False), (100, False), (200, True)])
def test_a_list_on_a_terminal_shows_what_it_has_room_for(
    service: Client, monkeypatch: pytest.MonkeyPatch, width: int, is_wide: bool
) -> None:
    sweep = service.submit(changed(name="x"))
    narrow = Console(file=io.StringIO(), force_terminal=True, width=width, color_system=None)
    for module in (listing, terminal):
        monkeypatch.setattr(module, "console", narrow)
    monkeypatch.setattr(terminal.print_table, "__defaults__", (narrow,))
    listing.list_sweeps(list(service.sweeps()), 50, as_json=False)
    said = narrow.file.getvalue()  # type: ignore[attr-defined]
    assert sweep.id in said
    assert ("hybrid-ddpg" in said) == is_wide
    assert max(map(len, said.splitlines())) <= width
