"""Model: an MJCF file or text, compiled by MuJoCo, or an error with the mistake and its place."""

import re
import warnings
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from physics.environment import FloatArray
from physics.mujoco.engine import mujoco

Model = Any
"""MuJoCo's MjModel, which is not typed."""
STATE = int(
    mujoco.mjtState.mjSTATE_QPOS | mujoco.mjtState.mjSTATE_QVEL | mujoco.mjtState.mjSTATE_ACT
)


class Actuators(NamedTuple):
    """The map from actions in the box to controls: `centre + half action`, each [nu]."""

    centre: FloatArray
    half: FloatArray


def compiled(source: str | Path) -> Model:
    """Compile a model.

    The engine's own reset of a state that is not finite is disabled: such a step is an error.

    Args:
        source: an MJCF file, or its text, which begins with "<".

    Raises:
        ValueError: for a file that does not exist, a model that does not compile, with its file and
            line, and a model that cannot make a task.
    """
    text = str(source).lstrip().startswith("<")
    where = "the MJCF text" if text else str(source)
    if not text and not Path(source).is_file():
        raise ValueError(
            f"{where}: no such file (from {Path.cwd()}); a task in a file of its own names its "
            "model as Path(__file__).with_name('model.xml')"
        )
    told: list[str] = []
    before = mujoco.get_mju_user_warning()
    mujoco.set_mju_user_warning(told.append)
    try:
        load = mujoco.MjModel.from_xml_string if text else mujoco.MjModel.from_xml_path
        model = load(str(source))
    except (ValueError, mujoco.FatalError) as error:
        raise ValueError(_complaint(where, str(error))) from error
    finally:
        mujoco.set_mju_user_warning(before)
    for message in told:
        warnings.warn(f"{where}: {message}", stacklevel=2)
    _refuse_unfit(where, model)
    model.opt.disableflags |= mujoco.mjtDisableBit.mjDSBL_AUTORESET
    return model


def actuators_of(model: Model) -> Actuators:
    """The middle and half the width of each control's range; 0 and 1 where it has none."""
    limited = model.actuator_ctrllimited.astype(np.bool_)
    low, high = model.actuator_ctrlrange.T
    return Actuators(
        np.where(limited, (low + high) / 2, 0.0), np.where(limited, (high - low) / 2, 1.0)
    )


def can_touch(model: Model) -> bool:
    """Whether two of the model's geoms may be in contact, according to their masks."""
    kind, affinity, body = model.geom_contype, model.geom_conaffinity, model.geom_bodyid
    pairs = (kind[:, None] & affinity[None]) | (affinity[:, None] & kind[None])
    return bool(model.npair) or bool((pairs.astype(np.bool_) & (body[:, None] != body)).any())


def can_be_limited(model: Model) -> bool:
    """Whether a joint or a tendon has a range."""
    return bool(model.jnt_limited.any() or model.tendon_limited.any())


def _complaint(where: str, error: str) -> str:
    """MuJoCo's error about a model, in one line that begins with its place."""
    said = " ".join(error.split())
    line = re.search(r"line(?: number=| )(\d+)", said, re.IGNORECASE)
    place = f"{where}, line {line[1]}" if line else where
    return f"{place}: MuJoCo cannot compile this model: {said}"


def _refuse_unfit(where: str, model: Model) -> None:
    """Raise ValueError for a model that compiles but cannot make a task."""
    if model.nv == 0:
        raise ValueError(f"{where}: nothing moves in this model: give a body a joint")
    if model.nu == 0:
        raise ValueError(f"{where}: this model has no actuator: a task needs an action")
    if model.nhistory or model.npluginstate:
        raise ValueError(
            f"{where}: this model has a state beyond qpos, qvel and act (delays or plugins), which "
            "a task cannot hold"
        )


def coordinates_of(model: Model) -> dict[str, int]:
    """The place in qpos of each named joint that has one coordinate."""
    return {
        model.joint(joint).name: int(model.jnt_qposadr[joint])
        for joint in range(model.njnt)
        if model.joint(joint).name and _has_one_coordinate(model, joint)
    }


def unlimited_hinges(model: Model) -> set[int]:
    """The places in qpos of hinges without a range."""
    hinges = (model.jnt_type == mujoco.mjtJoint.mjJNT_HINGE) & (model.jnt_limited == 0)
    return {int(place) for place in model.jnt_qposadr[hinges]}


def _has_one_coordinate(model: Model, joint: int) -> bool:
    # An element of an array is never equal to an enumeration's member, an int is.
    kind = int(model.jnt_type[joint])
    return kind in (mujoco.mjtJoint.mjJNT_HINGE, mujoco.mjtJoint.mjJNT_SLIDE)
