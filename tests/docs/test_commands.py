"""Every command that a page shows exists, with the options that it shows."""

import re
import shlex
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
import typer

import algorithms.cli.commands
import service.cli.app
from tests.docs.pages import PAGES, ROOT, commands, name_of

PROGRAMS = {
    "d3pg": service.cli.app.app,
    "python -m algorithms": algorithms.cli.commands.app,
}
PREFIX = r"(?:\w+=(?:\S+ )?)*(?:docker compose exec service )?(?:\S*/)?"
FILES = ("sweep.yaml",)
NOW = [page for page in PAGES if page.name != "CHANGELOG.md"]


def shown(document: Path, program: str) -> Iterator[list[str]]:
    """The arguments of each call of a program that a page shows."""
    for command in commands(document):
        found = re.match(rf"{PREFIX}{program}(?: (.*))?$", command.strip())
        if found:
            yield shlex.split(re.split(r"[>)]", found[1] or "")[0])


def parse(command: Any, arguments: list[str]) -> None:
    """Parse a call without making it; raises for an unknown command or option."""
    context = command.make_context(command.name, arguments, resilient_parsing=not arguments)
    rest = [*context._protected_args, *context.args]
    if rest and hasattr(command, "resolve_command"):
        _, chosen, others = command.resolve_command(context, rest)
        parse(chosen, others)


@pytest.mark.parametrize("program", PROGRAMS)
@pytest.mark.parametrize("document", NOW, ids=name_of)
def test_a_command_parses(
    document: Path, program: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    for file in FILES:
        (tmp_path / file).touch()
    for arguments in shown(document, program):
        parse(typer.main.get_command(PROGRAMS[program]), arguments)


def test_commands_are_found_and_wrong_ones_refused() -> None:
    calls = [call for page in NOW for call in shown(page, "d3pg")]
    assert len(calls) > 30
    assert ["paper", "--seeds", "2", "--scale", "0.02", "-o", "quick"] in calls
    command = typer.main.get_command(PROGRAMS["d3pg"])
    for wrong in (["sbmit"], ["plot", "SWEEP", "--figur", "2"], ["db", "chek"]):
        with pytest.raises(Exception, match="No such"):
            parse(command, wrong)


def test_make_help_says_what_each_target_costs() -> None:
    makefile = (ROOT / "Makefile").read_text()
    targets = set(makefile.partition(".PHONY: ")[2].splitlines()[0].split())
    lines = re.findall(r"^#   make (\S+) .*?(\S+)$", makefile, re.MULTILINE)
    assert {name for name, _ in lines} == targets - {"help", "postgresql"}
    assert {unit for _, unit in lines} <= {"s", "caches", "min", "hour", "hours", "core-hours"}


def test_every_target_of_make_that_a_page_names_exists() -> None:
    targets = set(re.findall(r"^([a-z-]+):", (ROOT / "Makefile").read_text(), re.MULTILINE))
    named = {
        found[1]
        for page in NOW
        for command in commands(page)
        if (found := re.match(r"make ([a-z-]+)", command.strip()))
    }
    assert {"demo", "test", "check", "docs"} <= named <= targets
