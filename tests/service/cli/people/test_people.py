"""`d3pg users`, `share`, `shares`, `signin` and `sessions`, against a real server."""

import re
from pathlib import Path

import httpx2
import pytest

from service.client import Client, ServiceError
from tests.service.cli.conftest import Command, as_json
from tests.service.conftest import SWEEP


def test_a_user_is_added_listed_and_revoked(d3pg: Command, url: str) -> None:
    added = d3pg("users", "add", "ann", "--scope", "submit")
    token = added.stdout.strip()
    assert re.fullmatch(r"[\w-]{43}", token)
    assert "D3PG_TOKEN_FILE" in added.stderr
    with Client(url, token) as ann:
        assert ann.submit(SWEEP).owner == "ann"
        with pytest.raises(ServiceError, match="'admin'"):
            ann.users()
    assert d3pg("users").stdout.splitlines()[1].startswith("ann\tsubmit\t")
    assert "ann" in d3pg("ls").stdout
    assert "ann" not in d3pg("ls", "--owner", "bob").stdout
    assert d3pg("users", "revoke", "ann").stdout == "ann was revoked.\n"
    [revoked] = as_json(d3pg("users", "--json"))
    assert revoked["revoked_at"] is not None
    with Client(url, token) as ann, pytest.raises(ServiceError, match="Not signed in"):
        list(ann.sweeps())
    again = as_json(d3pg("users", "add", "ann", "--scope", "read", "--json"))
    assert again["token"] != token


def test_a_scope_is_one_of_four(d3pg: Command) -> None:
    said = d3pg("users", "add", "ann", "--scope", "all", code=2).output
    assert "'metrics', 'read', 'submit'" in " ".join(said.replace("│", " ").split())


def test_a_sweep_is_shared_and_taken_back(d3pg: Command, service: Client) -> None:
    sweeps = [service.submit(SWEEP).id for _ in range(2)]
    shared = d3pg("share", *sweeps, "--days", "3")
    token = shared.stdout.strip().partition("#share=")[2]
    assert f"can read {sweeps[0]}, {sweeps[1]} until" in shared.stderr
    with Client(service.url, token) as guest:
        assert {sweep.id for sweep in guest.sweeps()} == set(sweeps)
    [listed] = as_json(d3pg("shares", "--json"))
    assert listed["sweeps"] == sweeps
    assert listed["id"] in d3pg("shares").stdout
    assert listed["id"] in shared.stderr
    assert "was revoked" in d3pg("shares", "revoke", listed["id"]).stdout
    assert as_json(d3pg("shares", "--json")) == []


def test_a_link_signs_a_browser_in_once(d3pg: Command, service: Client) -> None:
    sweep = service.submit(SWEEP).id
    link = d3pg("signin", sweep[:6]).stdout.strip()
    assert service.token not in link
    with httpx2.Client() as browser:
        assert browser.get(link).headers["location"] == f"/sweeps/{sweep}"
        assert browser.get(f"{service.url}/api/v1/sweeps").status_code == 200
        [session] = as_json(d3pg("sessions", "--json"))
        assert session["id"] in d3pg("sessions").stdout
        assert "was ended" in d3pg("sessions", "end", session["id"]).stdout
        assert browser.get(f"{service.url}/api/v1/sweeps").status_code == 401
    with httpx2.Client() as another:
        assert another.get(link).status_code == 401


def test_a_token_lies_in_a_file_of_one_s_own(
    d3pg: Command, url: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """An argument would stand in the list of processes, and in the shell's history."""
    file = tmp_path / "token-of-ann"
    file.touch(0o600)
    file.write_text(d3pg("users", "add", "ann", "--scope", "submit").stdout)
    monkeypatch.delenv("D3PG_TOKEN")
    monkeypatch.setenv("D3PG_TOKEN_FILE", str(file))
    with Client(url) as ann:
        assert ann.submit(SWEEP).owner == "ann"
    file.chmod(0o640)
    with pytest.raises(ServiceError, match="chmod 600"):
        Client(url)
    monkeypatch.setenv("D3PG_TOKEN_FILE", str(tmp_path / "none"))
    with pytest.raises(ServiceError, match="D3PG_TOKEN_FILE"):
        Client(url)
