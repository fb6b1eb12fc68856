"""Pictures of tasks: each draws itself, in the process beside the service."""

from pathlib import Path

import pytest
from fastapi import FastAPI
from starlette.testclient import TestClient

import physics
from service.model.environment import facts_of_file
from tests.service.conftest import changed, client_of

TASK = """
from physics.tasks.mass_point import MassPoint

class Shy(MassPoint):
    name = "Shy"
    def draw(self, state):
        raise RuntimeError("not today")
"""


@pytest.mark.parametrize("environment", [*physics.names(), "Pendulum(length=2)"])
def test_a_task_is_drawn_at_a_start(idle_client: TestClient, environment: str) -> None:
    answer = idle_client.get(f"/api/v1/environments/{environment}/picture")
    assert answer.status_code == 200, answer.text
    picture = answer.json()
    [frame], [view] = picture["frames"], picture["views"]
    assert frame
    assert {style for style, *_ in frame} == set(range(len(picture["styles"])))
    assert view[0] < view[2]
    assert view[1] < view[3]


def test_a_browser_that_has_it_need_not_have_it_again(idle_client: TestClient) -> None:
    url = "/api/v1/environments/MassPoint/picture"
    tag = idle_client.get(url).headers["etag"]
    assert idle_client.get(url, headers={"If-None-Match": tag}).status_code == 304


def test_an_unknown_task_is_not_found(idle_client: TestClient) -> None:
    answer = idle_client.get("/api/v1/environments/Pendulun/picture")
    assert answer.status_code == 404
    assert "Pendulum" in answer.json()["detail"]


def test_a_task_that_cannot_draw_itself_says_why(
    app: FastAPI, client: TestClient, tmp_path: Path
) -> None:
    file = tmp_path / "shy.py"
    file.write_text(TASK)
    app.state.shelf.serve([file], facts_of_file)
    answer = client.get("/api/v1/environments/Shy/picture")
    assert answer.status_code == 409
    assert answer.json()["detail"] == "Shy cannot be drawn: RuntimeError: not today."


def test_a_guest_sees_the_tasks_of_what_is_shared(app: FastAPI, client: TestClient) -> None:
    task = "Pendulum(length=2)"
    sweep = client.post("/api/v1/sweeps", json=changed(environments=[task])).json()
    share = client.post("/api/v1/shares", json={"sweeps": [sweep["id"]]}).json()
    guest = client_of(app, token="")
    guest.post("/signin", data={"token": share["link"].partition("#share=")[2]})
    names = [each["name"] for each in guest.get("/api/v1/catalogue").json()["environments"]]
    assert names == ["Pendulum"]
    assert guest.get(f"/api/v1/environments/{task}/picture").status_code == 200
    assert guest.get("/api/v1/environments/Acrobot/picture").status_code == 404
