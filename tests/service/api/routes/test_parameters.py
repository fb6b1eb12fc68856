"""Sweeps over physical parameters: how they are asked for, expanded and refused."""

from typing import Any

import pytest
from starlette.testclient import TestClient

from tests.service.conftest import changed

GRAVITIES: dict[str, Any] = {"name": "Pendulum", "parameters": {"gravity": [8, 9.81], "mass": 2}}


def cells(client: TestClient, **fields: Any) -> list[tuple[str, str]]:
    answer = client.post("/api/v1/sweeps?dry_run=true", json=changed(**fields))
    assert answer.status_code == 200, answer.text
    return [(cell["environment"], cell["label"]) for cell in answer.json()["cells"]]


def refusals(client: TestClient, **fields: Any) -> dict[str, str]:
    answer = client.post("/api/v1/sweeps", json=changed(**fields))
    assert answer.status_code == 422, answer.text
    return {error["field"]: error["message"] for error in answer.json()["errors"]}


def test_lists_of_values_are_a_grid(client: TestClient) -> None:
    asked = [{"name": "ddpg"}]
    grid = {"name": "Pendulum", "parameters": {"gravity": [8, 9.81], "length": [1, 0.7]}}
    assert cells(client, algorithms=asked, environments=[grid, "MassPoint"]) == [
        ("Pendulum(gravity=8, length=1)", "ddpg"),
        ("Pendulum(gravity=8, length=0.7)", "ddpg"),
        ("Pendulum(gravity=9.81, length=1)", "ddpg"),
        ("Pendulum(gravity=9.81, length=0.7)", "ddpg"),
        ("MassPoint", "ddpg"),
    ]


def test_a_sweep_keeps_each_point_as_an_environment(client: TestClient) -> None:
    sweep = client.post("/api/v1/sweeps", json=changed(environments=[GRAVITIES])).json()
    points = ["Pendulum(gravity=8, mass=2)", "Pendulum(gravity=9.81, mass=2)"]
    assert sweep["request"]["environments"] == points
    runs = client.get(sweep["links"]["runs"]).json()["items"]
    assert list(dict.fromkeys(run["environment"] for run in runs)) == points
    assert {run["environment_version"] for run in runs} == {1}
    query = {"environment": points[0]}
    some = client.get(sweep["links"]["runs"], params=query).json()["items"]
    assert len(some) == len(runs) // 2


def test_values_may_follow_the_name(client: TestClient) -> None:
    asked = [{"name": "ddpg", "environments": ["Pendulum(gravity=9.81)"]}]
    assert cells(
        client, algorithms=asked, environments=["Pendulum( gravity = 9.810 )", "MassPoint"]
    ) == [("Pendulum(gravity=9.81)", "ddpg")]


def test_an_algorithm_may_run_in_a_part_of_the_grid(client: TestClient) -> None:
    part = {"name": "Pendulum", "parameters": {"gravity": 8, "mass": 2}}
    asked = [{"name": "ddpg", "environments": [part]}, {"name": "sac"}]
    assert cells(client, algorithms=asked, environments=[GRAVITIES]) == [
        ("Pendulum(gravity=8, mass=2)", "ddpg"),
        ("Pendulum(gravity=8, mass=2)", "sac"),
        ("Pendulum(gravity=9.81, mass=2)", "sac"),
    ]


@pytest.mark.parametrize(
    ("environments", "field", "message"),
    [
        (
            [{"name": "Pendulum", "parameters": {"gravty": 1}}],
            "environments[0]",
            "Pendulum: there is no parameter 'gravty'; did you mean 'gravity'? (known: gravity, l",
        ),
        (
            ["MassPoint", {"name": "Pendulum", "parameters": {"gravity": [8, -1]}}],
            "environments[2]",
            "Pendulum: gravity must be a number from 0 to 100 m/s^2, not -1.0",
        ),
        (
            [{"name": "Pendulun", "parameters": {"gravity": 8}}],
            "environments[0]",
            "unknown environment 'Pendulun'; did you mean 'Pendulum'?",
        ),
        (
            ["Pendulum", {"name": "Pendulum", "parameters": {"gravity": [8, 10]}}],
            "environments[2]",
            "is the same as environments[0]",
        ),
        (
            [{"name": "Pendulum", "parameters": {"gravity": [8, 8.0]}}],
            "environments[1]",
            "is the same as environments[0]",
        ),
        (
            [{"name": "Pendulum", "parameters": {"gravity": list(range(90)), "mass": [1, 2]}}],
            "environments",
            "are 180 with their grids; at most 100 are allowed",
        ),
        (
            [{"name": "Pendulum", "parameters": {"gravity": []}}],
            "environments[0].parameters.gravity",
            "at least 1 item",
        ),
        (
            [{"name": "Pendulum", "parameters": {"gravity": "9"}}],
            "environments[0].parameters.gravity",
            "valid number",
        ),
        ([{"name": "Pendulum", "values": {}}], "environments[0].values", "is not known"),
        ([7], "environments[0]", "valid string"),
    ],
)
def test_what_cannot_be_is_refused_by_field(
    idle_client: TestClient, environments: list[Any], field: str, message: str
) -> None:
    assert message in refusals(idle_client, environments=environments)[field]
