"""Of which entry of its sweep's request each run is."""

import json
from collections.abc import Iterator
from typing import Any

import sqlalchemy as sa
from alembic import op

revision: str = "0007"
down_revision: str | None = "0006"

OF_RUNS = sa.text(
    "UPDATE runs SET entry = :entry "
    "WHERE sweep_number = :sweep AND ordinal BETWEEN :first AND :last"
)


def upgrade() -> None:
    """Add the column: until now a run's place in its sweep said its entry."""
    op.add_column("runs", sa.Column("entry", sa.Integer(), nullable=False, server_default="0"))
    connection = op.get_bind()
    for number, text in connection.execute(sa.text("SELECT number, request FROM sweeps")).all():
        request = json.loads(text)
        if not {"algorithms", "environments", "seeds"} <= request.keys():
            continue
        seeds = request["seeds"] if isinstance(request["seeds"], int) else len(request["seeds"])
        places = [
            {
                "sweep": number,
                "entry": entry,
                "first": cell * seeds,
                "last": (cell + 1) * seeds - 1,
            }
            for cell, entry in enumerate(cells(request))
            if entry
        ]
        if places:
            connection.execute(OF_RUNS, places)


def cells(request: dict[str, Any]) -> Iterator[int]:
    """Yield the place of each cell's entry: environment by environment, entry by entry."""
    environments = list(dict.fromkeys(request["environments"]))
    runs_in = [
        algorithm.get("environments") or environments
        for algorithm in request["algorithms"]
        for _ in range(pairs(algorithm.get("weights")))
    ]
    for environment in environments:
        yield from (place for place, own in enumerate(runs_in) if environment in own)


def pairs(weights: object) -> int:
    """Return how many entries an algorithm of this request was."""
    return len(weights) if isinstance(weights, list) else 1


def downgrade() -> None:
    """Go by the places again."""
    op.drop_column("runs", "entry")
