"""A package as `pip install` leaves it: one module, and the metadata of its entry points."""

import importlib
import sys
import tomllib
from pathlib import Path

import pytest


def install(folder: Path, module: str, code: str, project: str, patch: pytest.MonkeyPatch) -> Path:
    """Put a module and the entry points of its pyproject.toml where Python finds them."""
    (folder / f"{module}.py").write_text(code)
    lines = []
    for group, entries in tomllib.loads(project)["project"]["entry-points"].items():
        lines += [f"[{group}]", *(f"{name} = {value}" for name, value in entries.items())]
    metadata = folder / f"{module}-1.0.dist-info"
    metadata.mkdir()
    (metadata / "METADATA").write_text(f"Metadata-Version: 2.1\nName: {module}\nVersion: 1.0\n")
    (metadata / "entry_points.txt").write_text("\n".join(lines) + "\n")
    patch.syspath_prepend(folder)
    importlib.invalidate_caches()
    patch.delitem(sys.modules, module, raising=False)
    return folder
