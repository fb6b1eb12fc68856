"""The commands, without a service: what they say when they are called wrongly."""

from pathlib import Path

import pytest
from typer.testing import CliRunner

from service.cli.app import app, main, read_request

runner = CliRunner()


@pytest.fixture(autouse=True)
def nowhere(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    """No token, and no service behind the port."""
    monkeypatch.delenv("D3PG_TOKEN", raising=False)
    monkeypatch.setenv("D3PG_DATA_DIR", str(tmp_path / "none"))
    monkeypatch.setenv("D3PG_URL", "http://127.0.0.1:1")


def test_a_request_is_read_as_it_stands(tmp_path: Path) -> None:
    file = tmp_path / "sweep.yaml"
    file.write_text("name: é [b]\nseeds: [1, 2]\n", encoding="utf-8")
    assert read_request(file) == {"name": "é [b]", "seeds": [1, 2]}


@pytest.mark.parametrize(
    ("content", "reason"), [("a: [", "not YAML"), ("- 1\n", "must hold a mapping")]
)
def test_a_bad_file_is_refused_by_name(tmp_path: Path, content: str, reason: str) -> None:
    file = tmp_path / "sweep.yaml"
    file.write_text(content)
    result = runner.invoke(app, ["submit", str(file)], env={"COLUMNS": "300"})
    assert result.exit_code == 2
    assert reason in result.output
    assert "sweep.yaml" in result.output


def test_a_missing_file_is_refused() -> None:
    result = runner.invoke(app, ["submit", "nowhere.yaml"], env={"COLUMNS": "300"})
    assert result.exit_code == 2
    assert "cannot read nowhere.yaml" in result.output


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
