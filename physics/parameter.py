"""Parameters: the physical constants of a task that may be changed, declared in its class.

    class Pendulum(Environment):
        gravity = Parameter(10.0, "m/s^2", least=0.0, greatest=100.0, meaning="gravity")

`Pendulum().gravity` is 10.0, and `physics.make("Pendulum", gravity=9.81).gravity` is 9.81. A task
with other values is written `Pendulum(gravity=9.81)`: its label, which `physics.make` reads too.
"""

import re
from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass
from difflib import get_close_matches
from functools import cached_property, partial
from inspect import getattr_static
from math import isfinite
from numbers import Real
from typing import Any, overload

_LABEL = re.compile(r"(?P<name>.+?)\((?P<values>[^()]*)\)")
_LARGEST_WHOLE = 1e16  # above it, floats are shown by their exponent


@dataclass(eq=False)
class Parameter:
    """A physical constant: its value on an instance, this declaration on the class."""

    default: float
    unit: str
    """The unit as text, such as "kg m^2"; "1" for a number without a unit."""
    least: float
    greatest: float
    meaning: str = ""
    name: str = ""
    """The name of the attribute in the class that declares it."""
    of_every_task: bool = False
    """Whether every task has it, without declaring it."""

    def __set_name__(self, owner: type, name: str) -> None:
        """Take the name of the attribute."""
        self.name = name

    @overload
    def __get__(self, task: None, owner: type) -> "Parameter": ...
    @overload
    def __get__(self, task: object, owner: type) -> Any: ...
    def __get__(self, task: Any, owner: type) -> Any:
        """Its value in a task: a number, or a tensor where `torch_step` is given one."""
        return self if task is None else task.changed.get(self.name, self.default)

    def __set__(self, task: object, value: object) -> None:
        """Raise AttributeError: a task is never changed."""
        raise AttributeError(
            f"a task is never changed: make another with with_parameters({self.name}={value!r})"
        )

    def mistake(self, value: Any) -> str | None:
        """The mistake in a value; None if there is none."""
        is_number = not isinstance(value, bool) and isinstance(value, Real) and isfinite(value)
        if is_number and self.least <= value <= self.greatest:
            return None
        unit = "" if self.unit == "1" else f" {self.unit}"
        return (
            f"{self.name} must be a number from {number_text(self.least)} to "
            f"{number_text(self.greatest)}{unit}, not {value!r}"
        )


class WithParameters(cached_property[Callable[..., Any]]):
    """A kernel whose first argument holds the values of its task's parameters, float64 [k].

    The values are in the order of declaration. They are not constants of the compiled code, so that
    other values do not compile it again.
    """

    def __init__(self, kernel: Callable[..., Any]) -> None:
        """Wrap a kernel, as the attribute of a class of tasks."""
        super().__init__(lambda task: partial(kernel, task.parameter_values))


def declared(cls: type) -> dict[str, Parameter]:
    """The parameters of a class of tasks by name, those of its bases first.

    A parameter that a derived class replaces by a number is a constant there.
    """
    names = (name for base in reversed(cls.__mro__) for name in vars(base))
    found = {name: getattr_static(cls, name) for name in names}
    return {name: value for name, value in found.items() if isinstance(value, Parameter)}


def declaration_mistakes(cls: type) -> Iterator[str]:
    """The mistakes in the parameters that a class of tasks declares."""
    for name, parameter in declared(cls).items():
        hidden = [base for base in cls.__mro__ if name in vars(base)][-1]
        if not isinstance(vars(hidden)[name], Parameter):
            yield f"the parameter {name} needs another name: {hidden.__name__}.{name} is taken"
        if (mistake := parameter.mistake(parameter.default)) is not None:
            yield f"the default of {mistake}"


def checked(
    task: str, parameters: Iterable[Parameter], values: Mapping[str, Any]
) -> dict[str, float]:
    """The values as floats.

    Raises:
        ValueError: with every name that is not a parameter and every value out of its range.
    """
    known = {parameter.name: parameter for parameter in parameters}
    mistakes = [
        unknown_name(name, known) if name not in known else known[name].mistake(value)
        for name, value in values.items()
    ]
    if any(mistakes):
        raise ValueError(f"{task}: {'; '.join(filter(None, mistakes))}")
    return {name: float(values[name]) for name in known if name in values}


def unknown_name(name: str, known: Mapping[str, Parameter]) -> str:
    """The error message for a name that is not a parameter."""
    near = get_close_matches(name, known, n=1, cutoff=0.5)
    hint = f"; did you mean {near[0]!r}?" if near else ""
    own = [each for each, parameter in known.items() if not parameter.of_every_task]
    others = [each for each in known if each not in own]
    also = f"; every task has {' and '.join(others)}" if others else ""
    return f"there is no parameter {name!r}{hint} (known: {', '.join(own) or 'none'}){also}"


def label(name: str, values: Mapping[str, float]) -> str:
    """A task as text: its name, and the values that were given, by name."""
    told = ", ".join(f"{each}={number_text(values[each])}" for each in sorted(values))
    return f"{name}({told})" if told else name


def name_of(text: str) -> str:
    """The name of a task in a label, without its values."""
    return text.partition("(")[0]


def parse(text: str) -> tuple[str, dict[str, float]]:
    """The name of a task and the values of a label.

    Raises:
        ValueError: for values that are not written `gravity=9.81, length=1`.
    """
    found = _LABEL.fullmatch(text)
    if found is None:
        return text, {}
    values: dict[str, float] = {}
    for each in filter(None, map(str.strip, found["values"].split(","))):
        name, equals, value = map(str.strip, each.partition("="))
        try:
            number = float(value)
        except ValueError:
            number = None
        if not equals or number is None or name in values:
            raise ValueError(f"{text!r}: expected name=number, each name once, not {each!r}")
        values[name] = number
    return found["name"], values


def relabelled(text: str) -> str:
    """A label in the form that `label` writes; text that is not a label is returned unchanged."""
    try:
        return label(*parse(text))
    except ValueError:
        return text


def number_text(value: float) -> str:
    """A number as a label shows it: two texts are the same if and only if the numbers are equal."""
    value = float(value)
    if value.is_integer() and abs(value) < _LARGEST_WHOLE:
        return str(int(value))
    short = f"{value:g}"
    return short if float(short) == value else repr(value)
