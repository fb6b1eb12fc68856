"""Task check: finds all mistakes in a task's declaration at once.

Every task is checked when it is made, so that a mistake is named here and does not appear later as
a wrong shape in a worker.
"""

import re
from abc import ABCMeta
from collections.abc import Callable, Iterator, Mapping
from math import isfinite
from numbers import Integral, Real
from typing import TYPE_CHECKING, Any, NamedTuple

from physics import parameter

if TYPE_CHECKING:
    from physics.environment import Environment

_MISSING = object()


class CheckedWhenMade(ABCMeta):
    """The metaclass of tasks: an invalid task is refused when it is made."""

    def __call__(cls, *args: Any, **kwargs: Any) -> Any:
        """Make a task.

        Raises:
            ValueError: with all mistakes in it.
        """
        task: Environment = super().__call__(*args, **kwargs)
        mistakes = declaration_mistakes(task)
        if not sizes_are_wrong(task):
            mistakes += task.function_mistakes()
        if mistakes:
            raise ValueError("\n- ".join([f"{cls.__name__} is not a valid task:", *mistakes]))
        return task


class Rule(NamedTuple):
    """What a constant must be."""

    name: str
    expected: str
    fits: Callable[[Any], bool]


def is_whole(value: Any, least: int = 1) -> bool:
    """Whether a value is an integer of at least `least`; True and False are not."""
    return not isinstance(value, bool) and isinstance(value, Integral) and int(value) >= least


def is_number(value: Any) -> bool:
    """Whether a value is a finite number."""
    return not isinstance(value, bool) and isinstance(value, Real) and isfinite(value)


def are_names(value: Any) -> bool:
    """Whether a value is a tuple of different texts, at least one."""
    if not isinstance(value, tuple) or not all(isinstance(each, str) and each for each in value):
        return False
    return len(set(value)) == len(value) > 0


def is_name(value: Any) -> bool:
    """Whether a value is valid in an address: a word, or a family and a member (`a/b`)."""
    word = r"[A-Za-z0-9][A-Za-z0-9_.-]*"
    return isinstance(value, str) and re.fullmatch(rf"({word}/)?{word}", value) is not None


COORDINATES = ("angles", "hidden", "bounds", "clipped", "noise_factors")
"""Constants that name coordinates."""
SIZES = (
    Rule("state_size", "an integer from 1 on", is_whole),
    Rule("action_size", "an integer from 1 on", is_whole),
)
RULES = (
    Rule("name", "a word of letters, digits, '_', '-' and '.'", is_name),
    Rule("version", "an integer from 1 on", is_whole),
    *SIZES,
    Rule("horizon", "an integer from 1 on", is_whole),
    Rule("max_reward", "a finite number", is_number),
    Rule("step_seconds", "a number above 0", lambda value: is_number(value) and value > 0),
    Rule(
        "rounding",
        "a number above 0, at most 4e-13",
        lambda value: is_number(value) and 0 < value <= 4e-13,
    ),
    Rule("tolerance", "a number above 0", lambda value: is_number(value) and value > 0),
    Rule("reward_is_differentiable", "True or False", lambda value: isinstance(value, bool)),
    Rule("angles", "a mapping of coordinates", lambda value: isinstance(value, Mapping)),
    Rule("hidden", "a tuple of coordinates", lambda value: isinstance(value, tuple)),
    Rule("bounds", "a mapping of coordinates", lambda value: isinstance(value, Mapping)),
    Rule("clipped", "a mapping of coordinates", lambda value: isinstance(value, Mapping)),
    Rule("noise_factors", "a mapping of coordinates", lambda value: isinstance(value, Mapping)),
    Rule("feature_order", "a tuple of places", lambda value: isinstance(value, tuple)),
    Rule("regimes", "a tuple of different names, at least one", are_names),
    Rule("step_kernel", "a function", callable),
    Rule("differentiate_kernel", "a function", callable),
)


def sizes_are_wrong(task: "Environment") -> bool:
    """Whether the sizes are invalid, so that shapes of arrays cannot be checked."""
    return any(not rule.fits(getattr(task, rule.name, _MISSING)) for rule in SIZES)


def declaration_mistakes(task: "Environment") -> list[str]:
    """Every constant that is missing or impossible."""
    found = {rule: getattr(task, rule.name, _MISSING) for rule in RULES}
    wrong = {rule: value for rule, value in found.items() if not rule.fits(value)}
    mistakes = [
        f"{rule.name} is missing: it must be {rule.expected}"
        if value is _MISSING
        else f"{rule.name} must be {rule.expected}, not {value!r}"
        for rule, value in wrong.items()
    ]
    if not {"state_size", *COORDINATES, "feature_order"} & {rule.name for rule in wrong}:
        mistakes += coordinate_mistakes(task)
    return [*mistakes, *parameter.declaration_mistakes(type(task))]


def coordinate_mistakes(task: "Environment") -> Iterator[str]:
    """The mistakes in the coordinates that the task names."""
    n = task.state_size
    for where in COORDINATES:
        for i in getattr(task, where):
            if not is_whole(i, least=0) or i >= n:
                yield f"{where} names coordinate {i!r}; a state has the coordinates 0 to {n - 1}"
    for i, multiplicity in task.angles.items():
        if not is_whole(multiplicity):
            yield f"angles[{i!r}] must be an integer from 1 on, not {multiplicity!r}"
    for i, bounds in task.bounds.items():
        if not _is_interval(bounds):
            yield f"bounds[{i!r}] must be (least, greatest), two numbers, not {bounds!r}"
    for i, factor in task.noise_factors.items():
        if not is_number(factor) or factor < 0:
            yield f"noise_factors[{i!r}] must be a number from 0 on, not {factor!r}"
    yield from _feature_mistakes(task)
    if set(range(n)) <= set(task.hidden):
        yield "hidden names every coordinate: networks would see nothing"


def _feature_mistakes(task: "Environment") -> Iterator[str]:
    """The mistakes in the declaration of features."""
    for i, limit in task.clipped.items():
        if not is_number(limit) or limit <= 0:
            yield f"clipped[{i!r}] must be a number above 0, not {limit!r}"
        if i in task.angles or i in task.hidden:
            yield f"coordinate {i!r} is clipped, and an angle or hidden"
    for i in sorted(set(task.angles) & set(task.hidden), key=repr):
        yield f"coordinate {i!r} is both an angle and hidden"
    size = task.state_size + len(task.angles) - len(task.hidden)
    if task.feature_order and sorted(task.feature_order, key=repr) != sorted(range(size), key=repr):
        yield f"feature_order must hold each of 0 to {size - 1} once, not {task.feature_order!r}"


def _is_interval(bounds: Any) -> bool:
    if not isinstance(bounds, tuple) or len(bounds) != 2:
        return False
    return all(isinstance(bound, Real) for bound in bounds) and bounds[0] < bounds[1]
