"""A policy's file: the same policy after reading, and a sentence for what is none."""

import io
import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import algorithms
from algorithms.acting.policy import TrainedPolicy
from algorithms.acting.policy_file import policy_bytes
from tests.algorithms.acting.trained import learner_of, policy_by

Arrays = dict[str, Any]


@pytest.fixture(scope="module")
def policy() -> TrainedPolicy:
    return policy_by(learner_of("ddpg", "Pendulum"), "Pendulum", algorithm="ddpg", seed=0)


def test_what_is_read_is_what_was_saved(policy: TrainedPolicy, tmp_path: Path) -> None:
    path = tmp_path / "policy.npz"
    algorithms.save_policy(policy, path)
    again = algorithms.load_policy(path)
    observations = np.random.default_rng(0).normal(size=(50, 3))
    np.testing.assert_array_equal(again.act(observations), policy.act(observations))
    assert again.header == policy.header
    assert policy_bytes(again) == policy_bytes(policy) == path.read_bytes()
    assert algorithms.load_policy(path.read_bytes()).header == policy.header


def test_numpy_alone_reads_it(policy: TrainedPolicy) -> None:
    """As docs/policies.md describes it."""
    with np.load(io.BytesIO(policy_bytes(policy)), allow_pickle=False) as file:
        header = json.loads(str(file["header"]))
        h = np.clip((np.zeros(3) - file["mean"]) * file["inverse_std"], -5, 5)
        for k in range(len(header["hidden_units"])):
            weight, bias, gain, shift = (
                file[f"hidden/{k}/{name}"] for name in ("weight", "bias", "gain", "shift")
            )
            z = h @ weight + bias
            n = (z - z.mean()) / np.sqrt(z.var() + header["epsilon"])
            h = np.tanh(gain * n + shift)
        action = np.tanh(h @ file["output/weight"] + file["output/bias"])
    np.testing.assert_allclose(action, policy.act(np.zeros(3)), rtol=0, atol=1e-6)


def test_its_name_says_what_it_is(policy: TrainedPolicy, tmp_path: Path) -> None:
    with pytest.raises(ValueError, match=r"policy.pt must end in .npz"):
        algorithms.save_policy(policy, tmp_path / "policy.pt")


def without(name: str) -> Callable[[Arrays], None]:
    return lambda arrays: arrays.pop(name)


def with_header(**changes: Any) -> Callable[[Arrays], None]:
    def change(arrays: Arrays) -> None:
        arrays["header"] = np.array(json.dumps({**json.loads(str(arrays["header"])), **changes}))

    return change


@pytest.mark.parametrize(
    ("change", "reason"),
    [
        (without("header"), "it has no header"),
        (without("mean"), "the array 'mean' is missing"),
        (without("hidden/1/gain"), "the array 'hidden/1/gain' is missing"),
        (lambda a: a.update(mean=np.zeros(2, np.float32)), r"float32 \[3\], not float32 \[2\]"),
        (lambda a: a.update(mean=np.zeros(3)), r"mean must be float32 \[3\], not float64 \[3\]"),
        (lambda a: a.update(mean=np.full(3, np.nan, np.float32)), "mean has NaN or infinity"),
        (lambda a: a.update(more=np.zeros(1)), "the array 'more' is unknown"),
        (with_header(format=2), "format: Input should be 1"),
        (with_header(activation="sine"), "activation: Input should be 'tanh'"),
        (with_header(action_size=4), r"output/weight must be float32 \[64, 4\]"),
    ],
)
def test_what_is_wrong_is_said(
    policy: TrainedPolicy, tmp_path: Path, change: Callable[[Arrays], None], reason: str
) -> None:
    with np.load(io.BytesIO(policy_bytes(policy))) as file:
        arrays = {name: file[name] for name in file.files}
    change(arrays)
    path = tmp_path / "changed.npz"
    np.savez(path, **arrays)
    with pytest.raises(ValueError, match=rf"changed.npz is not a policy: .*{reason}"):
        algorithms.load_policy(path)


def test_what_is_no_archive_or_pickled_is_refused(policy: TrainedPolicy, tmp_path: Path) -> None:
    with pytest.raises(ValueError, match="it is not a complete NumPy archive"):
        algorithms.load_policy(policy_bytes(policy)[:-40])
    with pytest.raises(ValueError, match="it is not a complete NumPy archive"):
        algorithms.load_policy(b"")
    path = tmp_path / "pickled.npz"
    np.savez(path, header=np.array({"a": 1}, object))
    with pytest.raises(ValueError, match="it is not a complete NumPy archive"):
        algorithms.load_policy(path)
    with pytest.raises(FileNotFoundError):
        algorithms.load_policy(tmp_path / "nowhere.npz")
