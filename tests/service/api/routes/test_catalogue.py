"""The catalogue says all that a submission can be made of."""

import pytest
from starlette.testclient import TestClient

import physics
from algorithms import catalogue
from physics.catalogue import OWN


def test_everything_that_is_there_is_listed(idle_client: TestClient) -> None:
    answer = idle_client.get("/api/v1/catalogue").json()
    assert [each["name"] for each in answer["environments"]] == physics.names()
    assert [each["name"] for each in answer["algorithms"]] == catalogue.names()
    assert answer["limits"]["runs"] >= 10_000
    for algorithm in answer["algorithms"]:
        schema = algorithm["config_schema"]["properties"]
        assert schema["hidden_units"]["minimum"] == 4
        assert all(setting["description"] for setting in schema.values())


def test_an_installed_task_that_cannot_be_made_is_left_out_and_explained(
    idle_client: TestClient, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Its author is told why on submitting; nobody else loses the catalogue."""
    others = physics.names()
    monkeypatch.setattr("physics.catalogue.OWN", OWN | {"Broken": "no_such_module:Broken"})
    answer = idle_client.get("/api/v1/catalogue")
    assert answer.status_code == 200
    assert [each["name"] for each in answer.json()["environments"]] == others
    body = {"algorithms": [{"name": "ddpg"}], "environments": ["Broken"], "seeds": 1}
    refused = idle_client.post("/api/v1/sweeps?dry_run=true", json=body)
    assert refused.status_code == 422
    assert "Broken (no_such_module:Broken) cannot be made: ModuleNotFoundError" in refused.text


def test_every_environment_carries_its_gradient_audit(idle_client: TestClient) -> None:
    answer = idle_client.get("/api/v1/catalogue").json()
    ours = [environment for environment in answer["environments"] if environment["name"] in OWN]
    assert len(ours) == len(OWN)
    for environment in ours:
        rows = environment["audit"]
        assert [row["regime"] for row in rows] == environment["regimes"] != []
        assert all(row["passed"] for row in rows)
        assert all(row["states"] >= 2000 and 0.0 < row["worst"] <= 1e-6 for row in rows)


def test_what_is_listed_can_be_submitted(idle_client: TestClient) -> None:
    answer = idle_client.get("/api/v1/catalogue").json()
    for algorithm in answer["algorithms"]:
        body = {
            "algorithms": [{"name": algorithm["name"]}],
            "environments": list(algorithm["presets"]),
            "seeds": 1,
        }
        cells = idle_client.post("/api/v1/sweeps?dry_run=true", json=body).json()["cells"]
        for cell in cells:
            preset = algorithm["presets"][cell["environment"]]
            assert preset == {key: cell[key] for key in ("weights", "timesteps", "config")}


def test_everything_is_described(idle_client: TestClient) -> None:
    answer = idle_client.get("/api/v1/catalogue").json()
    said = {each["name"]: each["description"] for each in answer["environments"]}
    assert said["Pendulum"].startswith(
        "The pendulum, hanging or turning at the start.\n\nPendulum: "
    )
    assert "\n    omega' = " in said["Pendulum"].replace("  = ", " = ")
    assert all("\n\n" in said[name] for name in OWN)
    said = {each["name"]: each["description"] for each in answer["algorithms"]}
    assert said["ddpg"].startswith("DDPG: deep deterministic policy gradients")
    assert all(said.values())
