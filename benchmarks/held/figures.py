"""The figures to hold, in the order of docs/figures-to-hold.md."""

from benchmarks.held.figure import Figure

ROW = r"(?m)^{}(?: +[\d.]+){{{}}} +# "
"""A line of a table of numbers: its name, and how many numbers precede the wanted one."""
WINDOWS = (
    r"windows and the actor's step, steps a second:\n(?:    .*\n)*?    torch's loop{}: [\d,]+ "
)


def benchmark(name: str) -> tuple[str, ...]:
    """Return the command of a benchmark."""
    return (f"benchmarks.{name}",)


def tests(path: str) -> tuple[str, ...]:
    """Return the command that runs tests, slow ones too."""
    return ("pytest", "-q", "-p", "no:xdist", path)


FIGURES = (
    Figure(
        "a sweep of 10,000 runs accepted over REST",
        benchmark("requests"),
        "submitted over REST: # s",
        5.0,
        "s",
    ),
    Figure(
        "SIGTERM to the end, 50 event streams and a local Ray open",
        benchmark("requests"),
        "streams open: # s",
        5.0,
        "s",
    ),
    Figure(
        "server killed: serving again, every run truthful", tests("tests/end_to_end/test_faults.py")
    ),
    Figure(
        "curves of a sweep of 224,000 points",
        benchmark("overview"),
        ROW.format("curves", 0),
        1.0,
        "s",
    ),
    Figure("their size", benchmark("overview"), ROW.format("curves", 2), 1000.0, "kB"),
    Figure(
        "any read of a sweep of 5,000,000 points",
        benchmark("large_sweep"),
        ROW.format(r"/[^\s,]+", 0),
        3.0,
        "s",
    ),
    Figure(
        "the same: memory beyond the idle service",
        benchmark("large_sweep"),
        ROW.format(r"/[^\s,]+", 2),
        300.0,
        "MB",
    ),
    Figure(
        "16 such reads of /curves at once: memory",
        benchmark("large_sweep"),
        ROW.format("/curves, 16 at once", 2),
        600.0,
        "MB",
    ),
    Figure("pages in Chromium, to the first paint", tests("tests/web/test_performance.py")),
    Figure(
        "/healthz while two workers train, p99",
        benchmark("dispatch"),
        "while two workers train, p99: # ms",
        50.0,
        "ms",
    ),
    Figure(
        "what the queue adds to a run, median",
        benchmark("dispatch"),
        "a run's overhead, median: # s",
        0.1,
        "s",
    ),
    Figure(
        "a cluster's nodes, head and service killed: every run truthful",
        tests("tests/end_to_end/test_cluster_faults.py"),
    ),
    Figure(
        "a run's seconds, trained again: farthest from their median",
        benchmark("training_seconds"),
        "farthest from its median: # %",
        5.0,
        "%",
    ),
    Figure(
        "the same beside a busy core",
        benchmark("training_seconds"),
        "the same, farthest: # %",
        15.0,
        "%",
    ),
    Figure("made-up requests answered below 500", tests("tests/service/test_openapi.py")),
    Figure(
        "aborted event streams leave nothing behind",
        tests("tests/service/api/routes/test_events.py"),
    ),
    *(
        Figure(
            f"measurements made durable a second, {database}",
            benchmark("store"),
            f"{database}, measurements taken in: # 1/s",
            50_000.0,
            "1/s",
            is_least=True,
        )
        for database in ("SQLite", "PostgreSQL")
    ),
    *(
        Figure(
            f"1,000 workers, 100,000 queued runs: a worker's time lost, {database}",
            benchmark("many_workers"),
            f"{database}, 1,000 workers, a worker's time lost: # %",
            2.0,
            "%",
        )
        for database in ("SQLite", "PostgreSQL")
    ),
    Figure(
        "two workers / one, seed-updates a second",
        benchmark("two_workers"),
        "two workers / one, at best 2: #",
        1.9,
        is_least=True,
    ),
    Figure(
        "SHAC's windows over a torch loop's, one environment at a time",
        benchmark("short_horizon"),
        WINDOWS.format(", one environment at a time") + r"\(a run alone: # times",
        50.0,
        "x",
        is_least=True,
    ),
    Figure(
        "the same, torch's 64 environments in one batch",
        benchmark("short_horizon"),
        WINDOWS.format("") + r"\(a run alone: # times",
        50.0,
        "x",
        is_least=True,
    ),
    Figure(
        "a step of the robots over as many mj_step of Euler's",
        benchmark("robots"),
        "step over MuJoCo's of Euler's: # x",
        0.3,
        "x",
    ),
    Figure(
        "MuJoCo's Jacobians by differences over a step with its Jacobian",
        benchmark("robots"),
        r"MuJoCo's Jacobian over \w+ differentiate: # x",
        20.0,
        "x",
        is_least=True,
    ),
    Figure(
        "MuJoCo's ready-made tasks, 16 rows: steps over mujoco.rollout's",
        benchmark("simulators"),
        "batch 16, step over mujoco.rollout: # x",
        0.8,
        "x",
        is_least=True,
    ),
)
