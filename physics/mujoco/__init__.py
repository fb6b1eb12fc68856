"""MuJoCo's models as tasks: `physics.mujoco.task(model="arm.xml", reward=...)`.

This package is `physics.mujoco`; the engine is the package `mujoco`, an extra: `d3pg[mujoco]`. Its
names are loaded on first use, and the engine with them.
"""

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from physics.mujoco.declared import task
    from physics.mujoco.mujoco_task import MujocoTask
    from physics.mujoco.numpy_functions import NumpyMujocoTask
    from physics.mujoco.torch_functions import TorchMujocoTask

__all__ = ["MujocoTask", "NumpyMujocoTask", "TorchMujocoTask", "task"]

_HOMES = {
    "MujocoTask": "physics.mujoco.mujoco_task",
    "NumpyMujocoTask": "physics.mujoco.numpy_functions",
    "TorchMujocoTask": "physics.mujoco.torch_functions",
    "task": "physics.mujoco.declared",
}


def __getattr__(name: str) -> Any:
    if name not in _HOMES:
        raise AttributeError(f"module 'physics.mujoco' has no attribute {name!r}")
    return getattr(import_module(_HOMES[name]), name)
