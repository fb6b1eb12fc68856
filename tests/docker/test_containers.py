"""The containers of `docker/compose.yml`, really run: `make containers`.

The image is built from nothing, then a sweep is trained undisturbed, and again while a container is
killed, the stack restarted or the workers scaled: the curves are the same to the bit.
"""

import json
import time
from collections.abc import Callable, Iterator
from importlib.util import find_spec
from pathlib import Path
from typing import Any

import pytest

from tests.docker.engine import can_run, engine_in
from tests.docker.stack import SECRETS, Stack
from tests.end_to_end.curves import Curves, curves_at_the_end, report, wait_for

pytestmark = [
    pytest.mark.slow,
    pytest.mark.skipif(
        not (can_run() and find_spec("podman_compose")), reason="make containers installs podman"
    ),
]

SWEEP: dict[str, Any] = {  # two cohorts for two workers
    "name": "in containers",
    "algorithms": [{"name": "ddpg"}, {"name": "hybrid-ddpg", "weights": [{"w1": 0.1, "w2": 0.1}]}],
    "environments": ["Pendulum"],
    "seeds": 2,
    "timesteps": 16_000,
}
CONTAINERS = ("head", "worker", "driver", "service", "database")


@pytest.fixture(scope="module")
def stack(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Stack]:
    begun = time.monotonic()
    with engine_in(tmp_path_factory.mktemp("engine")) as engine:
        tell("images made", begun)
        stack = Stack(engine, tmp_path_factory.mktemp("project"))
        begun = time.monotonic()
        with stack.client:
            stack.up()
            tell("two workers, driver, service and database up", begun)
            yield stack


@pytest.fixture(scope="module")
def undisturbed(stack: Stack) -> Curves:
    begun = time.monotonic()
    curves = curves_at_the_end(stack.client, stack.client.submit(SWEEP).id)
    tell("sweep trained", begun)
    return curves


def tell(event: str, since: float) -> None:
    report(f"{event} after", time.monotonic() - since, "s")


def survived(stack: Stack, undisturbed: Curves, event: str, disturb: Callable[[], None]) -> str:
    """Disturb a sweep in training; its curves do not show it. Its id."""
    client = stack.client
    sweep_id = client.submit(SWEEP).id
    wait_for(lambda: any(run.timestep >= 800 for run in client.runs(sweep_id)))
    begun = time.monotonic()
    disturb()
    stack.wait_until_ready()
    tell(f"{event}: ready again", begun)
    assert curves_at_the_end(client, sweep_id) == undisturbed
    tell(f"{event}: sweep trained", begun)
    return sweep_id


def test_a_sweep_trains_and_every_health_check_passes(stack: Stack, undisturbed: Curves) -> None:
    assert len(undisturbed) == 4
    wait_for(lambda: all(stack.is_healthy(stack.name(each)) for each in CONTAINERS), 120.0)


def test_a_task_with_ray_s_token_finds_no_other_secret_on_any_node(stack: Stack) -> None:
    reversed_secrets = {name: secret[::-1] for name, secret in stack.secrets.items()}
    addresses = ["database:5432", f"{stack.address(stack.name('database'), 'storage')}:5432"]
    addresses += ["service:8000", "head:6379"]
    code = Path(__file__).with_name("what_a_task_can_read.py").read_text()
    printed = stack.run_inside(
        stack.name("worker"), code, [json.dumps(reversed_secrets), json.dumps(addresses)]
    )
    nodes = json.loads(printed.splitlines()[-1])
    assert len(nodes) == 4, "head, two workers, driver"
    for node in nodes:
        assert node["holding"].keys() == set(SECRETS)
        assert node["holding"]["ray_token"], "it looks where secrets are"
        assert node["holding"]["token"] == node["holding"]["database_password"] == []
        allowed = ("/data/checkpoints", "/data/logs")
        assert all(path.startswith(allowed) for path in node["data"])
        assert node["reached"] == ["head:6379"]


@pytest.mark.parametrize("name", CONTAINERS)
def test_a_container_is_killed(stack: Stack, undisturbed: Curves, name: str) -> None:
    survived(stack, undisturbed, f"{name} killed", lambda: stack.kill(stack.name(name)))


def test_the_stack_is_restarted(stack: Stack, undisturbed: Curves) -> None:
    def restart() -> None:
        stack.compose("down")
        stack.up()

    survived(stack, undisturbed, "stack restarted", restart)


def test_workers_are_scaled(stack: Stack, undisturbed: Curves) -> None:
    survived(stack, undisturbed, "scaled to three workers", lambda: stack.up(workers=3))
    wait_for(lambda: stack.is_healthy(stack.name("worker", 3)), 120.0)

    def remove() -> None:
        stack.engine.run("rm", "--force", *(stack.name("worker", number) for number in (2, 3)))

    survived(stack, undisturbed, "scaled to one", remove)


def test_a_backup_is_restored_into_an_empty_project(stack: Stack, undisturbed: Curves) -> None:
    client = stack.client
    sweep_id = client.submit(SWEEP).id
    assert curves_at_the_end(client, sweep_id) == undisturbed
    [run, *_] = client.runs(sweep_id)
    policy = client.policy_file(run.id)
    dump = stack.compose("exec", "-T", "database", "pg_dump", "-U", "d3pg", "-Fc", "d3pg")
    tar = ("tar", "-C", "/data")
    files = stack.compose("exec", "-T", "service", *tar, "-c", "checkpoints")
    stack.compose("down", "--volumes")
    stack.up()
    assert not list(client.sweeps())
    stack.compose("stop", "service")
    restore = ("pg_restore", "-U", "d3pg", "-d", "d3pg", "--clean", "--if-exists")
    stack.compose("exec", "-T", "database", *restore, content=dump)
    stack.compose("run", "--rm", "--no-deps", "-T", "service", *tar, "-x", content=files)
    stack.compose("start", "service")
    stack.wait_until_ready()
    assert curves_at_the_end(client, sweep_id) == undisturbed
    assert client.policy_file(run.id) == policy
