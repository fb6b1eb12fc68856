"""A module's closure holds what its behaviour may depend on, and nothing else."""

from pathlib import Path

import pytest

from physics.kernels import source_closure


@pytest.fixture
def project(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Four modules: a imports b, b imports c and a, d stands alone."""
    monkeypatch.setattr(source_closure, "ROOT", tmp_path)
    monkeypatch.setattr(source_closure, "PACKAGES", frozenset({"package"}))
    (tmp_path / "package").mkdir()
    (tmp_path / "package" / "__init__.py").write_text("")
    for name, text in {
        "a": "import os\nfrom package import b\n",
        "b": "import package.c\nfrom package.a import (\n    something,\n)\n",
        "c": "SIZE = 1\n",
        "d": "SIZE = 2\n",
    }.items():
        (tmp_path / "package" / f"{name}.py").write_text(text)
    return tmp_path / "package"


def names(file: Path) -> set[str]:
    """The closure's files, relative to the package."""
    root = source_closure.ROOT / "package"
    return {str(member.relative_to(root)) for member in source_closure.closure(file)}


@pytest.mark.parametrize(
    "statement",
    [
        "import package.inner.deep",
        "from package.inner import deep",
        "from package.inner import through",
        "from .inner import deep",
        "from .inner.deep import something",
        "from . import inner",
    ],
)
def test_packages_and_relative_imports_are_followed(project: Path, statement: str) -> None:
    (project / "inner").mkdir()
    (project / "inner" / "__init__.py").write_text("from package.inner.deep import through\n")
    (project / "inner" / "deep.py").write_text("from .. import d\n")
    (project / "user.py").write_text(statement + "\n")
    assert names(project / "user.py") == {
        "__init__.py", "user.py", "inner/__init__.py", "inner/deep.py", "d.py",
    }  # fmt: skip


@pytest.mark.parametrize(
    ("statement", "message"),
    [
        ("import package.gone", "imports package.gone, which is not a file of its project"),
        ("from package.gone import x", "imports package.gone, which is not a file of its project"),
        ("from .gone import x", "imports package.gone, which is not a file of its project"),
        ("from package.lazy import late", "imports late from package.lazy, but no file defines"),
    ],
)
def test_an_own_import_that_names_no_file_is_an_error(
    project: Path, statement: str, message: str
) -> None:
    (project / "lazy").mkdir()
    (project / "lazy" / "__init__.py").write_text("def __getattr__(name):\n    return 1\n")
    (project / "user.py").write_text(statement + "\n")
    with pytest.raises(ImportError, match=message):
        source_closure.digest(project / "user.py")


def test_a_package_of_anothers_is_followed_and_what_it_takes_from_here(
    project: Path, tmp_path_factory: pytest.TempPathFactory
) -> None:
    """A task of one's own, with kernels of its own, installed anywhere."""
    theirs = tmp_path_factory.mktemp("site-packages") / "theirs"
    theirs.mkdir()
    for name, text in {
        "__init__": "",
        "arm": "from theirs import links\nfrom package import c\nimport numpy\n",
        "links": "from .joints import Joint\n",
        "joints": "class Joint: pass\n",
    }.items():
        (theirs / f"{name}.py").write_text(text)
    closure = source_closure.closure(theirs / "arm.py")
    own = {theirs / f"{name}.py" for name in ("__init__", "arm", "links", "joints")}
    assert closure == own | {project / "__init__.py", project / "c.py"}
    before = source_closure.digest(theirs / "arm.py")
    assert len(before) == 16


def test_imports_of_others_are_not_followed(project: Path) -> None:
    (project / "user.py").write_text("import os\nfrom numpy import linalg\nimport gone_missing\n")
    assert names(project / "user.py") == {"user.py"}


def test_imports_are_followed_around_cycles(project: Path) -> None:
    assert {file.stem for file in source_closure.closure(project / "a.py")} == {
        "__init__",
        "a",
        "b",
        "c",
    }
    assert {file.stem for file in source_closure.closure(project / "c.py")} == {"c"}


def test_the_digest_follows_every_file_of_the_closure_and_no_other(project: Path) -> None:
    before = source_closure.digest(project / "a.py")
    (project / "d.py").write_text("SIZE = 3\n")
    assert source_closure.digest(project / "a.py") == before
    (project / "c.py").write_text("SIZE = 3\n")
    assert source_closure.digest(project / "a.py") != before


def test_a_kernel_of_the_project_reaches_the_kernels_it_calls() -> None:
    closure = source_closure.closure(source_closure.ROOT / "algorithms/actor_critic/ddpg_update.py")
    names = {file.stem for file in closure}
    assert {"bellman", "layer", "replay", "compiled"} <= names
    assert "half_cheetah" not in names
