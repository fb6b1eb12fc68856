"""`edit`: what is left out stays as it is."""

from service.client import Client
from service.store.store import Store
from tests.service.cli.conftest import Command, as_json
from tests.service.conftest import SWEEP
from tests.service.training import rising, train


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


def test_sweeps_are_deleted_after_a_question(d3pg: Command, service: Client, store: Store) -> None:
    first, second = service.submit(SWEEP).id, service.submit(SWEEP).id
    train(store, 5, rising)
    training = service.submit(SWEEP).id
    refused = d3pg("rm", first, stdin="n\n", code=1)
    assert f"{first}: small, 12 runs" in refused.stderr
    assert service.sweep(first).id == first
    assert f"{first}: deleted\n" in d3pg("rm", first, stdin="y\n").stdout
    said = d3pg("rm", second, training, "--yes", "--json", code=1)
    assert as_json(said)["moved"] == [second]
    assert [each.id for each in service.sweeps()] == [training]
