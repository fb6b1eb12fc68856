"""The fingerprint: plain, the same in every process, changed by code."""

import json
import os
import subprocess
import sys

import pytest

from workers.training import fingerprint as module
from workers.training.fingerprint import code_hash, fingerprint

PRINT = """
import json, {first}
from workers.training.fingerprint import fingerprint
print(json.dumps(fingerprint()))
"""


def test_does_not_depend_on_what_was_imported() -> None:
    one_thread = os.environ | {"OMP_NUM_THREADS": "1", "OPENBLAS_NUM_THREADS": "1"}
    printed = [
        subprocess.check_output(
            [sys.executable, "-c", PRINT.format(first=first)], env=one_thread, text=True
        )
        for first in ("sys", "matplotlib.figure, numba")
    ]
    assert printed[0] == printed[1]
    document = json.loads(printed[0])
    assert document["threads"] == "1"
    assert all(library.endswith(" 1") for library in document["blas"])
    assert len(document["blas"]) == 2


def test_is_plain_json() -> None:
    assert json.loads(json.dumps(fingerprint())) == fingerprint()


def test_names_what_it_hashed() -> None:
    assert fingerprint()["code"] == code_hash()
    assert len(code_hash()) == 64
    assert module.SOURCES == ("physics", "algorithms")


def test_extras_are_in_it_where_they_are_installed(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(module, "EXTRAS", ("numba", "no_such_package"))
    monkeypatch.setattr(module, "PACKAGES", ())
    found = module.fingerprint.__wrapped__()
    assert "numba" in found
    assert "no_such_package" not in found
