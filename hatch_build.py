"""Bring uPlot, the chart library of the dashboard, into `web/static/vendor` at build time.

uPlot's code is never committed. It comes from the wheel `youplot`, which carries uPlot's two
release files unchanged; that package is young and has one author, so nothing of it is trusted or
imported: its files are read, and accepted only with the SHA-256 of uPlot 1.6.31's own release.
The second source is that release itself (`npm pack`), should youplot vanish:
`pip install hatchling && python hatch_build.py` uses whichever of the two is there.
Once the files are in place they are checked and kept, and a build needs no network for them.
"""

import hashlib
import io
import shutil
import subprocess
import tarfile
import tempfile
from collections.abc import Callable
from importlib import metadata
from pathlib import Path
from typing import Any, NamedTuple

from hatchling.builders.hooks.plugin.interface import BuildHookInterface

VENDOR = Path("web", "static", "vendor")
WHEEL = "youplot==1.0.0"
NPM_PACKAGE = "uplot@1.6.31"


class VendorFile(NamedTuple):
    """A file of uPlot 1.6.31: its name here, where each source keeps it, and what it must be."""

    name: str
    in_wheel: str
    in_npm_package: str
    sha256: str


FILES = (
    VendorFile(
        "uplot.iife.min.js",
        "youplot/vendor/uplot.iife.min.js",
        "package/dist/uPlot.iife.min.js",
        "2d27e8ad3d228164525ce213f9dc716f39b4e3aee0cc773fb3491c96cf4921a2",
    ),
    VendorFile(
        "uplot.min.css",
        "youplot/vendor/uplot.min.css",
        "package/dist/uPlot.min.css",
        "df630c6a8d6f8eeaff264b50f73ce5b114f646ffd9a0bb74f049b0a00135fa04",
    ),
)

# The wheel leaves uPlot's licence out, and the licence asks to travel with the code.
LICENCE_NAME = "uplot.LICENSE.txt"
LICENCE = """\
The MIT License (MIT)

Copyright (c) 2022 Leon Sorokin

Permission is hereby granted, free of charge, to any person obtaining a copy
of this software and associated documentation files (the "Software"), to deal
in the Software without restriction, including without limitation the rights
to use, copy, modify, merge, publish, distribute, sublicense, and/or sell
copies of the Software, and to permit persons to whom the Software is
furnished to do so, subject to the following conditions:

The above copyright notice and this permission notice shall be included in
all copies or substantial portions of the Software.

THE SOFTWARE IS PROVIDED "AS IS", WITHOUT WARRANTY OF ANY KIND, EXPRESS OR
IMPLIED, INCLUDING BUT NOT LIMITED TO THE WARRANTIES OF MERCHANTABILITY,
FITNESS FOR A PARTICULAR PURPOSE AND NONINFRINGEMENT. IN NO EVENT SHALL THE
AUTHORS OR COPYRIGHT HOLDERS BE LIABLE FOR ANY CLAIM, DAMAGES OR OTHER
LIABILITY, WHETHER IN AN ACTION OF CONTRACT, TORT OR OTHERWISE, ARISING FROM,
OUT OF OR IN CONNECTION WITH THE SOFTWARE OR THE USE OR OTHER DEALINGS IN
THE SOFTWARE.
"""


class VendorBuildHook(BuildHookInterface[Any]):
    """Hatchling's `custom` hook: runs before a wheel, an sdist and an editable install."""

    def dependencies(self) -> list[str]:
        """The wheel to read uPlot from, unless its files are here already."""
        return [] if is_complete(Path(self.root, VENDOR)) else [WHEEL]

    def initialize(self, version: str, build_data: dict[str, Any]) -> None:  # noqa: ARG002
        """Put uPlot in place before the files of the package are collected."""
        bring_in(Path(self.root, VENDOR))


def is_complete(vendor: Path) -> bool:
    """Whether every file of uPlot stands in `vendor` with the right hash."""
    return (vendor / LICENCE_NAME).is_file() and all(
        (vendor / file.name).is_file() and is_genuine(file, (vendor / file.name).read_bytes())
        for file in FILES
    )


def is_genuine(file: VendorFile, content: bytes) -> bool:
    """Whether `content` is the file as uPlot released it."""
    return hashlib.sha256(content).hexdigest() == file.sha256


def bring_in(vendor: Path) -> None:
    """Write uPlot and its licence to `vendor`; RuntimeError when no source has the right bytes."""
    if is_complete(vendor):
        return
    contents = first_genuine({f"wheel {WHEEL}": from_wheel, f"npm pack {NPM_PACKAGE}": from_npm})
    vendor.mkdir(parents=True, exist_ok=True)
    for name, content in {**contents, LICENCE_NAME: LICENCE.encode()}.items():
        (vendor / name).write_bytes(content)


def first_genuine(sources: dict[str, Callable[[], dict[str, bytes]]]) -> dict[str, bytes]:
    """The files by name, from the first source that has all of them genuine."""
    failures = []
    for source, read in sources.items():
        try:
            contents = read()
        except (OSError, KeyError, metadata.PackageNotFoundError, subprocess.SubprocessError) as e:
            failures.append(f"{source}: {type(e).__name__}: {e}")
            continue
        altered = [file.name for file in FILES if not is_genuine(file, contents[file.name])]
        if not altered:
            return contents
        failures.append(f"{source}: {', '.join(altered)} is not what uPlot 1.6.31 released")
    raise RuntimeError(
        "uPlot 1.6.31 could not be brought in. Tried: "
        + "; ".join(failures)
        + ". Reach a Python package index that has youplot 1.0.0, or install npm, and build again."
    )


def from_wheel() -> dict[str, bytes]:
    """The files out of the installed wheel, read without importing it."""
    wheel = metadata.distribution(WHEEL.split("==", maxsplit=1)[0])
    return {file.name: Path(str(wheel.locate_file(file.in_wheel))).read_bytes() for file in FILES}


def from_npm() -> dict[str, bytes]:
    """The files out of uPlot's own package, fetched by the npm client."""
    npm = shutil.which("npm")
    if npm is None:
        raise FileNotFoundError("npm is not installed")
    with tempfile.TemporaryDirectory() as folder:
        subprocess.run(  # noqa: S603
            [npm, "pack", NPM_PACKAGE], cwd=folder, check=True, capture_output=True, timeout=120
        )
        archive = next(Path(folder).glob("*.tgz")).read_bytes()
    with tarfile.open(fileobj=io.BytesIO(archive)) as package:
        return {file.name: read_member(package, file.in_npm_package) for file in FILES}


def read_member(package: tarfile.TarFile, name: str) -> bytes:
    """The bytes of one regular file of an archive; KeyError when there is none of that name."""
    member = package.extractfile(name)
    if member is None:
        raise KeyError(name)
    return member.read()


if __name__ == "__main__":
    bring_in(Path(__file__).parent / VENDOR)
