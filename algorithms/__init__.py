"""The learners, independent of Ray, SQL and HTTP.

The public names are loaded on first use (PEP 562), so that `import algorithms` alone loads neither
torch nor numba.
"""

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from algorithms.catalogue import names
    from algorithms.measurement import Measurement
    from algorithms.training import build, prepare, train

__all__ = ["Measurement", "build", "names", "prepare", "train"]

_HOMES = {
    "Measurement": "algorithms.measurement",
    "build": "algorithms.training",
    "names": "algorithms.catalogue",
    "prepare": "algorithms.training",
    "train": "algorithms.training",
}


def __getattr__(name: str) -> Any:
    if name not in _HOMES:
        raise AttributeError(f"module 'algorithms' has no attribute {name!r}")
    return getattr(import_module(_HOMES[name]), name)


def __dir__() -> list[str]:
    return sorted([*globals(), *__all__])
