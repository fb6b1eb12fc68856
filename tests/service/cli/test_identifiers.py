"""Beginnings of ids, and what the shell is offered."""

import pytest
import typer
from fastapi import FastAPI

from service.cli.identifiers import (
    complete_algorithm,
    complete_environment,
    complete_id,
    complete_sweep,
    whole_id,
)
from service.client import Client
from tests.service.cli.conftest import Command, as_json
from tests.service.conftest import SWEEP, changed


def test_a_beginning_that_is_one_sweeps_suffices(d3pg: Command, service: Client) -> None:
    sweep_id = service.submit(changed(tags=["a"])).id
    service.edit(sweep_id, archived=True)
    start = sweep_id[:7]
    assert as_json(d3pg("show", start, "--json"))["id"] == sweep_id
    assert as_json(d3pg("show", f"{start}-3", "--json"))["id"] == f"{sweep_id}-3"
    assert sweep_id in d3pg("cancel", f"{start}-1", f"{start}-2").stdout
    assert service.sweep(sweep_id).runs.cancelled == 2
    assert as_json(d3pg("ls", start, "--json"))["items"][0]["sweep_id"] == sweep_id
    assert d3pg("rm", "--yes", start, code=1).stderr.startswith(f"{sweep_id}: ")


def test_a_beginning_of_several_is_refused_with_them(d3pg: Command, service: Client) -> None:
    ids = [service.submit(SWEEP).id for _ in range(17)]  # two begin alike: there are 16 digits
    first = next(each[0] for i, each in enumerate(ids) if each[0] in {o[0] for o in ids[:i]})
    said = d3pg("show", first, code=2).stderr
    assert "is the beginning of several" in " ".join(said.replace("│", " ").split())
    with pytest.raises(typer.BadParameter):
        whole_id(first)


@pytest.mark.parametrize("text", ["nope", "", "ffffffffffff", "3f-x", "A" * 100])
def test_what_begins_no_id_is_for_the_service_to_refuse(url: str, text: str) -> None:
    del url
    assert whole_id(text) == text


def test_the_shell_completes_ids_algorithms_and_tasks(service: Client) -> None:
    sweep_id = service.submit(changed(name="two\tparts")).id
    assert complete_sweep(sweep_id[:3]) == [(sweep_id, "two parts")]
    assert complete_sweep("") == [(sweep_id, "two parts")]
    assert (f"{sweep_id}-11", "hybrid-ddpg Pendulum seed 2") in complete_id(f"{sweep_id}-1")
    assert [name for name, _ in complete_algorithm("hybrid-s")] == ["hybrid-sac"]
    assert [name for name, _ in complete_environment("pend")] == ["Pendulum"]


def test_without_a_service_nothing_is_offered(
    app: FastAPI, monkeypatch: pytest.MonkeyPatch
) -> None:
    del app
    monkeypatch.setenv("D3PG_TOKEN", "x" * 20)
    monkeypatch.setenv("D3PG_URL", "http://127.0.0.1:9")
    assert complete_sweep("a") == []
    assert complete_algorithm("d") == []
