"""The learners, independent of Ray, SQL and HTTP.

The public names are loaded on first use (PEP 562), so that `import algorithms` alone loads neither
torch nor numba.
"""

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from algorithms.acting.module import PolicyModule
    from algorithms.acting.policy import TrainedPolicy
    from algorithms.acting.policy_file import load_policy, save_policy
    from algorithms.catalogue import Algorithm, names
    from algorithms.diagnostics.diagnose import diagnose
    from algorithms.diagnostics.finding import Finding
    from algorithms.measurement import Measurement
    from algorithms.trainer import Trainer, train
    from algorithms.training import build, prepare

__all__ = [
    "Algorithm",
    "Finding",
    "Measurement",
    "PolicyModule",
    "TrainedPolicy",
    "Trainer",
    "build",
    "diagnose",
    "load_policy",
    "names",
    "prepare",
    "save_policy",
    "train",
]

_HOMES = {
    "Algorithm": "algorithms.catalogue",
    "Finding": "algorithms.diagnostics.finding",
    "Measurement": "algorithms.measurement",
    "PolicyModule": "algorithms.acting.module",
    "TrainedPolicy": "algorithms.acting.policy",
    "Trainer": "algorithms.trainer",
    "build": "algorithms.training",
    "diagnose": "algorithms.diagnostics.diagnose",
    "load_policy": "algorithms.acting.policy_file",
    "names": "algorithms.catalogue",
    "prepare": "algorithms.training",
    "save_policy": "algorithms.acting.policy_file",
    "train": "algorithms.trainer",
}


def __getattr__(name: str) -> Any:
    if name not in _HOMES:
        raise AttributeError(f"module 'algorithms' has no attribute {name!r}")
    return getattr(import_module(_HOMES[name]), name)


def __dir__() -> list[str]:
    return sorted([*globals(), *__all__])
