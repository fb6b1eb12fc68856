"""The pages on the tasks say what the code says."""

import re
from pathlib import Path

import pytest

import physics
from physics.audit.record import as_table, read_record
from physics.catalogue import OWN

DOCS = Path(__file__).parents[2] / "docs"


def test_the_audits_page_holds_its_record() -> None:
    assert as_table(read_record()) in (DOCS / "gradient-audit.md").read_text()


@pytest.mark.parametrize("name", OWN)
def test_the_table_of_tasks(name: str) -> None:
    environment = physics.make(name)
    rows = re.findall(
        rf"^\| {name} \| (.*) \|$", (DOCS / "simulators.md").read_text(), re.MULTILINE
    )
    assert len(rows) == 1, f"docs/simulators.md needs one row for {name}"
    cells = rows[0].replace(r"\|", "!").split(" | ")
    _, state_size, _, action_size, horizon, max_reward, reward, _ = cells
    assert int(state_size) == environment.state_size
    assert int(action_size) == environment.action_size
    assert int(horizon) == environment.horizon
    assert float(max_reward) == environment.max_reward
    assert ("not differentiable" in reward) == (not environment.reward_is_differentiable)
