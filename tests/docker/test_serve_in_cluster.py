"""`docker/serve-in-cluster`, with stand-ins for `ray` and `d3pg`."""

import os
import signal
import subprocess
from pathlib import Path

SCRIPT = Path(__file__).parents[2] / "docker" / "serve-in-cluster"
RAY = 'echo "$@" >>"$HOME/nodes"\nexec sleep 0.05\n'  # a node that its head leaves at once
D3PG = 'while [ "$(wc -l <"$HOME/nodes" || echo 0)" -lt 3 ]; do sleep 0.05; done\necho "$@"\n'


def put(path: Path, text: str, mode: int = 0o644) -> None:
    path.parent.mkdir(exist_ok=True)
    path.write_text(text)
    path.chmod(mode)


def serve(folder: Path) -> str:
    """Run the script in that folder and return what `d3pg` was called with."""
    put(folder / "bin" / "ray", f"#!/bin/sh\n{RAY}", 0o755)
    put(folder / "bin" / "d3pg", f"#!/bin/sh\n{D3PG}", 0o755)
    put(folder / "secrets" / "token", "a token of the operator's\n")
    (folder / "data").mkdir()
    (folder / "nodes").touch()
    process = subprocess.Popen(
        [SCRIPT, folder / "secrets"],
        env={
            "PATH": f"{folder / 'bin'}:{os.environ['PATH']}",
            "HOME": str(folder),
            "D3PG_DATA_DIR": str(folder / "data"),
            "D3PG_RAY_ADDRESS": "head:6379",
        },
        stdout=subprocess.PIPE,
        text=True,
        start_new_session=True,
    )
    try:
        assert process.stdout is not None
        return process.stdout.readline()
    finally:
        os.killpg(process.pid, signal.SIGKILL)  # the node as well, as the container's end does
        process.communicate()


def test_the_node_has_no_cores_and_is_started_as_often_as_it_ends(tmp_path: Path) -> None:
    assert serve(tmp_path) == "serve\n"
    nodes = (tmp_path / "nodes").read_text().splitlines()
    assert len(nodes) >= 3
    assert all("--address=head:6379 --num-cpus=0" in node for node in nodes)


def test_the_token_is_in_the_data_folder_for_its_owner_alone(tmp_path: Path) -> None:
    serve(tmp_path)
    token = tmp_path / "data" / "token"
    assert token.read_text() == "a token of the operator's\n"
    assert token.stat().st_mode & 0o777 == 0o600
    assert not (tmp_path / ".pgpass").exists()


def test_the_database_password_is_where_psycopg_looks(tmp_path: Path) -> None:
    put(tmp_path / "secrets" / "database_password", "a:b\\c\n")
    serve(tmp_path)
    file = tmp_path / ".pgpass"
    assert file.read_text() == "*:*:*:*:a\\:b\\\\c\n"
    assert file.stat().st_mode & 0o777 == 0o600
