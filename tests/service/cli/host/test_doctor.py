"""`d3pg doctor`: a line a check, and an exit code for scripts."""

import pytest

from service.cli.host import doctor
from service.cli.host.checkup import Finding
from tests.service.cli.conftest import Command, as_json


@pytest.mark.parametrize(("verdict", "code"), [("ok", 0), ("warning", 0), ("failed", 1)])
def test_findings_are_lines_and_an_exit_code(
    d3pg: Command, monkeypatch: pytest.MonkeyPatch, verdict: str, code: int
) -> None:
    finding = Finding("disk", verdict, "[b] 3 GB free", "Make room.")  # type: ignore[arg-type]
    monkeypatch.setattr(doctor, "examine", lambda: iter([finding]))
    lines = d3pg("doctor", code=code).stdout.splitlines()
    assert lines[0].split() == [verdict, "disk", "[b]", "3", "GB", "free"]
    assert lines[1].strip() == "-> Make room."
    assert lines[2].startswith("1 of 1 checks failed" if code else "All checks passed")
    answer = as_json(d3pg("doctor", "--json", code=code))
    assert answer["is_healthy"] is (code == 0)
    assert answer["findings"][0]["verdict"] == verdict
