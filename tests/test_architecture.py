"""ARCHITECTURE.md: the path of a seed, stop by stop, is one of this code."""

import ast
import re
from collections.abc import Sequence
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]
STOP = re.compile(r"^\| `([\w.]+):([\w.]+)` \| (.+) \|$", re.MULTILINE)
NOUN = re.compile(r"`([A-Z]\w+)`")
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
    assert modules[0] == "service.api.routes.sweeps"
    assert "algorithms.training" in modules
    assert modules[-1] == "service.analysis.comparison"
    assert len(modules) <= MOST_STOPS


@pytest.mark.parametrize(("module", "function", "leaves"), stops())
def test_a_stop_is_a_function_of_the_code(module: str, function: str, leaves: str) -> None:
    code = source(module)
    assert defined(ast.parse(code).body, function)
    for noun in NOUN.findall(leaves):
        assert re.search(rf"\b{noun}\b", code), noun
