"""What a run's bits depend on besides its spec.

Same fingerprint, same spec: the same curve, bit for bit. Another fingerprint: the same statistics.
"""

import hashlib
import os
import platform
from collections.abc import Mapping
from functools import cache
from importlib.metadata import version
from importlib.util import find_spec
from pathlib import Path
from typing import Any

import llvmlite.binding
import numpy
import scipy.linalg.cython_blas
import threadpoolctl

PACKAGES = ("numpy", "numba", "llvmlite", "scipy", "torch", "gymnasium")
"""Gymnasium brings the models of the ready-made MuJoCo tasks."""
EXTRAS = ("mujoco", "jax", "jaxlib")
"""Packages that tasks may be of, where they are installed."""
MULTIPLIERS = (numpy, scipy)
"""Packages whose BLAS the learners multiply with; numba's `np.dot` takes scipy's. Both are loaded
here, so that a fingerprint never depends on what else a process has imported by then."""
SOURCES = ("physics", "algorithms")


@cache
def fingerprint() -> Mapping[str, Any]:
    """Return the fingerprint of this process: plain JSON values.

    code       SHA-256 of every source file of physics and algorithms
    processor  what LLVM compiles for, and a hash of all its features
    blas       the libraries that multiply matrices, with their kernels and threads
    """
    features = llvmlite.binding.get_host_cpu_features()
    enabled = ",".join(sorted(name for name, is_on in features.items() if is_on))
    return {
        "python": platform.python_version(),
        "system": f"{platform.system()} {platform.machine()} {platform.libc_ver()[1]}",
        **{package: version(package) for package in PACKAGES},
        **{package: version(package) for package in EXTRAS if find_spec(package)},
        "processor": llvmlite.binding.get_host_cpu_name(),
        "processor_features": hashlib.sha256(enabled.encode()).hexdigest()[:16],
        "blas": _blas(),
        "threads": os.environ.get("OMP_NUM_THREADS", ""),
        "code": code_hash(),
    }


@cache
def code_hash() -> str:
    """Return the SHA-256 of the code that computes: every source file of physics and algorithms."""
    root = Path(__file__).parents[2]
    digest = hashlib.sha256()
    for package in SOURCES:
        for path in sorted((root / package).rglob("*.py")):
            digest.update(f"{path.relative_to(root)}\0".encode())
            digest.update(path.read_bytes())
    return digest.hexdigest()


def _blas() -> list[str]:
    fields = ("internal_api", "version", "architecture", "num_threads")
    folders = [Path(path) for package in MULTIPLIERS for path in package.__path__]
    homes = {*folders, *(folder.with_name(f"{folder.name}.libs") for folder in folders)}
    return sorted(
        " ".join(str(library.get(name, "")) for name in fields)
        for library in threadpoolctl.threadpool_info()
        if homes & set(Path(library["filepath"]).parents)
    )
