"""The task shelf: what a service serves of task files, keeps of them and refuses."""

import json
import sys
from collections.abc import Iterator
from functools import partial
from pathlib import Path

import pytest
from fastapi import FastAPI
from starlette.testclient import TestClient

import algorithms
from physics.task_file import TaskFile
from service.api.load.side_process import SideProcess
from service.bootstrap import filled_shelf, wired
from service.model.environment import (
    best_return,
    environment_facts,
    facts_of_file,
    know_tasks_of_packages,
)
from service.queue.dispatch import Dispatcher
from service.settings import Settings
from service.store.store import Store
from service.task_shelf import TaskFileError, TaskShelf
from tests.installed_package import install
from tests.physics.test_task_file import ANOTHER, ARM
from tests.service.conftest import changed
from tests.service.fake_pool import FakePool
from tests.workers.policies.test_rollout import write_policy
from workers.messages.work import Work


@pytest.fixture
def file(tmp_path: Path) -> Path:
    path = tmp_path / "my_tasks.py"
    path.write_text(ARM)
    return path


@pytest.fixture
def shelf(tmp_path: Path) -> Iterator[TaskShelf]:
    yield TaskShelf(tmp_path)
    TaskShelf(tmp_path / "empty")  # what a process knows is that of its last shelf


@pytest.fixture
def serving(client: TestClient, app: FastAPI, shelf: TaskShelf, file: Path) -> TestClient:
    shelf.serve([file], facts_of_file)
    app.state.shelf = shelf
    return client


def complaint(client: TestClient, environment: str) -> str:
    answer = client.post("/api/v1/sweeps", json=changed(environments=[environment]))
    assert answer.status_code == 422
    (error,) = answer.json()["errors"]
    assert error["field"] == "environments[0]"
    return str(error["message"])


def test_a_task_of_a_file_is_in_the_catalogue(serving: TestClient) -> None:
    *_, arm = serving.get("/api/v1/catalogue").json()["environments"]
    assert (arm["name"], arm["file"], arm["horizon"]) == ("Arm", "my_tasks.py", 50)
    assert arm["parameters"] == [
        {
            "name": "stiffness", "unit": "N/m", "default": 1.0, "least": 0.0, "greatest": 10.0,
            "meaning": "",
        }
    ]  # fmt: skip


def test_its_file_goes_with_the_work(
    serving: TestClient, store: Store, shelf: TaskShelf, file: Path
) -> None:
    given: list[Work] = []

    class Pool(FakePool):
        def train(self, worker: str, work: Work) -> None:
            given.append(Work.from_json(json.loads(json.dumps(work.to_json()))))
            super().train(worker, work)

    body = changed(environments=["Arm", "Pendulum"], seeds=1)
    assert serving.post("/api/v1/sweeps", json=body).status_code == 202
    dispatcher = Dispatcher(store, Pool(), file_of=shelf.file_of)
    while len(given) < 4:
        dispatcher.work_round()
    files = {work.specs[0].environment: work.file for work in given}
    assert files == {"Arm": TaskFile.read(file), "Pendulum": None}


def test_what_is_learned_on_it_is_had_as_a_policy(
    serving: TestClient, settings: Settings, shelf: TaskShelf, file: Path
) -> None:
    body = changed(environments=["Arm(stiffness=2)"], algorithms=[{"name": "ddpg"}], seeds=1)
    sweep = serving.post("/api/v1/sweeps", json=body).json()["id"]
    write_policy(settings.checkpoint_place, f"{sweep}-0", f"{file}:Arm")
    answer = serving.get(f"/api/v1/runs/{sweep}-0/policy")
    assert answer.status_code == 200, answer.text
    header = algorithms.load_policy(answer.content).header
    assert (header.task, header.parameters) == ("Arm", {"stiffness": 2.0})
    assert header.task_version == environment_facts("Arm").version
    assert serving.get(f"/api/v1/runs/{sweep}-0/rollout").status_code == 200


def test_a_changed_file_is_a_new_version_and_the_old_one_is_kept(
    shelf: TaskShelf, file: Path, tmp_path: Path
) -> None:
    shelf.serve([file], facts_of_file)
    before = environment_facts("Arm").version
    file.write_text(ARM.replace("horizon = 50", "horizon = 60"))
    again = TaskShelf(tmp_path)
    again.serve([file], facts_of_file)
    facts = environment_facts("Arm(stiffness=2)")
    assert (facts.horizon, facts.version != before) == (60, True)
    kept = again.file_of("Arm(stiffness=2)", before)
    assert kept is not None
    assert kept.source == ARM
    assert again.file_of("Arm", 1) is None


def test_a_task_that_is_served_no_more_is_known_but_not_submitted(
    serving: TestClient, tmp_path: Path
) -> None:
    TaskShelf(tmp_path)
    assert best_return("Arm") == 0.0
    assert "start it with --tasks my_tasks.py" in complaint(serving, "Arm")
    names = [each["name"] for each in serving.get("/api/v1/catalogue").json()["environments"]]
    assert "Arm" not in names


@pytest.mark.parametrize(
    ("environment", "message"),
    [
        ("Arms", "unknown environment 'Arms'; did you mean 'Arm'?"),
        ("Arm(stifness=1)", "there is no parameter 'stifness'; did you mean 'stiffness'?"),
        ("Arm(stiffness=11)", "Arm: stiffness must be a number from 0 to 10 N/m, not 11.0"),
        ("Arm(stiffness)", "expected name=number, each name once, not 'stiffness'"),
        (
            "my_tasks.py:Arm",
            "goes by its own name, such as 'Arm', in a service that was started with --tasks",
        ),
        ("/etc/passwd.py", "a task of a file goes by its own name"),
    ],
)
def test_what_is_not_served_is_refused(serving: TestClient, environment: str, message: str) -> None:
    assert message in complaint(serving, environment)


def test_a_name_is_taken_once(shelf: TaskShelf, file: Path, tmp_path: Path) -> None:
    other = tmp_path / "others.py"
    other.write_text(ARM)
    with pytest.raises(TaskFileError, match=r"others.py: the name 'Arm' is taken by another task"):
        shelf.serve([file, other], facts_of_file)
    other.write_text((ARM + ANOTHER).replace('"long-arm"', '"Pendulum"'))
    with pytest.raises(TaskFileError, match="the name 'Pendulum' is taken by an installed task"):
        shelf.serve([other], facts_of_file)


@pytest.mark.parametrize(
    ("code", "message"),
    [
        (ARM, ""),
        ("1 / 0", r"Arm \(arm:Arm\) cannot be made: ZeroDivisionError: division by zero"),
        ("import os\nos._exit(1)", "Arm cannot be loaded: the process that ran it died"),
    ],
)
def test_a_package_is_run_by_another_process(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, code: str, message: str
) -> None:
    project = '[project.entry-points."d3pg.environments"]\nArm = "arm:Arm"\n'
    (tmp_path / "package").mkdir()
    install(tmp_path / "package", "arm", code, project, monkeypatch)
    filled_shelf(Settings(data_dir=tmp_path / "data"))
    if message:
        with pytest.raises(ValueError, match=message):
            environment_facts("Arm")
    else:
        assert environment_facts("Arm(stiffness=2)").horizon == 50
    assert "arm" not in sys.modules
    know_tasks_of_packages({})


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("1 / 0\n", r"my_tasks.py, line 1: ZeroDivisionError: division by zero$"),
        ("import os\nos._exit(1)\n", "my_tasks.py cannot be loaded: the process that ran it died"),
        ("while True:\n    pass\n", "my_tasks.py cannot be loaded: it took longer than 0.5 s"),
    ],
)
@pytest.mark.usefixtures("shelf")
def test_a_service_does_not_start_with_a_file_that_cannot_be_loaded(
    file: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, text: str, message: str
) -> None:
    file.write_text(text)
    if "while" in text:
        monkeypatch.setattr(
            "service.bootstrap.SideProcess", partial(SideProcess, limit_seconds=0.5)
        )
    settings = Settings(data_dir=tmp_path / "data", tasks=(file,))
    with pytest.raises(TaskFileError, match=message), wired(settings):
        pass
