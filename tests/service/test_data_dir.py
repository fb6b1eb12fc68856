"""The data directory: its user's alone, whoever made it."""

from contextlib import ExitStack
from pathlib import Path

import pytest

from service.data_dir import make_private, owned
from service.refusal import RefusalError
from service.store.store import Store


def mode(path: Path) -> int:
    return path.stat().st_mode & 0o777


def test_it_is_made_for_its_user_alone(tmp_path: Path) -> None:
    with owned(tmp_path / "new" / "data"):
        assert mode(tmp_path / "new" / "data") == 0o700


def test_one_that_others_can_enter_is_closed_and_it_is_said(
    tmp_path: Path, caplog: pytest.LogCaptureFixture
) -> None:
    folder = tmp_path / "data"
    folder.mkdir(mode=0o755)
    make_private(folder)
    make_private(folder)
    assert mode(folder) == 0o700
    assert caplog.messages == [f"Other users could enter {folder}; now they cannot."]


@pytest.mark.parametrize(("folder_mode", "name"), [(0o755, "notes.txt"), (0o1777, "token")])
def test_one_of_other_files_or_of_all_users_is_refused_and_left_as_it_is(
    tmp_path: Path, folder_mode: int, name: str
) -> None:
    folder = tmp_path / "shared"
    folder.mkdir()
    (folder / name).touch()
    folder.chmod(folder_mode)
    with pytest.raises(RefusalError, match="new or empty directory"), owned(folder):
        pass
    assert folder.stat().st_mode & 0o7777 == folder_mode
    assert [each.name for each in folder.iterdir()] == [name]


@pytest.mark.parametrize("name", ["token", "d3pg.sqlite", "lock", "lost+found"])
def test_one_of_a_service_or_a_new_disk_is_closed(tmp_path: Path, name: str) -> None:
    folder = tmp_path / "data"
    folder.mkdir(mode=0o755)
    (folder / name).touch()
    make_private(folder)
    assert mode(folder) == 0o700


def test_the_database_is_its_users_alone(tmp_path: Path) -> None:
    file = tmp_path / "d3pg.sqlite"
    Store.open(f"sqlite:///{file}").close()
    assert mode(file) == 0o600
    file.chmod(0o644)
    store = Store.open(f"sqlite:///{file}")
    assert {mode(each) for each in tmp_path.iterdir()} == {0o600}
    store.close()


def test_a_file_or_what_cannot_be_entered_is_refused(tmp_path: Path) -> None:
    (tmp_path / "file").touch()
    for folder in (tmp_path / "file", tmp_path / "file" / "data", Path("/proc/data")):
        with pytest.raises(RefusalError, match="--data-dir"), owned(folder):
            pass


def test_a_second_service_is_refused(tmp_path: Path) -> None:
    with (
        owned(tmp_path),
        pytest.raises(RefusalError, match="another service works in"),
        ExitStack() as second,
    ):
        second.enter_context(owned(tmp_path))
