"""The folders of the page's modules: imports go down, and every module has its place."""

import re
from collections.abc import Mapping
from itertools import pairwise
from pathlib import Path

import pytest

from service.api.static_files import StaticFolder

ROOT = Path(__file__).parents[2]
STATIC = ROOT / "web" / "static"
LAYERS = (
    "pages > compare > diagnosis | question | run | submit | sweep > curves > charts | connection "
    "> parts > texts"
)
"""A folder imports from those to the right of it; those in one layer know nothing of each other."""
MOST_MODULES = 15
LEAST_LINES = 25  # of a module that only one other uses


def folder(module: str) -> str:
    return module.rpartition("/")[0]


def levels(layers: str) -> dict[str, int]:
    """How high each folder stands."""
    ordered = reversed(layers.split(" > "))
    return {name: level for level, names in enumerate(ordered) for name in names.split(" | ")}


def upward(imports: Mapping[str, tuple[str, ...]], layers: str) -> list[str]:
    """The imports that point to the side or upwards."""
    level = levels(layers)
    return [
        f"{module} imports {each}"
        for module, imported in imports.items()
        for each in imported
        if folder(module) != folder(each) and level[folder(module)] <= level[folder(each)]
    ]


def circle(imports: Mapping[str, tuple[str, ...]]) -> list[str]:
    """Modules that import each other in a circle; none where there is no such."""
    left = dict(imports)
    while leaves := [module for module, needed in left.items() if not left.keys() & set(needed)]:
        for module in leaves:
            del left[module]
    return sorted(left)


@pytest.fixture(scope="module")
def imports() -> dict[str, tuple[str, ...]]:
    found = StaticFolder(STATIC).imports
    return {module: each for module, each in found.items() if folder(module) != "vendor"}


def test_every_module_lies_in_a_folder_of_the_map(imports: dict[str, tuple[str, ...]]) -> None:
    assert {folder(module) for module in imports} == set(levels(LAYERS))


def test_no_import_points_upwards(imports: dict[str, tuple[str, ...]]) -> None:
    assert upward(imports, LAYERS) == []


def test_no_modules_import_each_other(imports: dict[str, tuple[str, ...]]) -> None:
    assert circle(imports) == []


def test_an_arrow_that_points_upwards_is_found_whatever_its_folders() -> None:
    for high, low in pairwise(("pages", "sweep", "charts", "parts", "texts")):
        assert upward({f"{high}/a.js": (f"{low}/b.js",)}, LAYERS) == []
        assert upward({f"{low}/b.js": (f"{high}/a.js",)}, LAYERS) == [
            f"{low}/b.js imports {high}/a.js"
        ]
    assert upward({"run/a.js": ("sweep/b.js", "run/c.js")}, LAYERS) == [
        "run/a.js imports sweep/b.js"
    ]


def test_a_circle_is_found() -> None:
    assert circle({"a": ("b",), "b": ("c",), "c": ("a",), "d": ("a",)}) == ["a", "b", "c", "d"]


def test_the_map_says_the_same() -> None:
    assert LAYERS in (ROOT / "ARCHITECTURE.md").read_text(encoding="utf-8")


def test_no_folder_is_too_full(imports: dict[str, tuple[str, ...]]) -> None:
    modules = [folder(module) for module in imports]
    assert [each for each in levels(LAYERS) if modules.count(each) > MOST_MODULES] == []


def test_no_tiny_module_serves_a_single_other(imports: dict[str, tuple[str, ...]]) -> None:
    users = [each for imported in imports.values() for each in imported]
    tiny = [
        module
        for module in imports
        if len((STATIC / module).read_text(encoding="utf-8").splitlines()) < LEAST_LINES
        and users.count(module) == 1
    ]
    assert tiny == []


def test_every_module_and_style_is_used(imports: dict[str, tuple[str, ...]]) -> None:
    templates = "".join(path.read_text() for path in (ROOT / "web" / "templates").glob("*.html"))
    named = set(re.findall(r"\{\{ static \}\}/([\w/]+\.(?:js|css))", templates))
    pages = {f"pages/{path.stem}.js" for path in (ROOT / "web" / "templates").glob("*.html")}
    scripts = "".join((STATIC / module).read_text() for module in imports)
    workers = {
        f"connection/{name}" for name in re.findall(r'new URL\("\./([\w]+\.js)", import', scripts)
    }
    assert workers <= imports.keys()
    used = {each for imported in imports.values() for each in imported} | named | pages | workers
    styles = {f"styles/{path.name}" for path in (STATIC / "styles").iterdir()}
    used |= {"styles/api.css", "styles/report.css"}  # of Swagger UI, and inside of a report
    assert (imports.keys() | styles) - used == set()
