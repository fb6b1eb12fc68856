"""tuning.csv: the outcome of each cell of the search, a line a cell."""

import csv
import json
from collections.abc import Iterable
from dataclasses import asdict
from pathlib import Path

from service.paper.search.tuning import Outcome
from workers.messages.run_spec import Weights

FILE = "tuning.csv"


def read(folder: Path) -> list[Outcome]:
    """Read tuning.csv; return nothing if it is missing."""
    file = folder / FILE
    if not file.exists():
        return []
    with file.open(encoding="utf-8", newline="") as lines:
        return [
            Outcome(
                row["environment"],
                row["algorithm"],
                Weights(float(row["w1"]), float(row["w2"])),
                json.loads(row["config"]),
                float(row["area"]),
                float(row["end"]),
                int(row["runs"]),
                row["sweep"],
            )
            for row in csv.DictReader(lines)
        ]


def write(folder: Path, rows: Iterable[Outcome]) -> None:
    """Write tuning.csv: a line a cell."""
    folder.mkdir(parents=True, exist_ok=True)
    with (folder / FILE).open("w", encoding="utf-8", newline="") as output:
        writer = csv.writer(output, lineterminator="\n")
        writer.writerow(
            ("environment", "algorithm", "w1", "w2", "config", "area", "end", "runs", "sweep")
        )
        for row in rows:
            place = (row.environment, row.algorithm, *row.weights)
            config = json.dumps(asdict(row)["config"], sort_keys=True)
            reached = (f"{row.area:.4f}", f"{row.end:.4f}", row.runs, row.sweep)
            writer.writerow((*place, config, *reached))
