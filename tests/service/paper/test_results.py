"""The evaluation's files: what they say is of one state of the sweeps, while these go on."""

from typing import Any

import pytest
from fastapi import FastAPI

from service.client import Client
from service.paper.results import Swept
from service.store.store import Store
from tests.service.conftest import SWEEP, TOKEN
from tests.service.served import served
from tests.service.training import RANDOM, random_return, rising, train


@pytest.mark.parametrize("asked", ["sweep", "runs", "sweep_rows", "statistics"])
def test_runs_that_end_meanwhile_are_in_all_of_it(
    app: FastAPI, store: Store, monkeypatch: pytest.MonkeyPatch, asked: str
) -> None:
    for environment in SWEEP["environments"]:
        store.record_random_return(random_return(environment, RANDOM))
    with served(app) as url, Client(url, TOKEN) as client:
        sweep = client.submit(SWEEP)
        usual = getattr(client, asked)

        def interrupted(*args: Any, **kwargs: Any) -> Any:
            answer = usual(*args, **kwargs)
            train(store, 5, rising)  # the first time: then nothing waits any more
            return answer

        monkeypatch.setattr(client, asked, interrupted)
        swept = Swept.of(client, sweep)
        assert swept.sweep.runs.succeeded == len(swept.runs) == 12
        assert {run.status for run in swept.runs} == {"succeeded"}
        assert {len(rows) for rows in swept.rows.values()} == {5}
        assert swept.statistics == client.statistics(sweep.id).model_dump(mode="json")
