"""The engine: the package `mujoco`, or an error that says what to install."""

try:
    import mujoco as mujoco  # noqa: PLC0414 - for the modules beside this one
except ModuleNotFoundError as error:
    raise ModuleNotFoundError(
        "MuJoCo's models need the package mujoco: pip install 'd3pg[mujoco]'", name="mujoco"
    ) from error
