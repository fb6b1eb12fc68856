"""Models as their authors write them, and rewards of them."""

from typing import Any

import numpy as np
import torch

from physics.environment import FloatArray

ARM = """
<mujoco model="arm">
  <option timestep="0.01" integrator="implicitfast" gravity="0 0 0"/>
  <default><joint damping="0.5" armature="0.05"/><geom contype="0" conaffinity="0"/></default>
  <worldbody>
    <body>
      <joint name="shoulder" axis="0 1 0"/>
      <geom type="capsule" fromto="0 0 0 0.4 0 0" size="0.04"/>
      <body pos="0.4 0 0">
        <joint name="elbow" axis="0 1 0" range="-150 150" limited="true"/>
        <geom type="capsule" fromto="0 0 0 0.4 0 0" size="0.03"/>
        <site name="tip" pos="0.4 0 0"/>
      </body>
    </body>
    <body name="target" pos="0.3 0 0.4"><geom type="sphere" size="0.03"/></body>
  </worldbody>
  <actuator>
    <motor joint="shoulder" ctrlrange="-2 2" ctrllimited="true"/>
    <motor joint="elbow" ctrlrange="0 2" ctrllimited="true"/>
  </actuator>
</mujoco>
"""
FREE = """
<mujoco model="tumbling">
  <option timestep="0.005" integrator="INTEGRATOR"/>
  <worldbody>
    <geom type="plane" size="5 5 .1"/>
    <body pos="0 0 1">
      <freejoint name="root"/>
      <geom type="box" size="0.1 0.2 0.3"/>
      <body pos="0 0 0.4">
        <joint name="ball" type="ball" damping="0.1"/>
        <geom type="capsule" fromto="0 0 0 0 0.1 0.3" size="0.05"/>
        <body pos="0 0.1 0.3">
          <joint name="hinge" axis="1 0 0"/>
          <geom type="sphere" size="0.1" pos="0 0.1 0"/>
        </body>
      </body>
    </body>
  </worldbody>
  <actuator>
    <general joint="hinge" dyntype="filter" dynprm="0.1" gainprm="2"/>
    <motor joint="ball" gear="1 2 0.5"/>
  </actuator>
</mujoco>
"""


def distance(model: Any, data: Any) -> FloatArray:
    """From the target to the tip."""
    del model
    away: FloatArray = data.site("tip").xpos - data.body("target").xpos
    return away


def nearness(state: torch.Tensor, action: torch.Tensor, next_state: torch.Tensor) -> torch.Tensor:
    """A reward in torch, of an arm with `distance`."""
    del state
    return -(next_state[4:] ** 2).sum() - 0.01 * (action**2).sum()


def nearness_in_numpy(state: FloatArray, action: FloatArray, next_state: FloatArray) -> float:
    """The same in numpy."""
    del state
    return float(-np.sum(next_state[4:] ** 2) - 0.01 * np.sum(action**2))
