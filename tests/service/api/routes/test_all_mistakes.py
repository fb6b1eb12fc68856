"""All mistakes of a submission are told at once: of form, of names, of values."""

from typing import Any

import pytest
from starlette.testclient import TestClient

from tests.service.conftest import changed

Json = dict[str, Any]


def told(client: TestClient, body: Json) -> dict[str, str]:
    answer = client.post("/api/v1/sweeps", json=body)
    assert answer.status_code == 422, answer.text
    errors = answer.json()["errors"]
    assert len({error["field"] for error in errors}) == len(errors)
    return {error["field"]: error["message"] for error in errors}


def test_mistakes_of_form_hide_no_others(idle_client: TestClient) -> None:
    body = {
        "algoritms": [],
        "algorithms": [
            {"name": "dppg"},
            {"name": "ddpg", "wieghts": {}, "config": {"noise": 7, "tua": 1}},
            {"name": "hybrid-ddpg", "weights": {"w1": -1, "w3": 1}, "config": {"tau": "x"}},
            {"name": 3, "config": {"noise": 7}},
        ],
        "environments": ["Pendulm", "Pendulum", "Pendulum"],
        "seeds": -1,
    }
    found = told(idle_client, body)
    assert set(found) == {
        "algoritms",
        "algorithms[0].name",
        "algorithms[1].wieghts",
        "algorithms[1].config.noise",
        "algorithms[1].config.tua",
        "algorithms[2].weights.w1",
        "algorithms[2].weights.w3",
        "algorithms[2].config.tau",
        "algorithms[3].name",
        "environments[0]",
        "environments[2]",
        "seeds",
    }
    assert "did you mean 'algorithms'?" in found["algoritms"]
    assert "did you mean 'weights'?" in found["algorithms[1].wieghts"]
    assert "did you mean" in found["algorithms[2].weights.w3"]


@pytest.mark.parametrize(
    ("fields", "fields_told"),
    [
        ({"algorithms": None}, {"algorithms", "environments[0]", "seeds[2]"}),
        ({"algorithms": "ddpg"}, {"algorithms", "environments[0]", "seeds[2]"}),
        ({"algorithms": ["ddpg"]}, {"algorithms[0]", "environments[0]", "seeds[2]"}),
        ({"algorithms": [{}]}, {"algorithms[0].name", "environments[0]", "seeds[2]"}),
        ({"environments": [7]}, {"environments[0]", "seeds[2]"}),
        ({"name": ""}, {"name", "environments[0]", "seeds[2]"}),
        (
            {"timesteps": 0, "algorithms": [{"name": "sac", "environments": ["Nope"]}]},
            {"timesteps", "algorithms[0].environments[0]", "environments[0]", "seeds[2]"},
        ),
        (
            {"seeds": "x", "algorithms": [{"name": "sac", "zip": ["rate", "tau"]}]},
            {"seeds", "algorithms[0].zip[0]", "algorithms[0].zip[1]", "environments[0]"},
        ),
    ],
)
def test_whatever_the_form_is_wrong_in(
    idle_client: TestClient, fields: Json, fields_told: set[str]
) -> None:
    body = changed(environments=["Pendulm"], seeds=[1, 2, 1]) | fields
    if body["algorithms"] is None:
        del body["algorithms"]
    assert set(told(idle_client, body)) == fields_told


def test_unknown_fields_of_any_request_come_with_the_nearest(client: TestClient) -> None:
    sweep_id = client.post("/api/v1/sweeps", json=changed()).json()["id"]
    link = f"/api/v1/sweeps/{sweep_id}"
    for answer in (
        client.patch(link, json={"nmae": "x"}),
        client.get("/api/v1/sweeps?statsu=running"),
        client.get(f"{link}/runs?statsu=running"),
        client.get(f"{link}/curves?metrc=return_mean"),
    ):
        assert answer.status_code == 422
        assert "did you mean" in answer.json()["errors"][0]["message"]
