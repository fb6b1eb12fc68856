"""Records: the arrays that kernels share, in one block, with sizes known at compile time.

A layout is a class of annotated fields, such as `q: Annotated[Floats, "n"]` for an array [n];
`dtype` turns it into a structured NumPy type once the sizes are known. Kernels pass a record as a
single pointer (a tuple of thirty arrays is some 300 words per call), and the compiler knows every
shape.

A record is an element of an array, and does not keep the array alive: a kernel that makes one with
`storage = np.empty(1, TYPE)` passes `storage[0]` to a function, and never returns it.
"""

from typing import Any, get_args, get_origin, get_type_hints

import numpy as np
import numpy.typing as npt

Floats = npt.NDArray[np.float64]
Integers = npt.NDArray[np.int64]
Records = npt.NDArray[np.void]


def dtype(layout: type, **sizes: int) -> np.dtype[np.void]:
    """The structured type of a layout, with the sizes that its shapes name.

    A shape may be an expression of sizes ("2 * k"). Fields without a shape are scalars or layouts.
    Fields are attributes outside kernels, too: `np.zeros(1, dtype(...))[0].q`.
    """
    hints = get_type_hints(layout, include_extras=True)
    fields = np.dtype([(name, *_field(hint, sizes)) for name, hint in hints.items()], align=True)
    return np.dtype((np.record, fields))


def _field(hint: Any, sizes: dict[str, int]) -> tuple[Any, ...]:
    """The type of a field and, for an array, its shape."""
    if get_origin(hint) is None:
        return (hint,) if hint in (int, float) else (dtype(hint, **sizes),)
    array, *shape = get_args(hint)
    scalar = get_args(get_args(array)[1])[0]
    return scalar, tuple(_size(length, sizes) for length in shape)


def _size(length: str, sizes: dict[str, int]) -> int:
    """A length such as "n" or "2 * k"."""
    *factors, name = length.split(" * ")
    return (int(name) if name.isdigit() else sizes[name]) * (int(factors[0]) if factors else 1)
