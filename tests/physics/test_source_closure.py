"""A module's closure holds what its behaviour may depend on, and nothing else."""

from pathlib import Path

import pytest

from physics import source_closure


@pytest.fixture
def project(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Four modules: a imports b, b imports c and a, d stands alone."""
    monkeypatch.setattr(source_closure, "ROOT", tmp_path)
    (tmp_path / "package").mkdir()
    for name, text in {
        "a": "import os\nfrom package import b\n",
        "b": "import package.c\nfrom package.a import (\n    something,\n)\n",
        "c": "SIZE = 1\n",
        "d": "SIZE = 2\n",
    }.items():
        (tmp_path / "package" / f"{name}.py").write_text(text)
    return tmp_path / "package"


def test_imports_are_followed_around_cycles(project: Path) -> None:
    assert {file.stem for file in source_closure.closure(project / "a.py")} == {"a", "b", "c"}
    assert {file.stem for file in source_closure.closure(project / "c.py")} == {"c"}


def test_the_digest_follows_every_file_of_the_closure_and_no_other(project: Path) -> None:
    before = source_closure.digest(project / "a.py")
    (project / "d.py").write_text("SIZE = 3\n")
    assert source_closure.digest(project / "a.py") == before
    (project / "c.py").write_text("SIZE = 3\n")
    assert source_closure.digest(project / "a.py") != before


def test_a_kernel_of_the_project_reaches_the_kernels_it_calls() -> None:
    closure = source_closure.closure(source_closure.ROOT / "algorithms" / "ddpg_update.py")
    names = {file.stem for file in closure}
    assert {"bellman", "layer", "replay", "compiled"} <= names
    assert "half_cheetah" not in names
