"""The action follows the import, once, and looking around is no import."""

import importlib
import importlib.util
import sys
from pathlib import Path

import pytest

from physics.gym.import_watch import when_imported


@pytest.fixture
def package(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> str:
    """A package that is not imported yet."""
    (tmp_path / "visitor").mkdir()
    (tmp_path / "visitor" / "__init__.py").write_text("from visitor.part import READY\n")
    (tmp_path / "visitor" / "part.py").write_text("READY = True\n")
    monkeypatch.syspath_prepend(tmp_path)
    monkeypatch.setattr(sys, "meta_path", list(sys.meta_path))
    for module in ("visitor", "visitor.part"):
        monkeypatch.delitem(sys.modules, module, raising=False)
    return "visitor"


def test_it_acts_when_the_package_is_ready(package: str) -> None:
    seen: list[bool] = []
    finders = list(sys.meta_path)
    when_imported(package, lambda: seen.append(sys.modules[package].READY))
    assert importlib.util.find_spec(package) is not None
    assert seen == []
    visitor = importlib.import_module(package)
    assert seen == [True]
    assert importlib.import_module(package) is visitor
    assert importlib.reload(visitor) is visitor
    assert seen == [True]
    assert sys.meta_path == finders


def test_it_acts_at_once_where_the_package_is_there(package: str) -> None:
    importlib.import_module(package)
    seen: list[str] = []
    when_imported(package, lambda: seen.append("now"))
    assert seen == ["now"]


def test_several_may_wait_for_one_package(package: str) -> None:
    seen: list[int] = []
    when_imported(package, lambda: seen.append(1))
    when_imported(package, lambda: seen.append(2))
    importlib.import_module(package)
    assert sorted(seen) == [1, 2]


def test_a_package_that_is_not_there_is_still_missing() -> None:
    finders = list(sys.meta_path)
    try:
        when_imported("no_such_package", lambda: None)
        with pytest.raises(ModuleNotFoundError, match="no_such_package"):
            importlib.import_module("no_such_package")
    finally:
        sys.meta_path[:] = finders
