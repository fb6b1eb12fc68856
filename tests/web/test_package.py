"""What checks the page's modules: exact versions, from wherever npm is set to look."""

import json
import re
from pathlib import Path
from typing import Any

WEB = Path(__file__).parents[2] / "web"


def read(name: str) -> Any:
    return json.loads((WEB / name).read_text(encoding="utf-8"))


def test_every_tool_is_pinned() -> None:
    wanted = read("package.json")["devDependencies"]
    locked = read("package-lock.json")["packages"]
    assert wanted
    for name, version in wanted.items():
        assert re.fullmatch(r"\d+\.\d+\.\d+", version), name
        assert locked[f"node_modules/{name}"]["version"] == version


def test_the_lock_file_proves_contents_and_names_no_registry() -> None:
    packages = read("package-lock.json")["packages"]
    installed = {name: package for name, package in packages.items() if name}
    assert installed
    for name, package in installed.items():
        assert package["integrity"].startswith("sha512-"), name
        assert "resolved" not in package, name


def test_users_need_none_of_it() -> None:
    assert "dependencies" not in read("package.json")
    assert all(
        package.get("dev")
        for name, package in read("package-lock.json")["packages"].items()
        if name
    )


def test_uplot_s_types_are_those_of_the_uplot_that_is_served() -> None:
    served = (WEB / "static" / "vendor" / "uplot.iife.min.js").read_text(encoding="utf-8")
    version = read("package.json")["devDependencies"]["uplot"]
    assert f"v{version}" in served[:200]
