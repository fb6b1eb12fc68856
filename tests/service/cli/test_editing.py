"""`edit`: what is left out stays as it is."""

from service.client import Client
from tests.service.cli.conftest import Command, as_json
from tests.service.conftest import SWEEP


def test_fields_are_changed_one_by_one(d3pg: Command, service: Client) -> None:
    sweep_id = service.submit(SWEEP).id
    shown = d3pg("edit", sweep_id, "--name", "new", "--tag", "a", "--tag", "b").stdout
    assert "name       new\n" in shown
    assert "tags       a, b\n" in shown
    edited = as_json(d3pg("edit", sweep_id, "--notes", "# N", "--archive", "--json"))
    assert (edited["name"], edited["notes"], edited["archived"]) == ("new", "# N", True)
    edited = as_json(d3pg("edit", sweep_id, "--untag", "--unarchive", "--priority", "3", "--json"))
    assert (edited["tags"], edited["archived"], edited["priority"]) == ([], False, 3)


def test_what_contradicts_itself_is_refused(d3pg: Command, service: Client) -> None:
    sweep_id = service.submit(SWEEP).id
    assert "contradict" in d3pg("edit", sweep_id, "--tag", "a", "--untag", code=2).stderr
