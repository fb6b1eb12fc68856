"""Policy file: a trained policy as a NumPy archive, `.npz`, that is read without pickle.

    header              text: the JSON of algorithms.acting.header.Header
    mean, inverse_std   [F]
    hidden/k/weight     [inputs, units] of hidden layer k, from 0
    hidden/k/bias, hidden/k/gain, hidden/k/shift    [units]
    output/weight       [units, m]
    output/bias         [m]

All arrays but the header are float32. Equal policies give equal bytes.
"""

import io
import json
from collections.abc import Iterator, Mapping
from itertools import pairwise
from pathlib import Path

import numpy as np
from pydantic import TypeAdapter, ValidationError

from algorithms.acting.header import Header
from algorithms.acting.policy import TrainedPolicy
from algorithms.networks.layer import Layer
from algorithms.networks.parameters import Output
from algorithms.state import State, part, within

SUFFIX = ".npz"
HEADER = TypeAdapter(Header)


def save_policy(policy: TrainedPolicy, path: str | Path) -> None:
    """Write a policy.

    Raises:
        ValueError: for a path that does not end in .npz.
        OSError: if the file cannot be written.
    """
    check_suffix(path)
    Path(path).write_bytes(policy_bytes(policy))


def check_suffix(path: str | Path) -> None:
    """Raise ValueError for a path without the suffix of a policy's file."""
    if Path(path).suffix != SUFFIX:
        raise ValueError(f"{path} must end in {SUFFIX}: a policy is a NumPy archive")


def policy_bytes(policy: TrainedPolicy) -> bytes:
    """The content of a policy's file."""
    arrays = {"mean": policy.mean, "inverse_std": policy.inverse_std}
    arrays |= within("output", policy.output._asdict())
    for k, layer in enumerate(policy.layers):
        arrays |= within(f"hidden/{k}", layer._asdict())
    header = np.array(json.dumps(policy.header.document(), allow_nan=False))
    buffer = io.BytesIO()
    np.savez(buffer, allow_pickle=False, header=header, **arrays)
    return buffer.getvalue()


def load_policy(source: str | Path | bytes) -> TrainedPolicy:
    """Read a policy.

    Args:
        source: the path of a file, or the content of one.

    Raises:
        ValueError: for a file that does not hold a policy; the message says why.
        OSError: for a file that cannot be read.
    """
    if isinstance(source, bytes):
        content, name = source, "the content"
    else:
        content, name = Path(source).read_bytes(), str(source)
    try:
        return _policy(_arrays(content))
    except ValueError as error:
        raise ValueError(f"{name} is not a policy: {error}") from error


def _arrays(content: bytes) -> State:
    try:
        with np.load(io.BytesIO(content), allow_pickle=False) as file:
            return {name: file[name] for name in file.files}
    except Exception as error:  # readers of archives raise many types of errors
        raise ValueError(f"it is not a complete NumPy archive ({error})") from error


def _policy(arrays: State) -> TrainedPolicy:
    header = _header(arrays)
    if mistakes := list(_mistakes(_shapes(header), arrays)):
        raise ValueError("; ".join(mistakes))
    hidden = [part(arrays, f"hidden/{k}") for k in range(len(header.hidden_units))]
    return TrainedPolicy(
        header,
        arrays["mean"],
        arrays["inverse_std"],
        [Layer(**layer) for layer in hidden],
        Output(**part(arrays, "output")),
    )


def _shapes(header: Header) -> dict[str, tuple[int, ...]]:
    """The shape that each array must have."""
    sizes = [header.feature_map.size, *header.hidden_units]
    shapes: dict[str, tuple[int, ...]] = {"mean": (sizes[0],), "inverse_std": (sizes[0],)}
    for k, (inputs, units) in enumerate(pairwise(sizes)):
        vectors = {f"hidden/{k}/{name}": (units,) for name in ("bias", "gain", "shift")}
        shapes |= {f"hidden/{k}/weight": (inputs, units), **vectors}
    m = header.action_size
    return shapes | {"output/weight": (sizes[-1], m), "output/bias": (m,)}


def _mistakes(shapes: Mapping[str, tuple[int, ...]], arrays: State) -> Iterator[str]:
    """The mistakes in the arrays, one sentence each."""
    for name in sorted(arrays.keys() - shapes.keys() - {"header"}):
        yield f"the array {name!r} is unknown"
    for name, shape in shapes.items():
        array = arrays.get(name)
        if array is None:
            yield f"the array {name!r} is missing"
        elif array.dtype != np.float32 or array.shape != shape:
            yield f"{name} must be float32 {list(shape)}, not {array.dtype} {list(array.shape)}"
        elif not np.isfinite(array).all():
            yield f"{name} has NaN or infinity"


def _header(arrays: State) -> Header:
    if "header" not in arrays:
        raise ValueError("it has no header")
    try:
        return HEADER.validate_json(str(arrays["header"]))
    except ValidationError as error:
        found = "; ".join(
            f"{'.'.join(map(str, each['loc']))}: {each['msg']}" for each in error.errors()
        )
        raise ValueError(f"its header is not as expected: {found}") from error
