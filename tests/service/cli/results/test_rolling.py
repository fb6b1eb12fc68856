"""A policy as moving pictures."""

from pathlib import Path

import pytest
from PIL import Image

from service.client import Client, ServiceError
from service.settings import Settings
from tests.service.cli.conftest import Command, as_json
from tests.service.conftest import changed
from tests.workers.policies.test_rollout import write_policy


@pytest.fixture
def run(service: Client) -> str:
    body = changed(seeds=1, environments=["MassPoint"], algorithms=[{"name": "ddpg"}])
    return next(service.runs(service.submit(body).id)).id


def test_a_gif_and_frames(d3pg: Command, run: str, settings: Settings, tmp_path: Path) -> None:
    write_policy(settings.checkpoint_place, run, "MassPoint")
    file, folder = tmp_path / "episode.gif", tmp_path / "frames"
    said = d3pg("rollout", run, "-o", str(file)).stdout
    assert "in MassPoint: return" in said
    episode = as_json(d3pg("rollout", run, "--json"))
    with Image.open(file) as gif:
        assert getattr(gif, "n_frames") > 1  # noqa: B009 - Pillow declares it for no format
        assert gif.info["duration"] == 40
    d3pg("rollout", run, "-o", str(folder))
    assert len(list(folder.glob("*.png"))) == len(episode["frames"])


def test_without_a_policy_it_says_so(d3pg: Command, run: str) -> None:
    refusal = d3pg("rollout", run, code=1).exception
    assert isinstance(refusal, ServiceError)
    assert "has no policy" in str(refusal)


def test_a_film_is_a_gif_or_a_folder(d3pg: Command) -> None:
    assert ".gif" in d3pg("rollout", "a-1", "-o", "film.mp4", code=2).stderr
