"""A sweep's file: YAML, whose numbers are those that people write.

PyYAML reads YAML 1.1, in which `1e-4` is a text, `1:30` is ninety and `2026-11-29` a date. Here a
plain scalar is what YAML 1.2's core schema says (section 10.3.2), and whole numbers may be written
`20_000`, as YAML 1.1 and Python have it.
"""

from __future__ import annotations

import re
import sys
from pathlib import Path
from typing import Any

import typer
import yaml

Json = dict[str, Any]

LARGEST_WHOLE = 2**53  # beyond, a float is not the number that was written
DIGITS = "0123456789"
SCALARS = {
    "null": (r"~|null|Null|NULL|", ["~", "n", "N", ""]),
    "bool": (r"true|True|TRUE|false|False|FALSE", list("tTfF")),
    "int": (r"[-+]?[0-9][0-9_]*|0o[0-7]+|0x[0-9a-fA-F]+", list(f"-+{DIGITS}")),
    "float": (
        r"[-+]?(\.[0-9]+|[0-9][0-9_]*(\.[0-9]*)?)([eE][-+]?[0-9]+)?"
        r"|[-+]?\.(inf|Inf|INF)|\.(nan|NaN|NAN)",
        list(f"-+.{DIGITS}"),
    ),
    "merge": ("<<", ["<"]),
}
"""By tag: what a plain scalar looks like, and how it begins. The first that fits is taken."""


class SweepLoader(yaml.SafeLoader):
    """PyYAML's loader of plain data, with the scalars of YAML 1.2."""

    def construct_whole(self, node: yaml.ScalarNode) -> int:
        """Return a whole number; leading zeros mean nothing."""
        text = self.construct_scalar(node).replace("_", "")
        return int(text, 0) if text.startswith(("0o", "0x")) else int(text)

    def construct_mapping(self, node: yaml.MappingNode, deep: bool = False) -> dict[Any, Any]:
        """Return a mapping. Raises a YAMLError for a repeated key."""
        first: dict[str, yaml.Node] = {}
        for key, _ in node.value:
            if key.value == "<<" or not isinstance(key.value, str):
                continue
            if (earlier := first.setdefault(key.value, key)) is not key:
                message = f"{key.value!r} appears twice, first in line"
                line = earlier.start_mark.line + 1
                raise yaml.constructor.ConstructorError(
                    None, None, f"{message} {line}", key.start_mark
                )
        return super().construct_mapping(node, deep)

    def construct_number(self, node: yaml.ScalarNode) -> float:
        """Return a number; a whole one where it is written without a point, as in `2e4`."""
        value: float = self.construct_yaml_float(node)
        is_whole = "." not in node.value and value.is_integer() and abs(value) <= LARGEST_WHOLE
        return int(value) if is_whole else value


SweepLoader.yaml_implicit_resolvers = {}  # of YAML 1.1, which it would inherit
for tag, (pattern, beginnings) in SCALARS.items():
    SweepLoader.add_implicit_resolver(
        f"tag:yaml.org,2002:{tag}", re.compile(rf"(?:{pattern})\Z"), beginnings
    )
SweepLoader.add_constructor("tag:yaml.org,2002:int", SweepLoader.construct_whole)
SweepLoader.add_constructor("tag:yaml.org,2002:float", SweepLoader.construct_number)


def read_request(file: Path) -> Json:
    """The sweep in a YAML file; raises typer.BadParameter with what is wrong with it."""
    try:
        text = sys.stdin.read() if str(file) == "-" else file.read_text(encoding="utf-8")
        request = yaml.load(text, SweepLoader)  # noqa: S506  (a safe loader)
    except OSError as error:
        raise typer.BadParameter(f"cannot read {file}: {error.strerror}") from error
    except (yaml.YAMLError, ValueError) as error:  # no UTF-8; a number of thousands of digits
        raise typer.BadParameter(f"{file} is not YAML: {error}") from error
    if not isinstance(request, dict):
        raise typer.BadParameter(
            f"{file} must hold a mapping with the keys algorithms, environments, seeds and "
            f"timesteps, not a {type(request).__name__}"
        )
    return request
