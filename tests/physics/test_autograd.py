"""torch_step: gradients of a whole episode, transforms, compilation, and what it refuses."""

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
import torch
from torch.func import grad, jacfwd, jacrev, jvp, vmap

import physics
from physics.environment import Environment, NoisyEnvironment, NotFiniteError
from tests.physics.small_tasks import LogOfNegative
from tests.physics.test_torch_environment import MODES, WithLinearAlgebra

# torch's own, of forward mode and of the compiler.
pytestmark = [
    pytest.mark.filterwarnings("ignore:.torch.jit:DeprecationWarning"),
    pytest.mark.filterwarnings("ignore:There is a performance drop:UserWarning"),
    pytest.mark.filterwarnings("ignore:The .grad attribute of a Tensor:UserWarning"),
]


def episode_return(
    environment: Environment, start: torch.Tensor, plan: torch.Tensor
) -> torch.Tensor:
    state, total = start, torch.zeros(len(start), dtype=torch.float64)
    for action in plan.unbind(1):
        transition = physics.torch_step(environment, state, action)
        state, total = transition.next_state, total + transition.reward
    return total


@pytest.fixture(params=["Pendulum", "WithLinearAlgebra"])
def task(request: pytest.FixtureRequest) -> Environment:
    """One compiled, one of torch functions."""
    return physics.make("Pendulum") if request.param == "Pendulum" else WithLinearAlgebra()


@pytest.fixture(params=["Pendulum", "WithLinearAlgebra", "MountainCar"])
def noisy(request: pytest.FixtureRequest) -> NoisyEnvironment:
    """The same with noise, and one whose noise meets its bounds."""
    given = {"process_noise": 0.2, "observation_noise": 0.1}
    own = WithLinearAlgebra() if request.param == "WithLinearAlgebra" else None
    task = (own or physics.make(request.param)).with_parameters(**given)
    assert isinstance(task, NoisyEnvironment)
    return task


@pytest.fixture
def states() -> torch.Tensor:
    return torch.tensor([[0.3, 0.2], [0.5, -0.4], [-0.9, 0.1]], dtype=torch.float64)


@pytest.fixture
def actions() -> torch.Tensor:
    return torch.tensor([[0.3], [-0.6], [0.1]], dtype=torch.float64)


def score(task: Environment) -> Callable[[torch.Tensor, torch.Tensor], torch.Tensor]:
    """A number that depends on all of one row's step."""

    def of_row(state: torch.Tensor, action: torch.Tensor) -> torch.Tensor:
        transition = physics.torch_step(task, state[None], action[None])
        return transition.next_state.pow(2).sum() + transition.reward.sum()

    return of_row


def plain_score(state: torch.Tensor, action: torch.Tensor) -> torch.Tensor:
    """The same of WithLinearAlgebra, by torch alone."""
    task = WithLinearAlgebra()
    following = task.dynamics(state, action)
    return following.pow(2).sum() + task.reward(state, action, following)


@pytest.mark.parametrize(
    "name", ["MassPoint", "CartPole", "CartPoleSwingUp", "Pendulum", "MountainCar"]
)
def test_gradient_of_an_episode(name: str) -> None:
    environment = physics.make(name)
    start = torch.from_numpy(environment.initial_states([1, 2])).requires_grad_()
    random = torch.Generator().manual_seed(0)
    plan = torch.rand((2, 10, 1), generator=random, dtype=torch.float64) - 0.5
    plan.requires_grad_()
    assert torch.autograd.gradcheck(
        lambda s, p: episode_return(environment, s, p), (start, plan), atol=1e-6
    )


def test_state_gradient_alone() -> None:
    environment = physics.make("Pendulum")
    state = torch.tensor([[0.1, 0.2]], dtype=torch.float64, requires_grad=True)
    action = torch.tensor([[0.3]], dtype=torch.float64)
    omega = physics.torch_step(environment, state, action).next_state[0, 1]
    (gradient,) = torch.autograd.grad(omega, state)
    exact = environment.differentiate(state.detach().numpy(), action.numpy())
    np.testing.assert_array_equal(gradient[0].numpy(), exact.state_jacobian[0, 1])


def test_forward_and_batched_gradients(
    task: Environment, states: torch.Tensor, actions: torch.Tensor
) -> None:
    assert torch.autograd.gradcheck(
        lambda s, a: physics.torch_step(task, s, a)[:2],
        (states.requires_grad_(), actions.requires_grad_()),
        check_forward_ad=True,
        check_batched_grad=True,
        check_batched_forward_grad=True,
    )


@pytest.mark.parametrize("mode", MODES)
def test_jacobians_by_transforms(
    task: Environment, states: torch.Tensor, actions: torch.Tensor, mode: Callable[[], Any]
) -> None:
    exact = task.differentiate(states.numpy(), actions.numpy())

    def following(state: torch.Tensor, action: torch.Tensor) -> torch.Tensor:
        return physics.torch_step(task, state[None], action[None]).next_state[0]

    with mode():
        for transform in (jacrev, jacfwd):
            by_state, by_action = vmap(transform(following, argnums=(0, 1)))(states, actions)
            np.testing.assert_allclose(by_state.numpy(), exact.state_jacobian, rtol=1e-15)
            np.testing.assert_allclose(by_action.numpy(), exact.action_jacobian, rtol=1e-15)
        gradient = grad(lambda a: physics.torch_step(task, states, a).reward.sum())(actions)
    reward = exact.reward_action_gradient
    reward = reward + (exact.reward_next_state_gradient[:, None] @ exact.action_jacobian)[:, 0]
    np.testing.assert_allclose(gradient.numpy(), reward, rtol=1e-14)


def test_vmap_over_any_dimension(
    task: Environment, states: torch.Tensor, actions: torch.Tensor
) -> None:
    plans = torch.stack([actions, actions / 2], dim=1)  # [3, 2, 1]
    found = vmap(lambda a: physics.torch_step(task, states, a), in_dims=1)(plans)
    for plan in range(2):
        expected = physics.torch_step(task, states, plans[:, plan])
        for one, other in zip(found, expected, strict=True):
            torch.testing.assert_close(one[plan], other, rtol=0.0, atol=0.0)


def test_second_derivatives_of_torch_tasks(states: torch.Tensor, actions: torch.Tensor) -> None:
    assert torch.autograd.gradgradcheck(
        lambda s, a: physics.torch_step(WithLinearAlgebra(), s, a)[:2],
        (states[:1].requires_grad_(), actions[:1].requires_grad_()),
    )


@pytest.mark.parametrize("mode", MODES[:2])
def test_second_derivatives_in_every_order(
    states: torch.Tensor, actions: torch.Tensor, mode: Callable[[], Any]
) -> None:
    ours = score(WithLinearAlgebra())
    # Row by row and in reverse: of these, vmap and jacfwd of torch alone are wrong by thousands.
    rows = list(zip(states, actions, strict=True))
    expected = torch.stack([jacrev(jacrev(plain_score))(s, a) for s, a in rows])
    with mode():
        for outer in (jacrev, jacfwd):
            for inner in (jacrev, jacfwd):
                found = vmap(outer(inner(ours)))(states, actions)
                torch.testing.assert_close(found, expected, rtol=1e-13, atol=1e-13)


@pytest.mark.parametrize("outer", [jacrev, jacfwd])
@pytest.mark.parametrize("inner", [jacrev, jacfwd])
def test_compiled_tasks_have_no_second_derivative_and_say_so(
    states: torch.Tensor, actions: torch.Tensor, outer: Any, inner: Any
) -> None:
    with pytest.raises(RuntimeError, match="Pendulum has no second derivative"):
        outer(inner(score(physics.make("Pendulum"))))(states[0], actions[0])


def test_a_second_derivative_is_refused() -> None:
    environment = physics.make("Pendulum")
    state = torch.zeros((1, 2), dtype=torch.float64, requires_grad=True)
    action = torch.zeros((1, 1), dtype=torch.float64, requires_grad=True)
    reward = physics.torch_step(environment, state, action).reward
    (gradient,) = torch.autograd.grad(reward.sum(), action, create_graph=True)
    with pytest.raises(RuntimeError, match="no second derivative: its Jacobians are compiled"):
        torch.autograd.grad(gradient.sum(), action)


@pytest.mark.parametrize("backend", ["eager", "aot_eager"])
def test_compiled_functions_may_call_it(
    task: Environment, states: torch.Tensor, actions: torch.Tensor, backend: str
) -> None:
    def loss(s: torch.Tensor, a: torch.Tensor) -> torch.Tensor:
        transition = physics.torch_step(task, s, a.tanh())
        return (transition.next_state * 2.0).sin().sum() + transition.reward.sum()

    torch.compiler.reset()
    gradients = []
    for function in (loss, torch.compile(loss, backend=backend)):
        plan = actions.clone().requires_grad_()
        torch.autograd.backward(function(states, plan))
        gradients.append(plan.grad)
    torch.testing.assert_close(gradients[0], gradients[1], rtol=1e-13, atol=1e-13)


@pytest.mark.parametrize("dtype", [torch.float16, torch.bfloat16, torch.float32])
def test_narrower_tensors_are_cast(
    task: Environment, states: torch.Tensor, actions: torch.Tensor, dtype: torch.dtype
) -> None:
    s, a = states.to(dtype).requires_grad_(), actions.to(dtype).requires_grad_()
    found = physics.torch_step(task, s, a)
    expected = physics.torch_step(task, s.detach().double(), a.detach().double())
    torch.testing.assert_close(found.next_state, expected.next_state.to(dtype), rtol=0, atol=0)
    torch.testing.assert_close(found.reward, expected.reward.to(dtype), rtol=0, atol=0)
    torch.autograd.backward(found.next_state.sum())
    assert s.grad is not None
    assert a.grad is not None
    assert s.grad.dtype == a.grad.dtype == dtype
    exact = task.differentiate(s.detach().double().numpy(), a.detach().double().numpy())
    by_action = torch.from_numpy(exact.action_jacobian.sum(axis=1)).to(dtype)
    torch.testing.assert_close(a.grad, by_action)


def test_mixed_tensors_step_in_the_states_dtype(
    task: Environment, states: torch.Tensor, actions: torch.Tensor
) -> None:
    assert physics.torch_step(task, states, actions.float()).next_state.dtype == torch.float64
    assert physics.torch_step(task, states.float(), actions).next_state.dtype == torch.float32


def test_a_reward_that_is_not_differentiable_says_so() -> None:
    environment = physics.make("Acrobot")
    state = torch.zeros((1, 4), dtype=torch.float64, requires_grad=True)
    action = torch.zeros((1, 1), dtype=torch.float64)
    transition = physics.torch_step(environment, state, action)
    assert transition.next_state.requires_grad
    assert not transition.reward.requires_grad
    tangent = jvp(
        lambda s: physics.torch_step(environment, s, action).reward, (state,), (state + 1.0,)
    )[1]
    assert tangent.tolist() == [0.0]


def test_other_types_are_refused() -> None:
    environment = physics.make("Pendulum")
    state, action = torch.zeros((1, 2), dtype=torch.float64), torch.zeros((1, 1), dtype=torch.int64)
    with pytest.raises(
        ValueError, match=r"actions must be a floating-point tensor .* torch\.int64"
    ):
        physics.torch_step(environment, state, action)
    with pytest.raises(ValueError, match=r"states must be a floating-point tensor .* on meta"):
        physics.torch_step(environment, state.to("meta"), action.double())


def test_a_step_that_leaves_the_numbers_is_refused_by_row() -> None:
    states = torch.tensor([[1.0, 0.0], [-1.0, 0.0]])
    with pytest.raises(NotFiniteError) as caught:
        physics.torch_step(LogOfNegative(), states, torch.zeros((2, 1)))
    assert caught.value.rows == (1,)


def test_with_noise_a_step_and_its_derivatives_are_those_of_the_simulator(
    noisy: NoisyEnvironment, actions: torch.Tensor
) -> None:
    states = torch.from_numpy(noisy.initial_states(range(3)))
    found = noisy.differentiate(states.numpy(), actions.numpy())
    step = physics.torch_step(noisy, states, actions)
    for one, other in zip(step, found.transition, strict=True):
        np.testing.assert_array_equal(one.numpy(), other)

    def following(state: torch.Tensor, action: torch.Tensor) -> torch.Tensor:
        return physics.torch_step(noisy, state[None], action[None]).next_state[0]

    for jacobian in (jacrev, jacfwd):
        by_state, by_action = vmap(jacobian(following, argnums=(0, 1)))(states, actions)
        np.testing.assert_allclose(by_state, found.state_jacobian, rtol=1e-12, atol=1e-12)
        np.testing.assert_allclose(by_action, found.action_jacobian, rtol=1e-12, atol=1e-12)


def test_the_deviation_of_process_noise_has_a_gradient(
    noisy: NoisyEnvironment, actions: torch.Tensor
) -> None:
    places = torch.from_numpy(noisy.initial_states(range(3)))
    own, n = places[:, : noisy.task.state_size].clone().requires_grad_(), noisy.task.state_size

    def step(
        own: torch.Tensor, actions: torch.Tensor, deviation: torch.Tensor
    ) -> tuple[torch.Tensor, torch.Tensor]:
        states = torch.cat([own, places[:, n:]], dim=1)
        return physics.torch_step(noisy, states, actions, {"process_noise": deviation})[:2]

    deviation = torch.tensor(0.03, dtype=torch.float64, requires_grad=True)
    rows = own, actions.requires_grad_(), deviation
    assert torch.autograd.gradcheck(step, rows, rtol=1e-5, atol=1e-6)


def test_no_noise_given_as_a_tensor_is_the_task_without() -> None:
    task, rows = physics.make("Pendulum"), (torch.zeros(1, 2), torch.zeros(1, 1))
    given = {"process_noise": torch.tensor(0.0), "mass": torch.tensor(1.0)}
    assert torch.equal(
        physics.torch_step(task, *rows, given).next_state,
        physics.torch_step(task, *rows).next_state,
    )


def test_a_deviation_may_come_to_0() -> None:
    task = physics.make("Pendulum", process_noise=0.1)
    states = torch.from_numpy(task.initial_states(range(3)))
    deviation = torch.zeros((), dtype=torch.float64, requires_grad=True)
    given, actions = {"process_noise": deviation}, torch.zeros(3, 1, dtype=torch.float64)
    found = physics.torch_step(task, states, actions, given).next_state
    exact = physics.make("Pendulum").step(states[:, :2].numpy().copy(), actions.numpy())
    np.testing.assert_array_equal(found.detach()[:, :2].numpy(), exact.next_state)
    found.sum().backward()  # type: ignore[no-untyped-call]
    assert deviation.grad is not None
    assert float(deviation.grad) != 0.0


def test_a_torch_task_with_noise_has_second_derivatives(actions: torch.Tensor) -> None:
    task = WithLinearAlgebra().with_parameters(process_noise=0.1)
    states = torch.from_numpy(task.initial_states(range(3)))

    def score_of(action: torch.Tensor) -> torch.Tensor:
        return physics.torch_step(task, states[:1], action[None]).next_state.pow(2).sum()

    assert torch.func.hessian(score_of)(actions[0]).shape == (1, 1)
    assert torch.autograd.gradgradcheck(score_of, actions[0].clone().requires_grad_())
