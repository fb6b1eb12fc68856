"""The tasks: simulators with exact derivatives, for NumPy, torch and Gymnasium.

`as_task`, `make`, `names`, `compile_kernels`, `spec_of`, `torch_step` and `mujoco`, which makes
tasks of MuJoCo's models, are loaded on first use (PEP 562), so that `import physics` loads neither
torch nor numba. The tasks are registered with Gymnasium when it is imported, before or after
this package.
"""

from importlib import import_module
from typing import TYPE_CHECKING, Any

from physics.gym.import_watch import when_imported

if TYPE_CHECKING:
    from physics import mujoco
    from physics.autograd import torch_step
    from physics.catalogue import as_task, compile_kernels, make, names
    from physics.gym.registration import spec_of

__all__ = ["as_task", "compile_kernels", "make", "mujoco", "names", "spec_of", "torch_step"]

_HOMES = {
    "as_task": "physics.catalogue",
    "compile_kernels": "physics.catalogue",
    "make": "physics.catalogue",
    "names": "physics.catalogue",
    "spec_of": "physics.gym.registration",
    "torch_step": "physics.autograd",
}


def __getattr__(name: str) -> Any:
    if name == "mujoco":
        return import_module("physics.mujoco")
    if name not in _HOMES:
        raise AttributeError(f"module 'physics' has no attribute {name!r}")
    return getattr(import_module(_HOMES[name]), name)


def __dir__() -> list[str]:
    return sorted([*globals(), *__all__])


def _register_with_gymnasium() -> None:
    """Register the tasks with Gymnasium."""
    import_module("physics.gym.registration").register()


when_imported("gymnasium", _register_with_gymnasium)
