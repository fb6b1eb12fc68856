"""What can be wrong with a sweep's question, and notices for its author."""

from collections.abc import Iterator
from dataclasses import replace
from itertools import product

from service.analysis.question.forecast import MOST_PAIRS, fewest_to_equivalence
from service.api.refusals.nearest import unknown_name
from service.api.refusals.problems import Fault, printable
from service.api.schemas.requests.sweep_request import MAX_RUNS, MAX_SEED
from service.model.inquiry.question import Question
from service.model.inquiry.tuning_seeds import PRESETS, SEARCHES, chooses, seeds_text
from service.model.request.entry import Entries

SMALL_CLIP = 0.25
MAX_LOOKS = 200


def question_faults(question: Question | None, entries: Entries) -> Iterator[Fault]:
    """Refuse what cannot be asked of these entries, or not of so many seeds."""
    if question is None:
        return
    yield from _label_faults(question, entries)
    if chosen := [seed for seed in question.first if chooses(seed)]:
        message = (
            f"{chosen[0]:,} chose settings, so a question does not count it: give a list without "
            f"the seeds {seeds_text(PRESETS)} (of the presets) and {seeds_text(SEARCHES)} (of "
            "searches)"
        )
        yield Fault("seeds", message)
    if question.margin >= question.clip:
        message = f"must be below question.clip ({question.clip:g}), which limits all differences"
        yield Fault("question.margin", message, question.clip)
    if question.max_seeds < len(question.first):
        message = f"is below the sweep's own {len(question.first)} seeds: give at least that many"
        yield Fault("question.max_seeds", message, len(question.first))
    if question.looks > MAX_LOOKS:
        fewest = -(-(question.max_seeds - len(question.first)) // (MAX_LOOKS - 1))
        message = (
            f"would take {question.looks} looks, of at most {MAX_LOOKS}: give {fewest} or more"
        )
        yield Fault("question.batch", message, fewest)
    if max(question.seeds(question.looks)) > MAX_SEED:
        message = f"the seeds that follow {max(question.first)} would be above {MAX_SEED}"
        yield Fault("question.max_seeds", message, MAX_SEED)
    runs = most_runs(question, entries)
    if runs > MAX_RUNS:
        message = (
            f"with {question.max_seeds} seeds the sweep would have {runs:,} runs; "
            f"it has at most {MAX_RUNS:,}"
        )
        yield Fault("question.max_seeds", message, MAX_RUNS)


def question_notices(question: Question | None, entries: Entries) -> Iterator[str]:
    """Tell how far the sweep may grow, and what its budget cannot decide."""
    if question is None:
        return
    first = len(entries.cells) * len(question.first)
    yield (
        f"The question adds seeds until it is decided: the {first:,} runs may become "
        f"{most_runs(question, entries):,}."
    )
    asked = {*question.compare, question.against}
    for entry in entries.all:
        if entry.label not in asked:
            yield f"{entry.field} ({entry.label}) is not asked about: it gets no further seeds."
    yield from _unreachable(question, len(comparisons(question, entries)))


def comparisons(question: Question, entries: Entries) -> list[tuple[str, str]]:
    """Return tasks and labels that are compared: where both entries run."""
    there = {(environment, entry.label) for environment, entry in entries.cells}
    environments = dict.fromkeys(environment for environment, _ in entries.cells)
    return [
        (environment, label)
        for environment, label in product(environments, question.compare)
        if {(environment, label), (environment, question.against)} <= there
    ]


def most_runs(question: Question, entries: Entries) -> int:
    """Return how many runs the sweep can come to have."""
    compared = comparisons(question, entries)
    cells = {*compared, *((environment, question.against) for environment, _ in compared)}
    most = max(question.max_seeds, len(question.first))
    others = len(entries.cells) - len(cells)
    return others * len(question.first) + len(cells) * most


def _label_faults(question: Question, entries: Entries) -> Iterator[Fault]:
    labels = [entry.label for entry in entries.all]
    asked = {f"question.compare[{i}]": label for i, label in enumerate(question.compare)}
    for field, label in {**asked, "question.with": question.against}.items():
        if label not in labels:
            yield unknown_name(field, label, labels)
    first: dict[str, str] = {}
    for field, label in asked.items():
        if label == question.against:
            yield Fault(field, f"{printable(label)!r} would be compared with itself")
        if (earlier := first.setdefault(label, field)) != field:
            yield Fault(field, f"is the same as {earlier}")
        both = {label, question.against}
        if both <= {*labels} and not _share_a_task(both, entries):
            yield Fault(
                field,
                f"{printable(label)!r} and {printable(question.against)!r} have no task in common",
            )


def _share_a_task(labels: set[str], entries: Entries) -> bool:
    runs_in = [{*entry.environments} for entry in entries.all if entry.label in labels]
    return bool(set.intersection(*runs_in))


def _unreachable(question: Question, compared: int) -> Iterator[str]:
    """Tell if the budget has too few seeds to find even equal entries equivalent."""
    fewest = fewest_to_equivalence(question, compared)
    if fewest is not None and fewest <= question.max_seeds:
        return
    needed = f"{fewest} at least" if fewest else f"more than {MOST_PAIRS:,}"
    clipped = replace(question, clip=min(max(SMALL_CLIP, 2 * question.margin), question.clip))
    fewer = fewest_to_equivalence(clipped, compared)
    is_fewer = fewer is not None and fewer < (fewest or MOST_PAIRS)
    advice = f', or {fewer} with "clip": {clipped.clip:g}' if is_fewer else ""
    yield (
        f"With {question.max_seeds} seeds no difference can be found to be below "
        f"{question.margin:g}: that needs {needed}{advice}. Better and worse can be found."
    )
