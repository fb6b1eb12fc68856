"""`python -m algorithms` as a stranger calls it."""

import csv
import io
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest
from rich.console import Console
from typer.testing import CliRunner

import algorithms
from algorithms.cli import commands, display
from algorithms.cli.commands import app
from algorithms.cli.curve_file import COLUMNS, CurveFile
from algorithms.cli.outcome import Outcome
from algorithms.early_end import Divergence
from algorithms.measurement import Measurement

CALL = ["train", "gd", "MassPoint", "--timesteps", "1600"]


@pytest.fixture(autouse=True)
def plain_console(monkeypatch: pytest.MonkeyPatch) -> None:
    """The console that CliRunner catches, wide enough for a sentence."""
    monkeypatch.setattr(commands, "console", Console(width=200))


def run(*arguments: str) -> tuple[int, str]:
    result = CliRunner(env={"COLUMNS": "200"}).invoke(app, arguments)
    return result.exit_code, result.output


def test_training_says_how_it_goes_and_writes_every_measurement(tmp_path: Path) -> None:
    file = tmp_path / "curves.csv"
    code, said = run(*CALL, "--seeds", "2", "--config", "rate=0.01", "--csv", str(file))
    assert code == 0, said
    assert said.index("compiling") < said.index("100 %") < said.index("return_history")
    with file.open() as rows:
        written = list(csv.DictReader(rows))
    expected = algorithms.train("gd", "MassPoint", range(2), timesteps=1600, config={"rate": 0.01})
    for row, m in zip(written, expected, strict=True):
        assert float(row["return_mean"]) == m.return_mean
        assert [int(row[name]) for name in ("seed", "timestep", "updates", "jacobians")] == [
            m.seed, m.timestep, m.updates, m.jacobians,
        ]  # fmt: skip
        assert float(row["gradient_norm"]) == m.diagnostics["gradient_norm"]


@pytest.mark.parametrize(
    ("arguments", "sentence"),
    [
        (["train", "gb", "Pendulum"], "unknown algorithm 'gb'; did you mean 'gd'?"),
        (["train", "gd", "Pendulumm"], "did you mean 'Pendulum'?"),
        (["train", "gd", "Acrobot"], "gd needs the reward's gradient"),
        ([*CALL, "--weights", "1", "0"], "gd takes no weights"),
        ([*CALL, "--config", "rate=3"], "rate: Input should be less than or equal to 1, not 3"),
        ([*CALL, "--config", "rate"], "'rate' is not NAME=VALUE"),
        ([*CALL, "--seeds", "0"], "greater than or equal to 1"),
        ([*CALL, "--csv", "/nowhere/x.csv"], "cannot write /nowhere/x.csv: No such file"),
    ],
)
def test_a_wrong_call_is_a_sentence_and_code_2(arguments: list[str], sentence: str) -> None:
    code, said = run(*arguments)
    assert code == 2
    assert sentence in said
    assert "compiling" not in said


def test_no_file_is_written_over_and_a_refused_call_leaves_none(tmp_path: Path) -> None:
    file = tmp_path / "curves.csv"
    assert run("train", "gd", "Acrobot", "--csv", str(file))[0] == 2
    assert not file.exists()
    file.write_text("mine")
    code, said = run(*CALL, "--csv", str(file))
    assert (code, file.read_text()) == (2, "mine")
    assert "exists already" in said


def test_a_diverged_run_is_code_1(monkeypatch: pytest.MonkeyPatch) -> None:
    class Diverging:
        timestep, finished = 0, False

        def advance(self) -> list[Divergence]:
            self.finished = True
            return [Divergence(1, 20, 1, "gradient")]

    monkeypatch.setattr(commands, "prepared", lambda *_: Diverging)
    code, said = run(*CALL, "--seeds", "2")
    assert code == 1
    assert "seed 1 diverged: gradient not finite at update 1, timestep 20" in said
    assert "1 of 2 runs ended early." in said


def test_ctrl_c_keeps_what_was_measured_and_is_code_130(tmp_path: Path) -> None:
    file = tmp_path / "curves.csv"
    process = subprocess.Popen(
        [sys.executable, "-m", "algorithms", "train", "gd", "MassPoint", "--timesteps", "10000000",
         "--config", "patience=10000", "--csv", str(file)],
        stdout=subprocess.PIPE, text=True,
    )  # fmt: skip
    assert process.stdout is not None
    try:
        while not (file.exists() and file.read_text().count("\n") > 1):
            assert process.poll() is None
            time.sleep(0.1)  # it needs the processor
        process.send_signal(signal.SIGINT)
        said, _ = process.communicate()
    finally:
        process.kill()
        process.wait()
    assert process.returncode == 130
    assert "Interrupted: what was measured so far is above." in said
    assert file.read_text().endswith("\n")


def test_listing_loads_neither_torch_nor_numba() -> None:
    code = (
        "import sys; from algorithms.cli.commands import app\n"
        "app(['list'], standalone_mode=False)\n"
        "print(sorted({'torch', 'numba'} & set(sys.modules)))"
    )
    said = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert said.stdout.endswith("[]\n")
    for name in [*algorithms.names(), "HalfCheetah"]:
        assert name in said.stdout


def measurement(seed: int, timestep: int, return_mean: float) -> Measurement:
    return Measurement(seed, timestep, return_mean, 2 * return_mean, 3, 4, 0.5, {"norm": 0.1})


def test_a_terminal_shows_compiling_then_a_bar_with_the_time_left(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    now = iter((0.0, 10.0))
    monkeypatch.setattr(display.Clock, "now", staticmethod(lambda: next(now)))
    written = io.StringIO()
    console = Console(file=written, force_terminal=True, width=120)
    outcome = Outcome([0, 1])
    with display.display(console, "gd on Pendulum", 1000, outcome) as show:
        show(0)
        outcome.take([measurement(0, 100, -3.0), measurement(1, 100, -4.0)])
        show(100)
    said = written.getvalue()
    assert said.index("compiling") < said.index("ETA 1:30")
    assert "mean return -3.50 (2 seeds)" in said


def test_the_summary_has_a_row_for_every_run() -> None:
    outcome = Outcome([0, 1, 2])
    outcome.take([measurement(0, 800, -2.0), Divergence(1, 40, 2, "gradient")])
    console = Console(file=io.StringIO(), width=120, record=True)
    console.print(display.summary(outcome))
    rows = console.export_text().splitlines()
    assert [" ".join(row.split()) for row in rows[1:]] == [
        "0 800 -2.00 -4.00 0.5",
        "1 - - - - diverged: gradient not finite at update 2, timestep 40",
        "2 - - - - not measured",
        "mean -2.00 -4.00",
    ]


def test_numbers_come_back_from_a_curve_file_with_their_bits() -> None:
    file = io.StringIO()
    CurveFile(file).write([measurement(0, 800, 0.1 + 0.2)])
    header, row = file.getvalue().splitlines()
    assert header.split(",") == [*COLUMNS, "norm"]
    assert float(row.split(",")[2]) == 0.1 + 0.2
