"""A diagnosis fits 60 columns, and its CSV has every number."""

import csv
import io
import math
from pathlib import Path

import pytest
from rich.console import Console
from typer.testing import CliRunner

from algorithms.cli import commands, findings
from algorithms.cli.commands import app
from algorithms.diagnostics.finding import Finding

CALL = ["diagnose", "Pendulum", "--algorithm", "ddpg", "--timesteps", "200"]


def run(*arguments: str) -> tuple[int, str]:
    result = CliRunner(env={"COLUMNS": "200"}).invoke(app, arguments)
    return result.exit_code, result.output


def rows(found: dict[int, list[Finding]]) -> list[list[str]]:
    """The cells of all tables."""
    console = Console(file=io.StringIO(), width=60, record=True)
    for _, table in findings.tables(found):
        console.print(table)
    return [line.split() for line in console.export_text().splitlines()]


def test_the_command_prints_60_columns_and_writes_every_number(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(commands, "console", Console(width=60))
    file = tmp_path / "found.csv"
    code, said = run(*CALL, "--csv", str(file))
    assert code == 0, said
    shown = said[said.index("Gradient of") :]
    assert max(map(len, shown.splitlines())) <= 60
    assert "…" not in shown
    for title in findings.TITLES.values():
        assert title in shown
    with file.open() as written:
        numbers = list(csv.DictReader(written))
    assert len(numbers) == 102
    [crossing] = [each for each in numbers if each["quantity"] == "crossing"]
    assert f"{float(crossing['value']):.3g}" in shown


def test_the_widest_numbers_fit() -> None:
    wide = 1.23456e103
    found = [
        Finding("smoothing", name, 32, 0.05, wide)
        for name in ("norm", "bias", "resolution", "exact_std", "zeroth_std")
    ]
    assert rows({0: found})[-1] == ["32", "0.05", *["1.23e+103"] * 5]


def test_tables_show_medians_of_the_seeds_that_have_a_number() -> None:
    def found(value: float) -> list[Finding]:
        return [Finding("growth", "median_norm", 4, None, value)]

    assert rows({0: found(1.0), 1: found(9.0), 2: found(3.0)})[-1] == ["4", "3"]
    assert rows({0: found(1.0), 1: found(math.nan)})[-1] == ["4", "1"]
    assert rows({0: found(math.nan)})[-1] == ["4", "nan"]


@pytest.mark.parametrize(
    ("arguments", "sentence"),
    [
        (["diagnose", "Pendulumm"], "did you mean 'Pendulum'?"),
        (["diagnose", "Pendulum", "--algorithm", "mpc"], "mpc learns no policy to diagnose"),
        ([*CALL, "--csv", "/nowhere/x.csv"], "cannot write /nowhere/x.csv: No such file"),
    ],
)
def test_a_wrong_call_is_a_sentence_and_code_2(
    arguments: list[str], sentence: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(commands, "console", Console(width=200))
    code, said = run(*arguments)
    assert code == 2
    assert sentence in said
