"""The structure: ARCHITECTURE.md has the path of a seed, and no folder is too large."""

import ast
import re
from collections import Counter
from collections.abc import Sequence
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]
STOP = re.compile(r"^\| `([\w.]+):([\w.]+)` \| (.+) \|$", re.MULTILINE)
NOUN = re.compile(r"`([A-Z]\w+)`")
SMALL = 25
MOST_IN_A_FOLDER = 15
MOST_STOPS = 17
"""A function that only passes a seed on is not to come between."""


def stops() -> list[tuple[str, str, str]]:
    """Module, function, and what the seed leaves it in."""
    return STOP.findall((ROOT / "ARCHITECTURE.md").read_text(encoding="utf-8"))


def source(module: str) -> str:
    return (ROOT / module.replace(".", "/")).with_suffix(".py").read_text(encoding="utf-8")


def defined(body: Sequence[ast.stmt], name: str) -> bool:
    """Whether `function` or `Class.method` is defined there."""
    first, _, rest = name.partition(".")
    for each in body:
        if isinstance(each, ast.ClassDef) and rest and each.name == first:
            return defined(each.body, rest)
        if isinstance(each, ast.FunctionDef) and not rest and each.name == first:
            return True
    return False


def test_the_path_goes_to_the_learner_and_back_to_the_page() -> None:
    modules = [module for module, _, _ in stops()]
    assert modules[0] == "service.api.routes.submissions"
    assert "algorithms.training" in modules
    assert modules[-1] == "service.analysis.comparison"
    assert len(modules) <= MOST_STOPS


def modules_of(package: str) -> dict[str, Path]:
    """The modules of a package by their names, but those that are run or found by their place."""
    found = (ROOT / package).rglob("*.py")
    kept = [path for path in found if "migrations" not in path.parts and path.stem[0] != "_"]
    return {".".join(path.relative_to(ROOT).with_suffix("").parts): path for path in kept}


@pytest.mark.parametrize("package", ["service", "workers"])
def test_a_folder_has_at_most_fifteen_modules(package: str) -> None:
    folders = Counter(path.parent for path in modules_of(package).values())
    assert max(folders.values()) <= MOST_IN_A_FOLDER, folders.most_common(1)


@pytest.mark.parametrize("package", ["service", "workers"])
def test_a_small_module_has_more_than_one_user(package: str) -> None:
    files = [file for place in ("service", "workers") for file in (ROOT / place).rglob("*.py")]
    texts = {file: file.read_text(encoding="utf-8") for file in files}
    for module, path in modules_of(package).items():
        if len(texts[path].splitlines()) < SMALL:
            folder, _, name = module.rpartition(".")
            used = re.compile(rf"from ({module} import|{folder} import .*\b{name}\b)")
            users = [file for file, text in texts.items() if used.search(text)]
            assert len(users) > 1, f"{module} is small and has {len(users)} users"


@pytest.mark.parametrize(("module", "function", "leaves"), stops())
def test_a_stop_is_a_function_of_the_code(module: str, function: str, leaves: str) -> None:
    code = source(module)
    assert defined(ast.parse(code).body, function)
    for noun in NOUN.findall(leaves):
        assert re.search(rf"\b{noun}\b", code), noun
