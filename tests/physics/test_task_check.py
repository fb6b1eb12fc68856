"""A task that cannot work is refused as it is made, with everything that is wrong with it."""

from types import MappingProxyType
from typing import Any

import numpy as np
import pytest
import torch

from physics.drawing import Drawing, disc
from physics.environment import FloatArray
from tests.algorithms.probes import Bandit
from tests.physics.small_tasks import Plain


def refusal(task: type, **attributes: Any) -> str:
    """Why a task is refused, with some of its attributes replaced."""
    with pytest.raises(ValueError, match="Wrong is not a valid task:\n- ") as caught:
        type("Wrong", (task,), attributes)()
    return str(caught.value)


@pytest.mark.parametrize("task", [Plain, Bandit])
@pytest.mark.parametrize(
    ("name", "value", "complaint"),
    [
        ("name", "", "name must be a word of letters, digits, '_', '-' and '.', not ''"),
        ("name", "My task", "not 'My task'"),
        ("name", None, "name must be a word"),
        ("version", 0, "version must be an integer from 1 on, not 0"),
        ("version", "1", "version must be an integer from 1 on, not '1'"),
        ("state_size", 0, "state_size must be an integer from 1 on, not 0"),
        ("action_size", 1.0, "action_size must be an integer from 1 on, not 1.0"),
        ("action_size", True, "action_size must be an integer from 1 on, not True"),
        ("horizon", -5, "horizon must be an integer from 1 on, not -5"),
        ("max_reward", float("nan"), "max_reward must be a finite number, not nan"),
        ("max_reward", float("inf"), "max_reward must be a finite number, not inf"),
        ("max_reward", None, "max_reward must be a finite number, not None"),
        ("step_seconds", 0.0, "step_seconds must be a number above 0, not 0.0"),
        ("step_seconds", "fast", "step_seconds must be a number above 0, not 'fast'"),
        ("rounding", 0.0, "rounding must be a number above 0, at most 4e-13, not 0.0"),
        ("rounding", 1e-9, "rounding must be a number above 0, at most 4e-13, not 1e-09"),
        ("reward_is_differentiable", 1, "reward_is_differentiable must be True or False, not 1"),
        ("angles", {7: 1}, "angles names coordinate 7; a state has the coordinates 0 to"),
        ("angles", {-1: 1}, "angles names coordinate -1"),
        ("angles", {0: 0}, "angles[0] must be an integer from 1 on, not 0"),
        ("angles", (0,), "angles must be a mapping of coordinates, not (0,)"),
        ("hidden", (9,), "hidden names coordinate 9"),
        ("hidden", 0, "hidden must be a tuple of coordinates, not 0"),
        ("hidden", (0, 1), "hidden names every coordinate"),
        ("bounds", {0: (1.0, -1.0)}, "bounds[0] must be (least, greatest), two numbers"),
        ("bounds", {5: (0.0, 1.0)}, "bounds names coordinate 5"),
        ("regimes", (), "regimes must be a tuple of different names, at least one, not ()"),
        ("regimes", ("free", "free"), "regimes must be a tuple of different names"),
        ("step_kernel", None, "step_kernel must be a function, not None"),
    ],
)
def test_impossible_constants(task: type, name: str, value: Any, complaint: str) -> None:
    assert complaint in refusal(task, **{name: value})


def test_missing_constants_are_told_together() -> None:
    class Empty(Plain):
        pass

    bare = {name: each for name, each in vars(Plain).items() if callable(each)}
    told = refusal(Plain.__base__ or object, **bare)
    for name in ("name", "version", "state_size", "action_size", "horizon", "max_reward"):
        assert f"\n- {name} is missing: it must be" in told


def test_an_angle_cannot_be_hidden() -> None:
    told = refusal(Plain, angles=MappingProxyType({1: 1}), hidden=(1,))
    assert "coordinate 1 is both an angle and hidden" in told


@pytest.mark.parametrize(
    ("attributes", "complaint"),
    [
        (
            {"dynamics": lambda self, s, a: torch.stack([s[0] + 0.1 * a[0]])},
            "dynamics must return a tensor [2] of torch.float64, not [1] of torch.float64",
        ),
        (
            {"dynamics": lambda self, s, a: (s + a).float()},
            "dynamics must return a tensor [2] of torch.float64, not [2] of torch.float32",
        ),
        (
            {"dynamics": lambda self, s, a: [s[0], s[1]]},
            "dynamics must return a tensor [2] of torch.float64, not list",
        ),
        (
            {"dynamics": lambda self, s, a: np.sin(s.numpy())},
            "dynamics must return a tensor [2] of torch.float64, not a numpy array [2] of float64",
        ),
        (
            {"dynamics": lambda self, s, a: torch.from_numpy(np.sin(s.numpy()))},
            "dynamics cannot be batched and differentiated by torch.func: use torch's functions",
        ),
        (
            {"dynamics": lambda self, s, a: s if s[0] > 0 else s + a},
            "dynamics cannot be batched and differentiated by torch.func",
        ),
        (
            {"dynamics": lambda self, s, a: s * float(a[0])},
            "dynamics cannot be batched and differentiated by torch.func",
        ),
        (
            {"dynamics": lambda self, s, a: s.reshape(3)},
            "dynamics raised RuntimeError: shape '[3]' is invalid",
        ),
        (
            {
                "dynamics": lambda self, s, a: torch.linalg.lu_solve(
                    *torch.linalg.lu_factor(torch.diag(2 + torch.cos(s)) + 0.5 * s.outer(s)),
                    s[:, None],
                )[:, 0]
            },
            "dynamics gives other numbers or derivatives under torch.func.vmap than row by row",
        ),
        (
            {"reward": lambda self, s, a, n: -1.0},
            "reward must return a tensor [] of torch.float64, not float -1.0; a constant is written"
            " torch.full_like(state[0], -1.0)",
        ),
        (
            {"reward": lambda self, s, a, n: torch.tensor(-1.0)},
            "reward must return a tensor [] of torch.float64, not [] of torch.float32",
        ),
        (
            {"reward": lambda self, s, a, n: -(n[:1] ** 2)},
            "reward must return a tensor [] of torch.float64, not [1] of torch.float64",
        ),
        (
            {"terminated": lambda self, n: False},
            "terminated must return a tensor [] of torch.bool, not bool False; a constant is "
            "written torch.zeros_like(next_state[0], dtype=torch.bool)",
        ),
        (
            {"terminated": lambda self, n: n[0]},
            "terminated must return a tensor [] of torch.bool, not [] of torch.float64",
        ),
        (
            {"terminated": lambda self, n: bool(n[0] > 1.0)},
            "terminated must return a tensor [] of torch.bool, not bool",
        ),
        (
            {"initial_state": lambda self, g: np.zeros(3)},
            "Plain: an initial state must be float64 [2], not float64 [3]",
        ),
        (
            {"initial_state": lambda self, g: np.zeros(2, np.float32)},
            "Plain: an initial state must be float64 [2], not float32 [2]",
        ),
        (
            {"initial_state": lambda self, g: [0.0, 0.0]},
            "Plain: an initial state must be a numpy array, float64 [2], not list",
        ),
        (
            {"initial_state": lambda self, g: np.array([0.0, np.nan])},
            "states and actions must be finite, but row 0 has state [0.0, nan]",
        ),
        (
            {"bounds": {0: (2.0, 3.0)}},
            "Plain: row 0 lies outside the domain, 2 <= s[0] <= 3",
        ),
        (
            {"initial_state": lambda self, g: g.nothing()},
            "initial_state raised AttributeError",
        ),
    ],
)
def test_functions_of_torch_tasks(attributes: dict[str, Any], complaint: str) -> None:
    assert complaint in refusal(Plain, **attributes)


def test_all_mistakes_are_told_at_once() -> None:
    told = refusal(
        Plain,
        horizon=0,
        hidden=(4,),
        dynamics=lambda self, s, a: s[:1],
        reward=lambda self, s, a, n: 0.0,
        terminated=lambda self, n: True,
        initial_state=lambda self, g: np.zeros(1),
    )
    assert told.count("\n- ") == 6


@pytest.mark.parametrize(
    "reward",
    [
        lambda self, s, a, n: torch.full_like(s[0], -1.0),
        lambda self, s, a, n: torch.tensor(-1.0, dtype=torch.float64),
    ],
)
def test_a_constant_reward_has_no_gradient(reward: Any) -> None:
    task = type("Constant", (Plain,), {"reward": reward})()
    found = task.differentiate(np.ones((2, 2)), np.zeros((2, 1)))
    assert found.transition.reward.tolist() == [-1.0, -1.0]
    assert not any(gradient.any() for gradient in found[3:])


def test_a_task_may_prepare_itself_after_the_base_class() -> None:
    class Heavy(Plain):
        def __init__(self, mass: float) -> None:
            super().__init__()
            self.mass = mass

        def dynamics(self, state: torch.Tensor, action: torch.Tensor) -> torch.Tensor:
            return state + action / self.mass

    states: FloatArray = np.zeros((1, 2))
    assert Heavy(4.0).step(states, np.ones((1, 1))).next_state.tolist() == [[0.25, 0.25]]


def test_a_task_whose_steps_may_leave_the_numbers_is_one() -> None:
    type("Logarithm", (Plain,), {"dynamics": lambda self, s, a: torch.log(s)})()


def test_start_states_of_compiled_tasks_are_checked_as_they_are_drawn() -> None:
    class Short(Bandit):
        def initial_state(self, generator: np.random.Generator) -> FloatArray:
            return generator.uniform(size=2)

    with pytest.raises(ValueError, match=r"an initial state must be float64 \[1\], not float64"):
        Short().initial_states([0])


class Undrawn(Plain):
    """Draws nothing, or not what it must."""

    name = "Undrawn"

    def draw(self, state: FloatArray) -> Drawing:
        raise NotImplementedError("nothing to see")


def test_a_drawing_is_tried_when_a_task_is_made() -> None:
    class Broken(Plain):
        def draw(self, state: FloatArray) -> Drawing:
            return Drawing((0.0, 0.0, 1.0, 1.0), (disc((float(state[2]), 0.0), 0.1, "body"),))

    class Picture(Plain):
        def draw(self, state: FloatArray) -> Drawing:
            return "a picture"  # type: ignore[return-value]

    with pytest.raises(ValueError, match="- draw raised IndexError: index 2 is out of bounds"):
        Broken()
    with pytest.raises(
        ValueError, match=r"- draw must return a physics\.drawing\.Drawing, not 'a p"
    ):
        Picture()
    assert Undrawn().name == "Undrawn"
