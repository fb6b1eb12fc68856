"""What a folder promises, on a disk and in a bucket."""

import contextlib

import pytest

from workers.checkpoints.folder import Folder
from workers.checkpoints.place import Place, folder_in


@pytest.fixture
def folder(place: Place) -> Folder:
    return folder_in(place, "run-3")


def test_one_that_was_never_written_to_is_empty(folder: Folder) -> None:
    assert folder.names() == []
    folder.remove(lambda name: True)
    with pytest.raises(FileNotFoundError):
        folder.read("policy")
    with pytest.raises(FileNotFoundError):
        folder.read_beginning("1.journal", 3)


def test_a_file_is_what_was_written_last(folder: Folder) -> None:
    for content in (b"first", b"", bytes(range(256)) * 100):
        folder.write("policy", content)
        assert folder.read("policy") == content
    assert folder.names() == ["policy"]


def test_every_beginning_of_a_file_that_grew_can_be_read(folder: Folder) -> None:
    content = b""
    for piece in (b"one", b"two and", bytes(2000)):
        folder.append("1.journal", len(content), piece)
        content += piece
    for size in (3, 10, 2010):
        assert folder.read_beginning("1.journal", size) == content[:size]
    assert folder.names() == ["1.journal"]


def test_what_a_try_wrote_that_counts_as_failed_is_not_read(folder: Folder) -> None:
    """The store may have it all the same, as where its answer was lost."""
    folder.append("1.journal", 0, b"one")
    folder.append("1.journal", 3, b"fails")
    folder.append("1.journal", 3, b"succeeds")
    folder.append("1.journal", 11, b"last")
    assert folder.read_beginning("1.journal", 15) == b"onesucceedslast"


def test_more_than_there_is_is_not_read_as_whole(folder: Folder) -> None:
    folder.append("1.journal", 0, b"one")
    with contextlib.suppress(FileNotFoundError):
        assert folder.read_beginning("1.journal", 4) == b"one"


def test_only_what_is_unneeded_goes_and_nothing_of_it_stays(place: Place) -> None:
    folder, other = folder_in(place, "run-3"), folder_in(place, "run-30")
    for each in (folder, other):
        each.append("1.journal", 0, b"one")
        each.append("1.journal", 3, b"two")
        each.write("1-200.checkpoint", b"state")
        each.write("policy", b"learned")
    folder.remove(lambda name: name != "policy")
    assert folder.names() == ["policy"]
    assert sorted(other.names()) == ["1-200.checkpoint", "1.journal", "policy"]
    with pytest.raises(FileNotFoundError):
        folder.read_beginning("1.journal", 3)


def test_the_size_of_a_file_is_that_of_all_its_pieces(folder: Folder) -> None:
    folder.write("policy", b"12345")
    folder.write("policy-epoch-1", b"123")
    folder.append("1.journal", 0, b"one")
    folder.append("1.journal", 3, b"two and")
    assert [folder.size(name) for name in ("policy", "1.journal", "none")] == [5, 10, 0]
