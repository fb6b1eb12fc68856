"""`d3pg doctor`: check everything that the service needs, and say what to do if it is missing."""

from __future__ import annotations

from dataclasses import asdict

import typer
from pydantic import BaseModel
from rich.text import Text

from service.cli.host.checkup import Finding, Verdict, examine
from service.cli.terminal import AsJson, console, print_json, say

STYLES = {"ok": "green", "warning": "yellow", "failed": "bold red"}


class FindingAnswer(BaseModel):
    """A finding, for `--json`."""

    check: str
    verdict: Verdict
    found: str
    advice: str


class DoctorAnswer(BaseModel):
    """All findings."""

    is_healthy: bool
    findings: list[FindingAnswer]


def doctor(as_json: AsJson = False) -> None:
    """Check Python, libraries, memory, disk, database and port, and say what to do."""
    findings: list[Finding] = []
    for finding in examine():
        findings.append(finding)
        if not as_json:
            say_finding(finding)
    failed = sum(finding.verdict == "failed" for finding in findings)
    if as_json:
        listed = [FindingAnswer(**asdict(finding)) for finding in findings]
        print_json(DoctorAnswer(is_healthy=not failed, findings=listed))
    else:
        say(f"{failed} of {len(findings)} checks failed." if failed else "All checks passed.")
    raise typer.Exit(1 if failed else 0)


def say_finding(finding: Finding) -> None:
    """Print a finding, and its advice on a second line if it has any."""
    line = Text.assemble(
        (f"{finding.verdict:<8} ", STYLES[finding.verdict]), f"{finding.check:<9} {finding.found}"
    )
    console.print(line, soft_wrap=True)
    if finding.advice:
        say(f"{'':19}-> {finding.advice}")
