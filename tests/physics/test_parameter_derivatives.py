"""Derivatives in physical parameters, and the tasks that other values make."""

import numpy as np
import pytest
import torch

import physics
from physics.autograd import torch_step
from physics.environment import Environment
from physics.parameter import Parameter, declared, number_text
from physics.parameter_differences import by_differences
from physics.randomness import generator
from tests.docs.pages import ROOT
from tests.physics.small_tasks import Plain

TASKS = [name for name in physics.names() if declared(type(physics.make(name)))]
EXACT = [name for name in TASKS if physics.make(name).parameter_kernel is not None]
every_task = pytest.mark.parametrize("name", TASKS)
every_exact_task = pytest.mark.parametrize("name", EXACT)


class Spring(Plain):
    """A torch task with a parameter in its dynamics and one in its reward."""

    name = "Spring"
    stiffness = Parameter(1.0, "N/m", least=0.0, greatest=10.0)
    price = Parameter(0.5, "1", least=0.0, greatest=2.0)

    def dynamics(self, state: torch.Tensor, action: torch.Tensor) -> torch.Tensor:
        push = action[0] - self.stiffness * torch.sin(state[0])
        return torch.stack([state[0] + 0.1 * state[1], state[1] + 0.1 * push])

    def reward(
        self, state: torch.Tensor, action: torch.Tensor, next_state: torch.Tensor
    ) -> torch.Tensor:
        cost: torch.Tensor = self.price * action[0] ** 2
        return -(next_state**2).sum() - cost


def inner(task: Environment, count: int = 64) -> tuple[torch.Tensor, torch.Tensor]:
    """Steps of the task's first regime, whose differences stay on their smooth piece."""
    states, actions = task.sample(generator(0, "parameters"), 50 * count)
    rows = np.flatnonzero(task.pieces(states, actions).regime == 0)[:count]
    return torch.from_numpy(states[rows]), torch.from_numpy(actions[rows])


def moved(task: Environment) -> Environment:
    """The task a little away from its defaults, where BallWall's number of substeps changes."""
    return task.with_parameters(**{name: 1.01 * value for name, value in task.parameters.items()})


def values_of(task: Environment) -> list[torch.Tensor]:
    """Values a little away from the defaults."""
    values = [1.01 * value for value in task.parameters.values()]
    return [torch.tensor(value, dtype=torch.float64, requires_grad=True) for value in values]


@pytest.mark.parametrize("name", [*TASKS, "Spring"])
def test_gradients_in_parameters_states_and_actions_are_those_of_differences(name: str) -> None:
    task = Spring() if name == "Spring" else physics.make(name)
    is_quick = name in ("Spring", *EXACT)
    states, actions = inner(task, 8 if is_quick else 2)

    def step(
        states: torch.Tensor, actions: torch.Tensor, *values: torch.Tensor
    ) -> tuple[torch.Tensor, ...]:
        given = dict(zip(task.parameters, values, strict=True))
        found = torch_step(task, states, actions, given)
        return found[:2] if task.reward_is_differentiable else found[:1]

    rows = states.requires_grad_(), actions.requires_grad_()
    inputs = (*rows, *values_of(task))
    assert torch.autograd.gradcheck(step, inputs, rtol=1e-5, atol=1e-6, fast_mode=not is_quick)


@every_exact_task
def test_every_row_has_the_derivatives_of_differences(name: str) -> None:
    task = moved(physics.make(name))
    states, actions = (each.numpy() for each in inner(task))
    found = task.differentiate_parameters(states, actions)
    for j, (parameter, value) in enumerate(task.parameters.items()):
        width = 1e-6 * abs(value)
        up, down = (
            task.with_parameters(**{parameter: value + sign * width}).step(states, actions)
            for sign in (1, -1)
        )
        slope = (up.next_state - down.next_state) / (2 * width)
        np.testing.assert_allclose(found.next_state[..., j], slope, rtol=1e-6, atol=1e-7)
        held = task.differentiate(states, actions).reward_next_state_gradient
        through = np.einsum("bi,bi->b", held, found.next_state[..., j])
        slope = (up.reward - down.reward) / (2 * width)
        np.testing.assert_allclose(found.reward[:, j] + through, slope, rtol=1e-6, atol=1e-7)


@every_exact_task
def test_differences_tell_what_is_exact_of_every_smooth_piece_but_kinks(name: str) -> None:
    task = moved(physics.make(name))
    states, actions = task.sample(generator(0, "parameters"), 200)
    exact, found = (
        task.differentiate_parameters(states, actions),
        by_differences(task, states, actions)[0],
    )
    scale = 1.0 + np.abs(exact.next_state).max(axis=(1, 2), keepdims=True)
    errors = (np.abs(found - exact.next_state) / scale).max(axis=(1, 2))
    assert np.quantile(errors, 0.95) < 1e-8


def test_differences_stay_within_the_range_of_a_parameter() -> None:
    for gravity in (0.0, 100.0):
        task = physics.make("Pendulum", gravity=gravity)
        states, actions = (each.numpy() for each in inner(task, 8))
        found, _ = by_differences(task, states, actions)
        exact = task.differentiate_parameters(states, actions).next_state
        np.testing.assert_allclose(found, exact, rtol=1e-8, atol=1e-8)


@every_task
def test_defaults_that_are_given_change_no_bit(name: str) -> None:
    task = physics.make(name)
    states, actions = task.sample(generator(0, "parameters"), 200)
    one = task.differentiate(states, actions)
    other = task.with_parameters(**task.parameters).differentiate(states, actions)
    for a, b in zip([*one.transition, *one[1:]], [*other.transition, *other[1:]], strict=True):
        np.testing.assert_array_equal(a, b)


@every_task
def test_each_parameter_changes_the_task_and_its_jacobians_are_still_right(name: str) -> None:
    task = physics.make(name)
    everywhere = task.sample(generator(0, "parameters"), 1000)
    before = task.step(*everywhere)
    states, actions = (each.numpy() for each in inner(task, 32))
    for parameter, value in task.parameters.items():
        other = task.with_parameters(**{parameter: 1.3 * value})
        after = other.step(*everywhere)
        changed = not np.array_equal(before.next_state, after.next_state)
        assert changed or not np.array_equal(before.reward, after.reward), parameter
        _hold_against_differences(other, states, actions)


def _hold_against_differences(task: Environment, states: np.ndarray, actions: np.ndarray) -> None:
    found, width = task.differentiate(states, actions), 1e-6
    for j in range(task.state_size):
        ahead, behind = states.copy(), states.copy()
        ahead[:, j] += width
        behind[:, j] -= width
        same = (task.pieces(ahead, actions).piece == task.pieces(behind, actions).piece).all(axis=1)
        up, down = task.step(ahead, actions), task.step(behind, actions)
        slope = (up.next_state - down.next_state) / (2 * width)
        np.testing.assert_allclose(
            found.state_jacobian[same, :, j], slope[same], rtol=1e-5, atol=1e-6
        )


def test_the_page_lists_every_parameter() -> None:
    rows = [
        f"| {each.name} | {name} | {each.unit} | {number_text(each.default)} | "
        f"{number_text(each.least)} to {number_text(each.greatest)} | {each.meaning} |"
        for name in TASKS
        for each in declared(type(physics.make(name))).values()
    ]
    shown = (ROOT / "docs" / "simulators.md").read_text().splitlines()
    header = shown.index("| parameter | task | unit | default | range | meaning |")
    assert shown[header + 2 : header + 3 + len(rows)] == [*rows, ""]


def test_a_task_without_them_says_so() -> None:
    task = Plain()
    with pytest.raises(ValueError, match="there is no parameter 'mass' \\(known: none\\)"):
        torch_step(task, torch.zeros(1, 2), torch.zeros(1, 1), {"mass": torch.tensor(1.0)})


def test_values_are_checked() -> None:
    task = physics.make("Pendulum")
    rows = torch.zeros(1, 2), torch.zeros(1, 1)
    for value, message in (
        (torch.tensor(-1.0), "gravity must be a number from 0 to 100 m/s"),
        (torch.ones(1), r"gravity must be a tensor \[\], not \[1\]"),
        (torch.tensor(1), "gravity must be a floating-point tensor on the CPU"),
    ):
        with pytest.raises(ValueError, match=message):
            torch_step(task, *rows, {"gravity": value})


def test_a_length_is_found_by_gradient_descent() -> None:
    """System identification: the gradient of a one-step error leads to the true value."""
    task = physics.make("Pendulum", length=0.7)
    states, actions = inner(task)
    truth = torch_step(task, states, actions).next_state
    log_length = torch.zeros((), dtype=torch.float64, requires_grad=True)
    optimizer = torch.optim.LBFGS([log_length], max_iter=50, line_search_fn="strong_wolfe")

    def error() -> torch.Tensor:
        optimizer.zero_grad()
        found = torch_step(task, states, actions, {"length": log_length.exp()}).next_state
        loss = ((found - truth) ** 2).sum()
        loss.backward()  # type: ignore[no-untyped-call]
        return loss

    optimizer.step(error)  # type: ignore[no-untyped-call]
    assert abs(float(log_length.detach().exp()) - 0.7) < 1e-6
