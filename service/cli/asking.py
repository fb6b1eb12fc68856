"""`d3pg ask`: decide whether a learner beats another one; seeds are added until it is decided."""

from __future__ import annotations

import warnings
from typing import Annotated

import typer

from service.api.schemas.question.verdict_answer import VerdictAnswer
from service.cli.algorithm_option import ALGORITHM_TEXT, algorithm_of
from service.cli.following import follow
from service.cli.submitting import say_notices
from service.cli.terminal import AsJson, console, print_json, say
from service.client import Client, SubmissionNotice
from service.model.request.entry import Entries

YES, NO, UNDECIDED = 0, 1, 2


def ask(
    question: Annotated[
        str,
        typer.Argument(
            metavar='"A vs B"', help=f"Learners: {ALGORITHM_TEXT}; A may be several: A and C."
        ),
    ],
    environment: Annotated[
        list[str], typer.Option("--environment", "-e", help="A task; may be repeated.")
    ],
    score: Annotated[str, typer.Option(help='area, final, or "seconds to X".')] = "area",
    margin: Annotated[
        float, typer.Option(help="Differences below this value do not matter.")
    ] = 0.02,
    confidence: Annotated[float, typer.Option(help="Confidence of all decisions together.")] = 0.95,
    max_seeds: Annotated[
        int, typer.Option(help="Seeds of each learner in each task, at most.")
    ] = 128,
    batch: Annotated[int, typer.Option(help="Seeds between two looks.")] = 8,
    clip: Annotated[
        float, typer.Option(help="Larger differences of a pair count as this value.")
    ] = 1.0,
    method: Annotated[str, typer.Option(help="bounded or normal.")] = "bounded",
    drop_losers: Annotated[
        bool,
        typer.Option(
            "--drop-losers", help="Add no more seeds to a learner that is worse in one task."
        ),
    ] = False,
    timesteps: Annotated[
        int | None, typer.Option(help="Timesteps of each run; the preset's if unset.")
    ] = None,
    name: Annotated[
        str | None, typer.Option(help="Name of the sweep; the question if unset.")
    ] = None,
    as_json: AsJson = False,
) -> None:
    """Ask whether A beats B, and wait for the answer; the service adds seeds until it is decided.

    Exit codes: 0 yes: better somewhere, worse nowhere; 1 no: worse somewhere, or equivalent
    everywhere; 2 not decided; 64 called wrongly; 65 refused by the service; 69 no service answers.
    """
    ours, theirs = sides_of(question)
    request = {
        "name": name or question,
        "algorithms": [algorithm_of(each) for each in (theirs, *ours)],
        "environments": environment,
        "seeds": min(batch, max_seeds),
        **({} if timesteps is None else {"timesteps": timesteps}),
    }
    entries = Entries(request).all
    against, *grid = (entry.label for entry in entries if entry.item == 0)
    if grid:
        raise typer.BadParameter(f"{theirs!r} is a grid: compare with one learner")
    compare = [entry.label for entry in entries if entry.item]
    asked = {
        "compare": compare, "with": against, "score": score, "margin": margin,
        "confidence": confidence, "max_seeds": max_seeds, "batch": batch, "clip": clip,
        "method": method, "drop_losers": drop_losers,
    }  # fmt: skip
    with Client() as client:
        with warnings.catch_warnings(action="ignore", category=SubmissionNotice):
            sweep = client.submit({**request, "question": asked})
        if as_json:
            client.wait(sweep.id)
            print_json(client.verdict(sweep.id))
        else:
            say(f"Sweep {sweep.id}: {client.url}/sweeps/{sweep.id}")
            say_notices(sweep.notices)
            follow(client, sweep.id, console)  # it ends with the verdict
        code = exit_code(client.verdict(sweep.id))
    raise typer.Exit(code)


def sides_of(question: str) -> tuple[list[str], str]:
    """`a and c vs b` as ([a, c], b). Raises typer.BadParameter."""
    left, versus, right = question.partition(" vs ")
    ours, theirs = [each.strip() for each in left.split(" and ")], right.strip()
    if not versus or not all(ours) or not theirs or " vs " in theirs:
        raise typer.BadParameter(
            f'{question!r} is not a question: write "A vs B", as in "hybrid-ddpg vs ddpg"',
            param_hint="QUESTION",
        )
    return ours, theirs


def exit_code(verdict: VerdictAnswer) -> int:
    """Return the exit code of a verdict: YES, NO or UNDECIDED."""
    outcomes = {each.outcome for each in verdict.comparisons}
    if "worse" in outcomes:
        return NO
    if not outcomes or outcomes - {"better", "equivalent"}:
        return UNDECIDED
    return YES if "better" in outcomes else NO
