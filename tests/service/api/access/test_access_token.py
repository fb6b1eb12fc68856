"""The token file: made once, readable by its owner alone."""

import os
import stat
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import pytest
from pydantic import SecretStr

from service.api.access.access_token import access_token
from service.refusal import RefusalError
from service.settings import Settings


def test_made_once_for_the_owner_alone(tmp_path: Path) -> None:
    previous = os.umask(0)
    try:
        token = access_token(Settings(data_dir=tmp_path / "new"))
    finally:
        os.umask(previous)
    file = tmp_path / "new" / "token"
    assert stat.S_IMODE(file.stat().st_mode) == 0o600
    assert len(token) == 48
    assert access_token(Settings(data_dir=tmp_path / "new")) == token
    assert [each.name for each in file.parent.iterdir()] == ["token"]


def test_two_that_start_at_once_agree(tmp_path: Path) -> None:
    with ThreadPoolExecutor(16) as pool:
        settings = Settings(data_dir=tmp_path)
        tokens = set(pool.map(lambda _: access_token(settings), range(64)))
    assert len(tokens) == 1


def test_a_file_that_others_can_read_is_refused(tmp_path: Path) -> None:
    settings = Settings(data_dir=tmp_path)
    access_token(settings)
    (tmp_path / "token").chmod(0o644)
    with pytest.raises(RefusalError, match="chmod 600"):
        access_token(settings)


def test_a_set_token_makes_no_file(tmp_path: Path) -> None:
    settings = Settings(data_dir=tmp_path, token=SecretStr("set by the operator"))
    assert access_token(settings) == "set by the operator"
    assert not list(tmp_path.iterdir())
