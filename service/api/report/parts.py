"""The parts of a report: tables of texts, of what the service answers."""

import json
import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from datetime import datetime
from typing import Any

import yaml

from service.analysis.statistics.score_table import ScoreTable, Standing
from service.api.schemas.moment import as_time
from service.api.schemas.statistics_answer import StatisticsAnswer
from service.model.compared import Compared
from service.model.request.entry import setting_text
from service.model.sweep import Sweep

NOTHING = "–"
CODE_CHARACTERS = 16


@dataclass(frozen=True)
class Table:
    """Heads and rows of texts; the first of a row is its own head."""

    heads: tuple[str, ...]
    rows: list[tuple[str, ...]]
    definition: str = ""
    title: str = ""


@dataclass(frozen=True)
class SweepPart:
    """What a report says of one sweep."""

    id: str
    name: str
    notes: str
    tags: tuple[str, ...]
    counts: str
    created_at: str
    request: str
    fingerprint: list[tuple[str, str]]


def sweep_part(sweep: Sweep, fingerprint: Mapping[str, Any] | None) -> SweepPart:
    """Return what is said of a sweep; the fingerprint is of one of its runs."""
    counts = {name: count for name, count in vars(sweep.runs).items() if count}
    told = ", ".join(f"{count} {name}" for name, count in counts.items())
    return SweepPart(
        id=sweep.id,
        name=sweep.name,
        notes=sweep.notes,
        tags=sweep.tags,
        counts=f"{sweep.runs.total} runs, {told}",
        created_at=day(as_time(sweep.created_at)),
        request=yaml.safe_dump(dict(sweep.request), sort_keys=False, allow_unicode=True),
        fingerprint=[(name, _plain(value)) for name, value in (fingerprint or {}).items()],
    )


def day(time: datetime) -> str:
    """Return `2026-11-24, 09:30 UTC`."""
    return f"{time:%Y-%m-%d, %H:%M} UTC"


def scores_table(table: ScoreTable) -> Table:
    """Return the scores of every entry in every task."""
    rows = [
        (row.label, *(_standing(each, table.decimals) for each in row.standings))
        for row in table.rows
    ]
    definition = table.definition.replace("Bold:", "Starred:")
    return Table(("Learner", *table.environments), rows, definition)


def _standing(standing: Standing | None, decimals: int) -> str:
    if standing is None or not standing.sample.n:
        return NOTHING
    sample = standing.sample
    deviation = f" ± {sample.std:.{decimals}f}" if math.isfinite(sample.std) else ""
    counted = sample.n if sample.n == standing.runs else f"{sample.n} of {standing.runs}"
    star = " *" if standing.is_best else ""
    return f"{sample.mean:.{decimals}f}{deviation} ({counted}){star}"


def statistics_tables(answer: StatisticsAnswer) -> Iterator[Table]:
    """Yield interquartile means, paired differences and probabilities of improvement."""
    means = answer.interquartile_mean
    tasks = f"Over {', '.join(answer.tasks)}. " if answer.tasks else ""
    yield Table(
        ("Learner", "interquartile mean", "95 % interval", "n"),
        [(each.label, _number(each.value), _interval(each), str(each.n)) for each in means.values],
        f"{answer.definition} {tasks}{means.definition}",
        "Interquartile means",
    )
    differences = answer.paired_differences
    yield Table(
        ("Learner", "minus", "task", "mean difference", "95 % interval", "pairs won"),
        [
            (
                each.label,
                each.baseline,
                each.environment,
                _number(each.mean),
                _interval(each),
                f"{each.wins} of {each.n}",
            )
            for each in differences.values
            if each.n
        ],
        differences.definition,
        "Paired differences",
    )
    improvements = answer.probability_of_improvement
    yield Table(
        ("x", "y", "P(x beats y)", "95 % interval"),
        [
            (each.x, each.y, _number(each.all_pairs.value), _interval(each.all_pairs))
            for each in improvements.pairs
        ],
        improvements.definition,
        "Probability of improvement",
    )


def _interval(bounds: Any) -> str:
    if bounds.low is None or bounds.high is None:
        return NOTHING
    return f"{bounds.low:.3f} to {bounds.high:.3f}"


def _number(value: float | None) -> str:
    return NOTHING if value is None else f"{value:.3f}"


def settings_table(compared: Compared) -> Table:
    """Return what each entry states, a column a setting that any of them states."""
    stated = [entry.stated for entry in compared.entries.all]
    names = list(dict.fromkeys(name for each in stated for name in each))
    rows = [
        (
            entry.label,
            entry.algorithm,
            *(setting_text(each[name]) if name in each else NOTHING for name in names),
        )
        for entry, each in zip(compared.entries.all, stated, strict=True)
    ]
    return Table(("Learner", "algorithm", *names), rows)


def _plain(value: Any) -> str:
    """A value of a fingerprint as text; a hash by its beginning."""
    text = value if isinstance(value, str) else json.dumps(value, ensure_ascii=False)
    return f"{text[:CODE_CHARACTERS]}…" if len(text) == 64 else text
