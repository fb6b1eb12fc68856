"""Autograd: a step of a task as a torch function, differentiated by its exact Jacobians.

The gradient of a loss L passes a step backwards, and a tangent (ds, da) forwards, as

    dL/ds = J_s^T g + dL/dr dr/ds        dL/da = J_a^T g + dL/dr dr/da,    g = dL/ds' + dL/dr dr/ds'
    ds'   = J_s ds + J_a da              dr    = dr/ds ds + dr/da da + dr/ds' ds'

The Jacobians are themselves functions of the state and the action: a task of torch functions can be
differentiated any number of times, a compiled one once.
"""

from collections.abc import Mapping
from contextlib import AbstractContextManager
from types import MappingProxyType
from typing import Any, NamedTuple, cast

import torch
from torch.autograd import forward_ad
from torch.autograd.function import once_differentiable
from torch.func import jacrev, vmap

from physics.environment import Environment, NoisyEnvironment
from physics.noise import PARAMETERS, PROCESS, next_places
from physics.torch_environment import TorchEnvironment, gradients_enabled
from physics.torch_trace import Tensors

NOISE = {parameter.name for parameter in PARAMETERS}


class TorchTransition(NamedTuple):
    """One step of each row of a batch, as tensors."""

    next_state: torch.Tensor
    """[batch, n]"""
    reward: torch.Tensor
    """[batch]"""
    terminated: torch.Tensor
    """[batch], bool"""


def torch_step(
    environment: Environment,
    states: torch.Tensor,
    actions: torch.Tensor,
    parameters: Mapping[str, torch.Tensor] = MappingProxyType({}),
) -> TorchTransition:
    """Advance states [batch, n] by one step; gradients flow to states and actions.

    They also flow to `parameters`, values [] of the task's parameters by name, which replace those
    of the task. A compiled task supports only the first derivative in them, by reverse mode.

    The noise is a constant, given by the places in the noise that the states hold; `process_noise`
    scales it.

    The step is computed in float64, whatever the dtypes: next states and rewards have the dtype of
    `states`, and a gradient has the dtype of its tensor. `torch.func` can transform the function in
    any grad mode, and functions that `torch.compile` compiles may call it (it is not compiled
    itself).

    Where `reward_is_differentiable` is False, the reward has no gradient, and torch raises an error
    if one is computed.

    Raises:
        ValueError: for anything but floating-point tensors on the CPU, for unknown parameters and
            values out of their ranges, and as `Environment.step`.
        RuntimeError: for a second derivative of a task that is not a `TorchEnvironment`.
    """
    for what, tensor in (("states", states), ("actions", actions), *parameters.items()):
        if not tensor.dtype.is_floating_point or tensor.device.type != "cpu":
            raise ValueError(
                f"{what} must be a floating-point tensor on the CPU, "
                f"not {tensor.dtype} on {tensor.device}"
            )
    rows = states.to(torch.float64), actions.to(torch.float64)
    if len(parameters) > 0:  # torch.compile treats any mapping proxy as true
        found = _uncompiled_parametric_step(environment, *rows, parameters)
    elif isinstance(environment, NoisyEnvironment):
        found = _uncompiled_noisy_step(environment, *rows, {})
    else:
        found = _uncompiled_step(environment, *rows)
    next_state, reward, terminated = found
    return TorchTransition(next_state.to(states.dtype), reward.to(states.dtype), terminated)


def _parametric_step(
    environment: Environment,
    states: torch.Tensor,
    actions: torch.Tensor,
    parameters: Mapping[str, torch.Tensor],
) -> Tensors:
    """The step of the task with these values. For errors see `torch_step`."""
    for name, value in parameters.items():
        if value.ndim:
            raise ValueError(f"{name} must be a tensor [], not {list(value.shape)}")
    task = environment.with_parameters(
        **{name: float(each.detach()) for name, each in parameters.items()}
    )
    values = {name: value.to(torch.float64) for name, value in parameters.items()}
    if isinstance(environment, NoisyEnvironment) and not isinstance(task, NoisyEnvironment):
        task = NoisyEnvironment(task, 0.0, 0.0)  # its states still hold their places
    if isinstance(task, NoisyEnvironment):
        return _noisy_step(task, states, actions, values)
    for name in NOISE & values.keys():  # they are 0, otherwise the task would be noisy
        del values[name]
    if isinstance(task, TorchEnvironment):
        task.check_inside(states.detach().numpy(), actions.detach().numpy())
        return task.with_tensors(values).transitions(states, actions)
    others = torch.from_numpy(task.parameter_values)
    place = {name: i for i, name in enumerate(task.parameters)}
    vector = torch.stack([values.get(name, others[i]) for name, i in place.items()])
    found: Tensors = _ParametricStep.apply(task, vector, states, actions)  # type: ignore[no-untyped-call]
    return found


def _noisy_step(
    task: NoisyEnvironment,
    states: torch.Tensor,
    actions: torch.Tensor,
    values: Mapping[str, torch.Tensor],
) -> Tensors:
    """The step of the task without noise, from the disturbed states."""
    n = task.task.state_size
    numbers, places = _Noise.of(task, states, actions)
    moved = states[..., :n] + values.get(PROCESS, task.process_noise) * numbers
    if task.process_noise:
        moved = torch.clamp(moved, *map(torch.from_numpy, task.limits))
    others = {name: value for name, value in values.items() if name not in NOISE}
    following, reward, terminated = torch_step(task.task, moved, actions, others)
    return torch.cat([following, places], dim=-1), reward, terminated


# torch.compile would trace into numpy and numba.
_uncompiled_parametric_step: Any = torch.compiler.disable(_parametric_step)  # type: ignore[no-untyped-call]
_uncompiled_noisy_step: Any = torch.compiler.disable(_noisy_step)  # type: ignore[no-untyped-call]


class _OfRows(torch.autograd.Function):
    """A function of a task, states [batch, n] and actions [batch, m], row by row."""

    @classmethod
    def of(cls, environment: Environment, *rows: torch.Tensor) -> Tensors:
        """The function, as torch differentiates and transforms it."""
        results: Tensors = cls.apply(environment, *rows)  # type: ignore[no-untyped-call]
        return results

    @staticmethod
    def setup_context(context: Any, inputs: tuple[Any, ...], output: Tensors) -> None:
        del output
        context.environment, *rows = inputs
        context.save_for_backward(*rows)
        context.save_for_forward(*rows)

    @classmethod
    def vmap(
        cls,
        info: Any,
        in_dims: tuple[int | None, ...],
        environment: Environment,
        *rows: torch.Tensor,
    ) -> tuple[Tensors, tuple[int, ...]]:
        """Flatten the rows of all batches, so that one call computes them."""
        dims = in_dims[1:]
        first = [
            r.expand(info.batch_size, *r.shape) if dim is None else r.movedim(dim, 0)
            for r, dim in zip(rows, dims, strict=True)
        ]
        results = cls.of(environment, *(r.flatten(0, 1) for r in first))
        shape = first[0].shape[:2]
        return tuple(r.view(*shape, *r.shape[1:]) for r in results), (0,) * len(results)


class _Noise(_OfRows):
    """Constants: noise of standard deviation 1 [batch, n], and the next places [batch, 2]."""

    @staticmethod
    def forward(environment: Environment, states: torch.Tensor, actions: torch.Tensor) -> Tensors:
        del actions
        task = cast("NoisyEnvironment", environment)
        places = states.detach().numpy()[:, task.task.state_size :]
        numbers = task.process_numbers(places)
        return torch.from_numpy(numbers), torch.from_numpy(next_places(places))

    @staticmethod
    def setup_context(context: Any, inputs: tuple[Any, ...], output: Tensors) -> None:
        del inputs
        context.mark_non_differentiable(*output)

    @staticmethod
    def backward(context: Any, *gradients: torch.Tensor) -> tuple[None, None, None]:
        del context, gradients
        return None, None, None

    @staticmethod
    def jvp(context: Any, *tangents: torch.Tensor | None) -> tuple[None, None]:
        del context, tangents
        return None, None


class _Step(_OfRows):
    """The transition."""

    @staticmethod
    def forward(environment: Environment, states: torch.Tensor, actions: torch.Tensor) -> Tensors:
        transition = environment.step(states.detach().numpy(), actions.detach().numpy())
        return tuple(map(torch.from_numpy, transition))

    @staticmethod
    def setup_context(context: Any, inputs: tuple[Any, ...], output: Tensors) -> None:
        _OfRows.setup_context(context, inputs, output)
        _, reward, terminated = output
        constant = [terminated] if inputs[0].reward_is_differentiable else [terminated, reward]
        context.mark_non_differentiable(*constant)

    @staticmethod
    def backward(
        context: Any, next_gradient: torch.Tensor, reward_gradient: torch.Tensor, _: Any
    ) -> tuple[None, torch.Tensor, torch.Tensor]:
        J_s, J_a, r_s, r_a, r_next = _Derivatives.of(context.environment, *context.saved_tensors)
        by_reward = reward_gradient[:, None]
        arriving = (next_gradient + by_reward * r_next)[:, None]
        by_state = (arriving @ J_s)[:, 0] + by_reward * r_s
        by_action = (arriving @ J_a)[:, 0] + by_reward * r_a
        return None, by_state, by_action

    @staticmethod
    def jvp(
        context: Any, _: Any, *tangents: torch.Tensor | None
    ) -> tuple[torch.Tensor, torch.Tensor | None, None]:
        with _forward_mode_enabled():
            (states, actions), (ds, da) = _primals_and_tangents(context, tangents)
            J_s, J_a, r_s, r_a, r_next = _Derivatives.of(context.environment, states, actions)
            next_tangent = (J_s @ ds[..., None] + J_a @ da[..., None])[..., 0]
            if not context.environment.reward_is_differentiable:
                return next_tangent, None, None
            by_rows = (r_s * ds).sum(-1) + (r_a * da).sum(-1)
            return next_tangent, by_rows + (r_next * next_tangent).sum(-1), None


# torch.compile would trace into numpy and numba.
_uncompiled_step: Any = torch.compiler.disable(_Step.of)  # type: ignore[no-untyped-call]


class _ParametricStep(torch.autograd.Function):
    """The transition of a compiled task, also as a function of its parameters [k]."""

    @staticmethod
    def forward(
        context: Any,
        environment: Environment,
        values: torch.Tensor,
        states: torch.Tensor,
        actions: torch.Tensor,
    ) -> Tensors:
        del values  # those of the environment
        context.environment = environment
        context.save_for_backward(states, actions)
        transition = environment.step(states.numpy(), actions.numpy())
        next_state, reward, terminated = map(torch.from_numpy, transition)
        constant = [terminated] if environment.reward_is_differentiable else [terminated, reward]
        context.mark_non_differentiable(*constant)
        return next_state, reward, terminated

    @staticmethod
    @once_differentiable
    def backward(
        context: Any, next_gradient: torch.Tensor, reward_gradient: torch.Tensor, _: Any
    ) -> tuple[None, torch.Tensor | None, torch.Tensor, torch.Tensor]:
        task, rows = context.environment, [each.numpy() for each in context.saved_tensors]
        J_s, J_a, r_s, r_a, r_next = map(torch.from_numpy, task.differentiate(*rows)[1:])
        by_reward = reward_gradient[:, None]
        arriving = next_gradient + by_reward * r_next
        by_state = torch.einsum("bi,bij->bj", arriving, J_s) + by_reward * r_s
        by_action = torch.einsum("bi,bij->bj", arriving, J_a) + by_reward * r_a
        J_p, r_p = map(torch.from_numpy, task.differentiate_parameters(*rows))
        by_value = torch.einsum("bi,bij->j", arriving, J_p) + reward_gradient @ r_p
        return None, by_value, by_state, by_action


class _Derivatives(_OfRows):
    """The derivatives of the transition, in the order of a `Linearization`."""

    @staticmethod
    def forward(environment: Environment, states: torch.Tensor, actions: torch.Tensor) -> Tensors:
        linearization = environment.differentiate(states.detach().numpy(), actions.detach().numpy())
        return tuple(map(torch.from_numpy, linearization[1:]))

    @staticmethod
    def backward(context: Any, *gradients: torch.Tensor) -> tuple[Any, ...]:
        task = _twice_differentiable(context.environment)
        with gradients_enabled():
            pull = torch.func.vjp(task.derivatives, *context.saved_tensors)[1]
            return None, *pull(gradients)

    @staticmethod
    def jvp(context: Any, _: Any, *tangents: torch.Tensor | None) -> Tensors:
        task = _twice_differentiable(context.environment)
        with gradients_enabled(), _forward_mode_enabled():
            rows, (ds, da) = _primals_and_tangents(context, tangents)
            # By reverse mode: torch.func.jvp inside a jvp was wrong for batched tangents.
            slopes = vmap(jacrev(task.derivatives_of_row, argnums=(0, 1)))(*rows)
            along = "b...i,bi->b..."
            return tuple(torch.einsum(along, s, ds) + torch.einsum(along, a, da) for s, a in slopes)


def _forward_mode_enabled() -> AbstractContextManager[None]:
    """Enable forward mode inside a `jvp`, where torch drops the tangents of outer levels.

    Without it, nested tangents would be 0. torch has no public name for it.
    """
    return forward_ad._set_fwd_grad_enabled(True)


def _primals_and_tangents(
    context: Any, tangents: tuple[torch.Tensor | None, ...]
) -> tuple[Tensors, Tensors]:
    """The saved rows without the tangents of this level, and these tangents, 0 where None."""
    unpack: Any = forward_ad.unpack_dual
    primals = tuple(unpack(row).primal for row in context.saved_tensors)
    full = (
        torch.zeros_like(primal) if tangent is None else tangent
        for primal, tangent in zip(primals, tangents, strict=True)
    )
    return primals, tuple(full)


def _twice_differentiable(environment: Environment) -> TorchEnvironment:
    """The task, if it has second derivatives."""
    if isinstance(environment, TorchEnvironment):
        return environment
    raise RuntimeError(
        f"{environment.name} has no second derivative: its Jacobians are compiled, not torch "
        "functions; drop create_graph=True and nested transforms, or write it as TorchEnvironment"
    )
