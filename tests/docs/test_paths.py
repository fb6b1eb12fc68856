"""Every file, folder and module of the project that a page names exists."""

import re
from pathlib import Path

import pytest

from tests.docs.pages import PAGES, ROOT, commands, name_of

FOLDERS = sorted(path.name for path in ROOT.iterdir() if (path / "__init__.py").exists())
OTHERS = ["docs", "docker", "results", r"\.github"]
PATH = re.compile(rf"(?:{'|'.join(FOLDERS + OTHERS)})/[\w./-]*")
MODULE = re.compile(r"python -m ((?:physics|algorithms|workers|service|benchmarks)[\w.]*)")


def named(page: Path) -> set[Path]:
    """What a page names between backquotes and in commands."""
    found = set()
    for text in commands(page):
        if path := PATH.match(text):
            found.add(ROOT / path[0])
        if module := MODULE.match(text):
            found.add(ROOT / module[1].replace(".", "/"))
    return found


def exists(path: Path) -> bool:
    return path.exists() or path.with_suffix(".py").exists()


@pytest.mark.parametrize("document", PAGES, ids=name_of)
def test_what_a_page_names_exists(document: Path) -> None:
    assert [path.relative_to(ROOT) for path in named(document) if not exists(path)] == []


def test_paths_are_found() -> None:
    assert ROOT / "workers/training/execute.py" in named(ROOT / "ARCHITECTURE.md")
    assert ROOT / "benchmarks/store" in named(ROOT / "docs" / "figures-to-hold.md")
    assert not exists(ROOT / "workers/rollout.py")
