"""Places: what an operator may name, and that a run's name leads nowhere else."""

from pathlib import Path

import pytest

from workers.checkpoints import place as module
from workers.checkpoints.bucket_folder import BucketFolder
from workers.checkpoints.disk_folder import DiskFolder
from workers.checkpoints.place import folder_in, place_of


def test_a_path_is_a_folder_of_a_disk(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    assert place_of("a/b") == tmp_path / "a" / "b"
    assert place_of("/mnt/shared") == place_of("file:///mnt/shared") == Path("/mnt/shared")
    assert isinstance(folder_in(place_of("/mnt/shared"), "run-3"), DiskFolder)


@pytest.mark.parametrize("url", ["s3://runs", "s3://my.runs-1/lab/d3pg", "s3://runs/a_b.c"])
def test_a_url_is_a_bucket_with_or_without_a_prefix(url: str) -> None:
    assert place_of(url) == place_of(f"{url}/") == url
    assert isinstance(folder_in(place_of(url), "run-3"), BucketFolder)


@pytest.mark.parametrize(
    "text",
    [
        *("s3://", "s3://a", "s3:///prefix", "s3://Runs", "s3://runs//d3pg", "s3://runs/*"),
        *("s3://key:secret@runs", "s3://runs/d3pg?secret=1", "s3://runs/a b", "gs://runs"),
        *("file://host/path", "https://s3.example.org/runs", "memory://runs"),
    ],
)
def test_what_is_neither_is_refused_and_not_repeated(text: str) -> None:
    with pytest.raises(ValueError, match=r"s3://BUCKET/PREFIX.*AWS_ACCESS_KEY_ID") as refusal:
        place_of(text)
    assert "secret" not in str(refusal.value)


def test_without_s3fs_a_bucket_is_refused(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(module, "find_spec", lambda name: None)
    with pytest.raises(ValueError, match=r"pip install 'd3pg\[s3\]'"):
        place_of("s3://runs")
    place_of("/mnt/shared")


@pytest.mark.parametrize("name", ["", "..", "a/b", "/etc"])
@pytest.mark.parametrize("place", [Path("/mnt"), "s3://runs"])
def test_a_runs_name_is_no_path(place: module.Place, name: str) -> None:
    with pytest.raises(ValueError, match="must not be a path"):
        folder_in(place, name)
