"""The targets of soft actor-critic, and the gradient of the critics' target.

    Qhat  = r + gamma c V'(s')                                                    c = 1 - terminated
    dQhat = dr/dz + dr/ds' J + gamma c dV'/ds' J                                          z = (s, a)
    Vhat  = min(Q1, Q2)(s, a~) - log pi(a~ | s)                                             a~ ~ pi

All are in normalised units (algorithms.networks.scaling), V in that of Q, and all are constants in
the losses. The policy is not differentiated in dQhat: V' already includes its value.

Source: Haarnoja et al. (2018), equations 3 and 8; the gradient as in "D3PG: Deep Differentiable
Deterministic Policy Gradients" (2019), appendix A.2.
"""

from typing import Any

from algorithms.experience.replay import Batch
from algorithms.matching import bellman
from algorithms.networks import network
from algorithms.networks.layer import Array
from algorithms.networks.network import Pass
from algorithms.networks.parameters import Parameters
from algorithms.networks.scaling import Scaling
from physics.kernels.compiled import compiled_fast


@compiled_fast
def target_value(
    value_target: Parameters,
    batch: Batch,
    gamma: Any,
    scaling: Scaling,
    work: Pass,
    result: Array,
) -> None:
    """Fill the normalised Qhat [B], and `work` with the pass of V'."""
    network.receive(work, batch.next_x)
    network.forward(value_target, work)
    for row in range(result.size):
        result[row] = work.out[row, 0]
    bellman.back_up(batch, gamma, scaling, result)


@compiled_fast
def target_gradient(
    value_target: Parameters, batch: Batch, gamma: Any, work: Pass, result: Array
) -> None:
    """Fill the normalised dQhat [B, C + m], after `target_value` with the same arrays."""
    work.out_bar[:] = 1
    network.backward_to_input(value_target, work)
    bellman.back_up_gradient(batch, gamma, work.x_bar, result)
