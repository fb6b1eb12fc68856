"""`add` and `extend`: more of a sweep."""

import pytest
import typer

from service.cli.adding import seeds_of
from service.client import Client
from service.store.store import Store
from tests.service.cli.conftest import Command, as_json
from tests.service.conftest import SWEEP
from tests.service.training import rising, train


@pytest.mark.parametrize(
    ("text", "seeds"),
    [("16", [16]), ("3,7", [3, 7]), ("16-18", [16, 17, 18]), ("1,4-5", [1, 4, 5])],
)
def test_seeds_as_people_write_them(text: str, seeds: list[int]) -> None:
    assert seeds_of(text) == seeds


@pytest.mark.parametrize("text", ["", "a", "3-", "-3", "1,,2"])
def test_what_are_no_seeds(text: str) -> None:
    with pytest.raises(typer.BadParameter, match="write 16,17 or 16-31"):
        seeds_of(text)


def test_a_sweep_grows(d3pg: Command, service: Client, store: Store) -> None:
    sweep_id = service.submit(SWEEP).id
    train(store, 5, rising)
    dry = d3pg("add", sweep_id, "--seeds", "3-4", "--dry-run").stdout
    assert "8 runs, 32,000 timesteps; nothing was queued." in dry
    dry = as_json(d3pg("add", sweep_id, "-a", "sac:rate=1e-4,1e-3", "--dry-run", "--json"))
    assert dry["runs"]["total"] == 12
    dry = as_json(d3pg("extend", sweep_id, "--timesteps", "8000", "--dry-run", "--json"))
    assert dry["timesteps"] == 12 * 4000
    said = d3pg("add", sweep_id, "--seeds", "3-4").stdout
    assert said == f"{sweep_id}: running (8 queued, 12 succeeded)\n"
    grown = as_json(d3pg("add", sweep_id, "-a", "sac:rate=1e-4,1e-3", "--json"))
    assert [entry["label"] for entry in grown["entries"]][2:] == [
        "sac rate=0.0001",
        "sac rate=0.001",
    ]
    train(store, 5, rising)
    longer = as_json(d3pg("extend", sweep_id, "--timesteps", "8000", "--json"))
    assert longer["runs"]["queued"] == longer["runs"]["total"]
    assert "either --seeds or" in d3pg("add", sweep_id, code=2).stderr
