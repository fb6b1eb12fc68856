"""Episodes as `GET /runs/{id}/rollout` answers them, acted by a wave and not by a policy."""

from typing import Any

import numpy as np
from playwright.sync_api import Page, Route

import physics
from physics.film import film
from workers.policies.critic_surface import best_values


def episode(environment: str, steps: int = 120) -> dict[str, Any]:
    """An episode from the start state of seed 1."""
    task = physics.make(environment)
    states = [task.initial_states([1])]
    actions, rewards, contacts = [], [], []
    for k in range(steps):
        action = np.full((1, task.action_size), 0.7 * np.sin(0.05 * k))
        transition = task.step(states[-1], action)
        contacts.append(task.contact_impulses(states[-1], action)[0].tolist())
        states.append(transition.next_state)
        actions.append(action[0].tolist())
        rewards.append(float(transition.reward[0]))
        if transition.terminated[0]:
            break
    answer = {
        "environment": environment,
        "timestep": 20_000,
        "dt": 0.05,
        "states": [state[0].tolist() for state in states],
        "actions": actions,
        "rewards": rewards,
        "terminated": len(actions) < steps,
        "contacts": contacts,
        **film([task.draw(state[0]) for state in states]),
    }
    return {**answer, "surface": surface()} if environment == "MassPoint" else answer


def surface() -> dict[str, Any]:
    """The truth, and a critic that is off by a tilt."""
    positions, actions = np.linspace(-0.6, 0.6, 41), np.linspace(-1.0, 1.0, 21)
    grid = np.repeat(positions, 21)[:, None], np.tile(actions, 41)[:, None]
    truth = best_values(physics.make("MassPoint"), *grid, 0.99).reshape(41, 21)
    return {
        "positions": positions.tolist(),
        "actions": actions.tolist(),
        "value": (truth + 2.0 * actions).tolist(),
        "truth": truth.tolist(),
        "policy": (-np.tanh(8 * positions)).tolist(),
    }


def offer(page: Page, run_id: str, answer: dict[str, Any]) -> None:
    """Let the service offer the episode for a run."""

    def with_link(route: Route) -> None:
        run = route.fetch().json()
        run["links"]["rollout"] = f"/api/v1/runs/{run_id}/rollout"
        route.fulfill(json=run)

    page.route(f"**/api/v1/runs/{run_id}", with_link)
    page.route(f"**/api/v1/runs/{run_id}/rollout*", lambda route: route.fulfill(json=answer))
