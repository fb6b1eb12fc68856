"""Torch task check: calls a task's functions on a few of its own start states.

Each must return a tensor of its shape and dtype, for one row and under `vmap`; and its derivatives
under `vmap` must be those of the rows one by one, because torch differentiates some operations
wrongly there (such as `torch.linalg.lu_solve`). Whether numbers are finite is checked in each step.
"""

from collections.abc import Callable, Iterator
from pathlib import Path
from types import CodeType
from typing import TYPE_CHECKING, Any, NamedTuple, TypeAlias, Union

import numpy as np
import torch
from torch.func import jacrev, vmap

from physics.drawing_check import drawing_mistakes
from physics.randomness import generator

if TYPE_CHECKING:
    from physics.mujoco.torch_functions import TorchMujocoTask
    from physics.torch_environment import TorchEnvironment

WithOutcome: TypeAlias = Union["TorchEnvironment", "TorchMujocoTask"]
"""A task whose reward and end are torch functions."""

ROWS = 3
SAME = 1e-9
"""How far derivatives may differ by rounding, relative to the largest."""


class Trial(NamedTuple):
    """A function of one row, its arguments for several rows, and what it must return."""

    name: str
    function: Callable[..., Any]
    arguments: tuple[torch.Tensor, ...]
    """Each [ROWS, ...]."""
    shape: list[int]
    dtype: torch.dtype
    differentiated: bool
    constant: str
    """How to write a constant result."""


def function_mistakes(task: "TorchEnvironment") -> list[str]:
    """The mistakes in the functions of a task whose sizes are right."""
    states, actions, mistakes = _tried(task)
    dynamics = Trial(
        "dynamics", task.dynamics, (states, actions), [task.state_size], torch.float64, True,
        "state.clone()",
    )  # fmt: skip
    return mistakes + _mistakes((dynamics, *_outcome_trials(task, states, actions)))


def outcome_mistakes(task: WithOutcome) -> list[str]:
    """The mistakes in the reward and the end of a task whose sizes are right."""
    states, actions, mistakes = _tried(task)
    return mistakes + _mistakes(_outcome_trials(task, states, actions))


def _tried(task: WithOutcome) -> tuple[torch.Tensor, torch.Tensor, list[str]]:
    """States [ROWS, n], actions [ROWS, m], and the mistakes in start states and drawing."""
    starts, mistakes = _starts(task)
    mistakes += [] if mistakes else drawing_mistakes(task, starts[0])
    random = generator(0, "torch task check")
    actions = random.uniform(-1.0, 1.0, (ROWS, task.action_size))
    return torch.from_numpy(starts), torch.from_numpy(actions), mistakes


def _mistakes(trials: tuple[Trial, ...]) -> list[str]:
    """The first mistake of each trial that has one."""
    return [
        f"{mistake} ({_place(trial.function)})"
        for trial in trials
        if (mistake := next(_mistake(trial), None)) is not None
    ]


def _starts(task: WithOutcome) -> tuple[np.ndarray[Any, np.dtype[np.float64]], list[str]]:
    """Start states [ROWS, n]; other states and a mistake if they cannot be drawn."""
    try:
        return task.initial_states(range(ROWS)), []
    except ValueError as error:
        mistake = str(error)
    except Exception as error:
        mistake = f"initial_state raised {type(error).__name__}: {error}"
    other = generator(1, "torch task check").uniform(0.1, 1.0, (ROWS, task.state_size))
    return other, [mistake]


def _outcome_trials(
    task: WithOutcome, states: torch.Tensor, actions: torch.Tensor
) -> tuple[Trial, Trial]:
    """Trials of reward and end; the states also serve as next states, which may be wrong."""
    float64, differentiable = torch.float64, task.reward_is_differentiable is not False
    return (
        Trial(
            "reward", task.reward, (states, actions, states.flip(0)), [], float64, differentiable,
            "torch.full_like(state[0], -1.0)",
        ),
        Trial(
            "terminated", task.terminated, (states,), [], torch.bool, False,
            "torch.zeros_like(next_state[0], dtype=torch.bool)",
        ),
    )  # fmt: skip


def _mistake(trial: Trial) -> Iterator[str]:
    """The first mistake in a function; further ones would follow from it."""
    name, function, arguments = trial.name, trial.function, trial.arguments
    expected = f"must return a tensor {trial.shape} of {trial.dtype}"
    try:
        result = function(*(argument[0] for argument in arguments))
    except Exception as error:
        yield f"{name} raised {type(error).__name__}: {error}"
        return
    if not isinstance(result, torch.Tensor):
        yield f"{name} {expected}, not {_kind(result)}; a constant is written {trial.constant}"
        return
    if list(result.shape) != trial.shape or result.dtype != trial.dtype:
        yield f"{name} {expected}, not {list(result.shape)} of {result.dtype}"
    try:
        batched = [vmap(function)(*arguments)]
        single = [torch.stack([function(*row) for row in zip(*arguments, strict=True)])]
        if trial.differentiated:
            slopes = jacrev(function, argnums=tuple(range(len(arguments))))
            batched += vmap(slopes)(*arguments)
            rows = [slopes(*row) for row in zip(*arguments, strict=True)]
            single += [torch.stack(column) for column in zip(*rows, strict=True)]
    except Exception as error:
        yield (
            f"{name} cannot be batched and differentiated by torch.func: use torch's functions "
            "alone, no numpy or math, no float() or .item(), torch.where instead of if "
            f"({type(error).__name__}: {str(error).splitlines()[0]})"
        )
        return
    if not all(_agree(one, other) for one, other in zip(batched, single, strict=True)):
        yield (
            f"{name} gives other numbers or derivatives under torch.func.vmap than row by row: it "
            "draws random numbers, or torch is wrong about an operation in it (such as "
            "torch.linalg.lu_solve; torch.linalg.solve is right)"
        )


def _place(function: Callable[..., Any]) -> str:
    """Where the author wrote a function."""
    code: CodeType = function.__code__
    return f"{Path(code.co_filename).name}, line {code.co_firstlineno}"


def _kind(result: Any) -> str:
    if isinstance(result, np.ndarray):
        return f"a numpy array {list(result.shape)} of {result.dtype}"
    return f"{type(result).__name__} {result!r}"


def _agree(one: torch.Tensor, other: torch.Tensor) -> bool:
    """Whether two results are the same but for rounding; NaN agrees with NaN."""
    if one.dtype == torch.bool:
        return bool((one == other).all())
    scale = float(other.nan_to_num(0.0, 0.0, 0.0).abs().max()) if other.numel() else 0.0
    return torch.allclose(one, other, rtol=SAME, atol=SAME * scale, equal_nan=True)
