"""`docker/serve-d3pg` and `docker/drive-ray`, with stand-ins for what they start."""

import os
import signal
import subprocess
from pathlib import Path

import pytest

from workers.driver.settings import DriverSettings

DOCKER = Path(__file__).parents[2] / "docker"
NODE = 'echo "$@" >>"$HOME/nodes"\nexec sleep 0.05\n'  # a node that its head leaves at once
DRIVER = 'echo "$@"\n'  # a process that a service closes at once


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    """What a container has: programs, secrets, and a data folder."""
    put(tmp_path / "bin" / "d3pg", '#!/bin/sh\necho "$@"\n', 0o755)
    put(tmp_path / "bin" / "ray", f"#!/bin/sh\n{NODE}", 0o755)
    put(tmp_path / "bin" / "python", f"#!/bin/sh\n{DRIVER}", 0o755)
    put(tmp_path / "secrets" / "token", "a token of the operator's\n")
    (tmp_path / "data").mkdir()
    return tmp_path


def put(path: Path, text: str, mode: int = 0o644) -> None:
    path.parent.mkdir(exist_ok=True)
    path.write_text(text)
    path.chmod(mode)


def started(folder: Path, script: str, *arguments: str) -> "subprocess.Popen[str]":
    return subprocess.Popen(
        [DOCKER / script, *arguments],
        env={
            "PATH": f"{folder / 'bin'}:{os.environ['PATH']}",
            "HOME": str(folder),
            "D3PG_DATA_DIR": str(folder / "data"),
        },
        stdout=subprocess.PIPE,
        text=True,
        start_new_session=True,
    )


def serve(folder: Path) -> str:
    """Run the script and return what `d3pg` was called with."""
    return started(folder, "serve-d3pg", str(folder / "secrets")).communicate(timeout=30)[0]


def test_the_token_is_in_the_data_folder_for_its_owner_alone(folder: Path) -> None:
    assert serve(folder) == "serve\n"
    token = folder / "data" / "token"
    assert token.read_text() == "a token of the operator's\n"
    assert token.stat().st_mode & 0o777 == 0o600
    assert not (folder / ".pgpass").exists()


def test_the_database_password_is_where_psycopg_looks(folder: Path) -> None:
    put(folder / "secrets" / "database_password", "a:b\\c\n")
    serve(folder)
    file = folder / ".pgpass"
    assert file.read_text() == "*:*:*:*:a\\:b\\\\c\n"
    assert file.stat().st_mode & 0o777 == 0o600


def test_node_and_driver_are_started_as_often_as_they_end_and_end_with_the_script(
    folder: Path,
) -> None:
    process = started(folder, "drive-ray", "head:6379", "/run/d3pg")
    try:
        assert process.stdout is not None
        words = [process.stdout.readline().split() for _ in range(2)]
        process.send_signal(signal.SIGTERM)
        assert process.wait(30.0) == 143
    finally:
        os.killpg(process.pid, signal.SIGKILL)  # the node as well, as the container's end does
        process.communicate()
    settings = [DriverSettings.from_arguments(each[2:]) for each in words]
    assert [each[:2] for each in words] == 2 * [["-m", "workers"]]
    assert all(each.stands_alone for each in settings)
    assert {each.socket for each in settings} == {Path("/run/d3pg/pool.sock")}
    assert len({each.scratch for each in settings}) == 2
    nodes = (folder / "nodes").read_text().splitlines()
    assert len(nodes) >= 2, "it takes a second until the driver is started again"
    assert all("--address=head:6379 --num-cpus=0" in node for node in nodes)
