"""An algorithm in one word: `hybrid-ddpg:0.1,0.01:noise=0.1,0.2:label=mine`.

After the name, parts between colons: a pair of weights, or NAME=VALUE of a weight, a setting,
`label` or `zip`. Values between commas are a list, which is a grid.
"""

from __future__ import annotations

from typing import Any

import typer
import yaml

from service.cli.sweep_file import Json, SweepLoader
from workers.messages.run_spec import Weights

ALGORITHM_TEXT = "NAME, NAME:W1,W2 or NAME:SETTING=VALUE,...:SETTING=..."
EXAMPLE = "hybrid-ddpg:0.1,0.01 or ddpg:noise=0.1,0.2:tau=0.02"


def algorithm_of(text: str) -> Json:
    """Read an algorithm as a request has it. Raises typer.BadParameter."""
    name, *parts = text.split(":")
    algorithm: Json = {"name": name}
    for part in parts:
        key, equals, value = part.partition("=")
        if not equals:
            _set(algorithm, text, "weights", _pair(text, part))
        elif key in Weights._fields:
            _set(algorithm.setdefault("weights", {}), text, key, values_of(value))
        elif key == "label":
            _set(algorithm, text, key, value)
        elif key == "zip":
            _set(algorithm, text, key, value.split(","))
        else:
            _set(algorithm.setdefault("config", {}), text, key, values_of(value))
    return algorithm


def values_of(text: str) -> Any:
    """Read `0.1` as a number, and `0.1,0.2` as a list; values are those of YAML."""
    values = [yaml.load(each, SweepLoader) for each in text.split(",")]  # noqa: S506 (a safe one)
    return values if len(values) > 1 else values[0]


def _set(target: Json, text: str, key: str, value: Any) -> None:
    if key in target or not key:
        raise _refusal(text, f"it names {key} twice" if key else "it has a value without a name")
    target[key] = value


def _pair(text: str, part: str) -> Json:
    try:
        return Weights._make(map(float, part.split(",")))._asdict()
    except (ValueError, TypeError) as error:
        raise _refusal(text, f"{part!r} is neither W1,W2 nor SETTING=VALUE") from error


def _refusal(text: str, reason: str) -> typer.BadParameter:
    return typer.BadParameter(
        f"{text!r} is not an algorithm: {reason}. Write {ALGORITHM_TEXT}, as in {EXAMPLE}",
        param_hint="--algorithm",
    )
