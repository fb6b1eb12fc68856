"""Table 1 in Markdown and LaTeX: numbers, bold, and names that mean nothing to either."""

import math
import re

from service.analysis.statistics.score_table import ScoreTable, score_table
from service.analysis.statistics.score_table_text import latex, markdown
from service.model.run import RunStatus
from tests.service.scored import cell

STATUSES = (RunStatus.SUCCEEDED, RunStatus.DIVERGED)
SPECIAL = r"50% of $x_1^2 & {a}|b* #~\ <i>"


def table() -> ScoreTable:
    return score_table(
        [
            cell("ddpg", "Pendulum", [0.5, 0.7]),
            cell("hybrid w1=0.1", "Pendulum", [0.9]),
            cell("gd", "Pendulum", [math.nan]),
            cell("mpc", "Pendulum", [0.99, math.nan], statuses=STATUSES),
            cell("gd", "CartPole", [-0.25, -0.25]),
        ],
        "return_history",
        normalized=True,
    )


def test_markdown() -> None:
    lines = markdown("small", table()).splitlines()
    assert lines[0] == "**small**"
    assert lines[2:8] == [
        "|  | Pendulum | CartPole |",
        "| --- | ---: | ---: |",
        "| ddpg | 0.600 ± 0.141 (2) | – |",
        "| hybrid w1=0.1 | **0.900** (1) | – |",
        "| gd | – (0 of 1) | **-0.250** ± 0.000 (2) |",
        "| mpc | 0.990 (1 of 2) | – |",
    ]
    assert lines[-1].endswith("Cells: mean ± std (n).")


def test_latex() -> None:
    text = latex("small", table())
    assert r" & Pendulum & CartPole \\" in text
    assert r"ddpg & $0.600$ $\pm$ 0.141 (2) & -- \\" in text
    assert r"hybrid w1=0.1 & $\mathbf{0.900}$ (1) & -- \\" in text
    assert r"mpc & $0.990$ (1 of 2) & -- \\" in text
    assert "1 diverged" in text
    assert r"gd & -- (0 of 1) & $\mathbf{-0.250}$ $\pm$ 0.000 (2) \\" in text
    assert r"\begin{tabular}{lrr}" in text
    assert r"95 \% confidence" in text


def test_names_are_text() -> None:
    odd = score_table([cell(SPECIAL, "a\nb", [1.0])], "area", normalized=False)
    (row,) = [line for line in markdown(SPECIAL, odd).splitlines() if "1.00" in line]
    assert len(re.findall(r"(?<!\\)\|", row)) == 3
    assert r"\<i\>" in row
    text = latex(SPECIAL, odd)
    assert r"50\% of \$x\_1\textasciicircum{}2 \& \{a\}\textbar{}b* \#\textasciitilde{}" in text
    assert r" & a b \\" in text
