"""A table of scores as text for papers and pages: Markdown and LaTeX (booktabs), best in bold.

Names are shown as they are: what means something to Markdown or LaTeX is escaped.
"""

import re
import unicodedata

from service.analysis.statistics.score_table import ScoreTable, Standing

NOTHING = "–"
MARKDOWN_SPECIAL = re.compile(r"([\\`*_{}\[\]()<>#+!|~&$-])")
LATEX_SPECIAL = {
    "\\": r"\textbackslash{}",
    "~": r"\textasciitilde{}",
    "^": r"\textasciicircum{}",
    "<": r"\textless{}",
    ">": r"\textgreater{}",
    "|": r"\textbar{}",
    '"': r"\textquotedbl{}",
    **{character: f"\\{character}" for character in "&%$#_{}"},
}


def markdown(title: str, table: ScoreTable) -> str:
    """Return the table in Markdown: mean ± std (n)."""
    rule = ["---", *("---:" for _ in table.environments)]
    lines = [["", *(escape_markdown(name) for name in table.environments)], rule]
    for row in table.rows:
        cells = [_markdown_cell(each, table.decimals) for each in row.standings]
        lines.append([escape_markdown(row.label), *cells])
    rows = "\n".join(f"| {' | '.join(cells)} |" for cells in lines)
    return f"**{escape_markdown(title)}**\n\n{rows}\n\n{table.definition} Cells: mean ± std (n).\n"


def latex(title: str, table: ScoreTable) -> str:
    """Return the table as a LaTeX float; it needs the package booktabs."""
    header = " & ".join(["", *(escape_latex(name) for name in table.environments)])
    rows = [
        " & ".join(
            [
                escape_latex(row.label),
                *(_latex_cell(each, table.decimals) for each in row.standings),
            ]
        )
        for row in table.rows
    ]
    caption = f"{escape_latex(title)}. {escape_latex(table.definition)}"
    return "\n".join(
        [
            r"\begin{table}",
            r"\centering",
            rf"\caption{{{caption} Cells: mean $\pm$ std (n).}}",
            rf"\begin{{tabular}}{{l{'r' * len(table.environments)}}}",
            r"\toprule",
            rf"{header} \\",
            r"\midrule",
            *(rf"{row} \\" for row in rows),
            r"\bottomrule",
            r"\end{tabular}",
            r"\end{table}",
            "",
        ]
    )


def escape_markdown(text: str) -> str:
    """Return text that Markdown shows as it is, on one line."""
    return MARKDOWN_SPECIAL.sub(r"\\\1", _line(text))


def escape_latex(text: str) -> str:
    """Return text that LaTeX shows as it is, on one line."""
    return "".join(LATEX_SPECIAL.get(character, character) for character in _line(text))


def _line(text: str) -> str:
    """Controls and line ends become spaces: a table's row is one line."""
    return "".join(
        " " if unicodedata.category(each) in {"Cc", "Zl", "Zp"} else each for each in text
    )


def _markdown_cell(standing: Standing | None, decimals: int) -> str:
    if standing is None:
        return NOTHING
    if standing.sample.n == 0:
        return f"{NOTHING} ({counted(standing)})"
    mean, spread = _numbers(standing, decimals)
    shown = f"**{mean}**" if standing.is_best else mean
    return " ".join([shown, *(["±", spread] if spread else []), f"({counted(standing)})"])


def _latex_cell(standing: Standing | None, decimals: int) -> str:
    if standing is None:
        return "--"
    if standing.sample.n == 0:
        return f"-- ({counted(standing)})"
    mean, spread = _numbers(standing, decimals)
    shown = rf"$\mathbf{{{mean}}}$" if standing.is_best else f"${mean}$"
    return " ".join([shown, *([r"$\pm$", spread] if spread else []), f"({counted(standing)})"])


def counted(standing: Standing) -> str:
    """How many runs count: `16`, or `5 of 6` where some do not."""
    n, runs = standing.sample.n, standing.runs
    return str(n) if n == runs else f"{n} of {runs}"


def _numbers(standing: Standing, decimals: int) -> tuple[str, str]:
    """Mean and standard deviation as they are printed; no deviation of a single value."""
    return (
        f"{standing.sample.mean:.{decimals}f}",
        f"{standing.sample.std:.{decimals}f}" if standing.sample.n > 1 else "",
    )
