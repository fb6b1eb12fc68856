"""`d3pg search`: what it posts, what it prints, its exit code."""

from collections.abc import Iterator

import pytest

from algorithms.early_end import Failure
from service.client import Client
from service.queue.question_rounds import look_at_all
from service.store.store import Store
from tests.service.cli.conftest import Command, as_json
from tests.service.training import RANDOM, at_work, random_return, train
from workers.messages.progress import Progress
from workers.messages.run_spec import RunSpec

SEARCHED = ("-e", "Pendulum", "--grid", "noise=0.1,0.4", "--grid", "tau=0.01,0.02", "--timesteps",
            "2400", "--budget", "16000")  # fmt: skip


def worth(spec: RunSpec, timestep: int) -> float:
    """Noise 0.4 is the best, with the larger tau."""
    return float(RANDOM * (1 - timestep / 2400 * (spec.config["noise"] + spec.config["tau"])))


@pytest.fixture
def _trained(store: Store) -> Iterator[None]:
    """Workers, and the rounds of searches."""
    store.record_random_return(random_return("Pendulum", RANDOM))

    def work() -> None:
        train(store, 3, worth)
        look_at_all(store)

    with at_work(work):
        yield


@pytest.mark.usefixtures("_trained")
def test_it_waits_for_the_best_and_says_how_to_ask(d3pg: Command, service: Client) -> None:
    said = d3pg("search", "ddpg", *SEARCHED).stdout
    assert "Note: The search takes 12,800 of its budget of 16,000 timesteps, with 2 seeds." in said
    assert "Pendulum: ddpg noise=0.4 tau=0.02 is the best of 4: 0." in said
    assert "1,000,000,000 to 1,000,000,001), which no question takes" in said
    assert "d3pg ask 'ddpg:noise=0.4:tau=0.02 vs ddpg' -e Pendulum --timesteps 2400" in said
    [sweep] = service.sweeps()
    assert sweep.name == "search: ddpg, noise=0.1,0.4, tau=0.01,0.02"
    assert "Pendulum: ddpg noise=0.4 tau=0.02 is the best" in d3pg("show", sweep.id).stdout


@pytest.mark.usefixtures("_trained")
def test_its_answer_as_json(d3pg: Command) -> None:
    found = as_json(d3pg("search", "ddpg", *SEARCHED, "--json"))
    assert found["is_settled"]
    [task] = found["tasks"]
    assert task["algorithm"] == {"name": "ddpg", "config": {"noise": 0.4, "tau": 0.02}}


def test_it_can_be_planned_without_being_made(d3pg: Command, service: Client) -> None:
    said = d3pg("search", "ddpg", *SEARCHED, "--dry-run").stdout
    assert "8 runs, 12,800 timesteps; nothing was queued." in said
    assert list(service.sweeps()) == []


def test_without_a_winner_it_fails(d3pg: Command, store: Store) -> None:
    def fail() -> None:
        while claim := store.claim_cohort("w", 60.0):
            failed = tuple(Failure(spec.seed, 0, "x") for spec in claim.specs)
            store.record(claim, Progress(800, failed=failed))
        look_at_all(store)

    with at_work(fail):
        said = d3pg("search", "ddpg", *SEARCHED, code=1).stdout
    assert "Pendulum: none: every entry that was left has runs that failed" in said


def test_what_is_no_grid_is_refused(d3pg: Command) -> None:
    assert "twice" in d3pg("search", "ddpg:noise=0.2,0.3", *SEARCHED, code=2).stderr
