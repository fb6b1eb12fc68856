"""The commands of `python -m algorithms`: training and diagnosing, without a service.

Exit codes: 0 done; 1 a run diverged or failed; 2 the command was called wrongly;
130 interrupted.
"""

import json
from collections.abc import Callable
from contextlib import ExitStack
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer
from rich.console import Console
from rich.table import Table

import algorithms
import physics
from algorithms import catalogue
from algorithms.cli import findings
from algorithms.cli.curve_file import CurveFile
from algorithms.cli.display import display, summary
from algorithms.cli.outcome import Outcome
from algorithms.presets import completed, preset
from algorithms.settings import SettingsError

if TYPE_CHECKING:
    from algorithms.diagnostics.finding import Finding
    from algorithms.learner import Learner
    from physics.environment import Environment

app = typer.Typer(
    name="python -m algorithms",
    help="Train learners on one machine, without a service.",
    no_args_is_help=True,
    add_completion=False,
    pretty_exceptions_enable=False,
)
console = Console()


@app.command(name="list")
def list_names() -> None:
    """List the algorithms and the tasks."""
    table = Table("algorithm", "what it is", box=None)
    for name in algorithms.names():
        table.add_row(name, catalogue.find(name).summary)
    console.print(table)
    console.print(f"\nTasks: {', '.join(physics.names())}", soft_wrap=True, highlight=False)


Seeds = Annotated[int, typer.Option(min=1, help="How many runs: seeds 0, 1, ...")]
Timesteps = Annotated[int | None, typer.Option(min=1, help="Of each run; the preset's if unset.")]
Weights = Annotated[
    tuple[float, float] | None,
    typer.Option(metavar="W1 W2", help="Of the gradient terms; the preset's if unset."),
]
Config = Annotated[
    list[str] | None,
    typer.Option(metavar="NAME=VALUE", help="A setting; may be given again for others."),
]


@app.command()
def train(
    algorithm: Annotated[str, typer.Argument(help="As `list` shows them.")],
    environment: Annotated[str, typer.Argument(help="The task: its name, or my_tasks.py:Arm.")],
    seeds: Seeds = 1,
    timesteps: Timesteps = None,
    weights: Weights = None,
    config: Config = None,
    csv: Annotated[
        Path | None, typer.Option(metavar="FILE", help="A new file for every measurement.")
    ] = None,
) -> None:
    """Train runs that differ in their seed, all at once, and show their progress."""
    task = made(environment)
    usual = preset(algorithm, task.name)
    steps = usual.timesteps if timesteps is None else timesteps
    settings = read_settings(config or [])
    outcome = Outcome(range(seeds))
    build = prepared(algorithm, task, outcome.seeds, weights, steps, settings)
    with ExitStack() as stack:
        curves = CurveFile(stack.enter_context(new_file(csv))) if csv else None
        trained(build, f"{algorithm} on {task.label}", steps, outcome, curves)
    console.print(summary(outcome))
    if outcome.ended:
        complain_of_ends(outcome)
        raise typer.Exit(1)


@app.command()
def diagnose(
    environment: Annotated[str, typer.Argument(help="The task: its name, or my_tasks.py:Arm.")],
    algorithm: Annotated[
        str, typer.Option(help="The algorithm that learns the policy.")
    ] = "hybrid-ddpg-robust",
    seeds: Seeds = 1,
    timesteps: Timesteps = None,
    weights: Weights = None,
    config: Config = None,
    csv: Annotated[
        Path | None, typer.Option(metavar="FILE", help="A new file for every number.")
    ] = None,
) -> None:
    """Train runs, then show where the simulator's gradients can help them and where they cannot.

    With several seeds, the tables show medians.
    """
    task = made(environment)
    usual = preset(algorithm, task.name)
    steps = usual.timesteps if timesteps is None else timesteps
    settings = read_settings(config or [])
    outcome = Outcome(range(seeds))
    build = prepared(algorithm, task, outcome.seeds, weights, steps, settings)

    def build_with_policy() -> "Learner":
        learner = build()
        if learner.snapshot(0) is None:
            raise typer.BadParameter(
                f"{algorithm} learns no policy to diagnose: choose another, such as ddpg",
                param_hint="--algorithm",
            )
        return learner

    with ExitStack() as stack:
        file = stack.enter_context(new_file(csv)) if csv else None
        title = f"{algorithm} on {task.label}"
        learner = trained(build_with_policy, title, steps, outcome, None)
        gamma = discount(algorithm, task.name, settings)
        found = diagnosed(learner, task, gamma, outcome)
        if file:
            findings.write(file, found)
    for heading, table in findings.tables(found):
        console.print(f"\n{heading}", style="bold", highlight=False)
        console.print(table)
    if outcome.ended:
        complain_of_ends(outcome)
        raise typer.Exit(1)


def trained(
    build: "Callable[[], Learner]",
    title: str,
    timesteps: int,
    outcome: Outcome,
    curves: CurveFile | None,
) -> "Learner":
    """Train to the end and show the progress; raises typer.Exit if training cannot go on."""
    try:
        with display(console, title, timesteps, outcome) as show:
            learner = build()
            while not learner.finished:
                measured = outcome.take(learner.advance())
                if curves:
                    curves.write(measured)
                show(timesteps if learner.finished else learner.timestep)
            return learner
    except KeyboardInterrupt:
        console.print(summary(outcome))
        console.print("Interrupted: what was measured so far is above.")
        raise typer.Exit(130) from None
    except ArithmeticError as error:
        complain(f"training could not go on: {error}")
        raise typer.Exit(1) from None


def diagnosed(
    learner: "Learner", environment: "Environment", gamma: float | None, outcome: Outcome
) -> "dict[int, list[Finding]]":
    """The findings of each run that reached its end; raises typer.Exit if there can be none."""
    try:
        return {
            seed: algorithms.diagnose(environment, snapshot, gamma, seed)
            for seed in outcome.seeds
            if seed not in outcome.ended and (snapshot := learner.snapshot(seed)) is not None
        }
    except (ArithmeticError, ValueError) as error:
        complain(f"the diagnosis could not go on: {error}")
        raise typer.Exit(1) from None


def discount(algorithm: str, environment: str, settings: dict[str, Any]) -> float | None:
    """The gamma of a run with these settings; None if the algorithm has none."""
    config = catalogue.find(algorithm).config_class()(**completed(algorithm, environment, settings))
    return getattr(config, "gamma", None)


def complain_of_ends(outcome: Outcome) -> None:
    """Print which runs ended early, and why."""
    for end in outcome.ended.values():
        complain(f"seed {end.seed} {end.reason}")
    complain(f"{len(outcome.ended)} of {len(outcome.seeds)} runs ended early.")


def made(environment: str) -> "Environment":
    """The task; raises typer.BadParameter with its mistakes."""
    try:
        return physics.as_task(environment)
    except ValueError as error:
        raise typer.BadParameter(str(error)) from None


def prepared(
    algorithm: str,
    environment: "Environment",
    seeds: list[int],
    weights: tuple[float, float] | None,
    timesteps: int,
    settings: dict[str, Any],
) -> Callable[[], "Learner"]:
    """A function that builds the learner; raises typer.BadParameter with the call's mistakes."""
    try:
        return algorithms.prepare(algorithm, environment, seeds, weights, timesteps, settings)
    except SettingsError as error:
        raise typer.BadParameter(str(error), param_hint="--config") from None
    except ValueError as error:
        raise typer.BadParameter(str(error)) from None


def read_settings(pairs: list[str]) -> dict[str, Any]:
    """`NAME=VALUE` pairs as settings; raises typer.BadParameter for anything else."""
    settings = {}
    for pair in pairs:
        name, equals, value = pair.partition("=")
        if not name or not equals:
            raise typer.BadParameter(
                f"{pair!r} is not NAME=VALUE, such as gamma=0.99", param_hint="--config"
            )
        try:
            settings[name] = json.loads(value)
        except json.JSONDecodeError:
            settings[name] = value
    return settings


def new_file(path: Path) -> Any:
    """Create and open a file; raises typer.BadParameter if it exists or cannot be created."""
    try:
        return path.open("x", encoding="utf-8", newline="")
    except FileExistsError:
        raise typer.BadParameter(
            f"{path} exists already: name another file, or remove it", param_hint="--csv"
        ) from None
    except OSError as error:
        raise typer.BadParameter(
            f"cannot write {path}: {error.strerror}", param_hint="--csv"
        ) from None


def complain(sentence: str) -> None:
    """Print an error to standard error."""
    Console(stderr=True).print(sentence, style="red", markup=False, soft_wrap=True)
