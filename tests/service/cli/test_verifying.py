"""`d3pg verify`: a stored curve against the run trained anew."""

import algorithms
from service.client import Client
from service.store.store import Store
from tests.service.cli.conftest import Command
from tests.service.training import rising, train
from workers.messages.progress import Progress

SWEEP = {
    "algorithms": [{"name": "ddpg"}],
    "environments": ["Pendulum"],
    "seeds": 1,
    "timesteps": 1600,
}


def test_the_same_bits_are_said_to_be_the_same(
    d3pg: Command, service: Client, store: Store
) -> None:
    sweep = service.submit(SWEEP).id
    claim = store.claim_cohort("worker", 60.0)
    assert claim is not None
    spec = claim.specs[0]
    curve = tuple(
        algorithms.train("ddpg", "Pendulum", seeds=[0], timesteps=1600, config=dict(spec.config))
    )
    store.record(claim, Progress(1600, measurements=curve, finished=(0,)))
    [run] = service.runs(sweep)
    assert "all 2 measurements are the same" in d3pg("verify", run.id).stdout


def test_another_curve_is_told_by_its_first_difference(
    d3pg: Command, service: Client, store: Store
) -> None:
    sweep = service.submit(SWEEP).id
    train(store, 2, rising)
    [run] = service.runs(sweep)
    assert "measurement 1 of 2 and what follows differ" in d3pg("verify", run.id, code=1).stdout
