"""A figure as a file's bytes: the same data always give the same bytes."""

import io
import threading
import unicodedata
import warnings
from collections.abc import Callable, Mapping
from importlib.resources import files
from typing import Any, cast

import matplotlib as mpl
from matplotlib.figure import Figure

from service.analysis.figures.figure_form import Form

DOTS_PER_INCH = 130
MAX_CHARACTERS = 120
# No time and no version of the program that drew: the same data are the same bytes.
METADATA: Mapping[Form, Mapping[str, None]] = {
    "png": {"Software": None},
    "svg": {"Date": None},
    "pdf": {"CreationDate": None, "Creator": None, "Producer": None},
}
INVISIBLE = frozenset({"Cc", "Cf", "Cs", "Cn", "Co"})  # Unicode categories

STYLE = str(files("service.analysis.figures") / "d3pg.mplstyle")

# matplotlib keeps its settings and caches for the process: nobody's matplotlibrc may change the
# figure, names are text and not mathematics, and one thread draws at a time.
mpl.rcdefaults()
mpl.rcParams.update(mpl.rc_params_from_file(STYLE, use_default_template=False))
drawing = threading.Lock()


def picture(
    draw: Callable[[], Figure], form: Form, settings: Mapping[str, Any] | None = None
) -> bytes:
    """Return what is drawn as a file's bytes, under matplotlib's settings of its own."""
    with drawing, warnings.catch_warnings(), mpl.rc_context(cast("Any", dict(settings or {}))):
        # A name may hold characters that the font lacks; the figure shows boxes for them.
        warnings.filterwarnings("ignore", message="Glyph .* missing from font")
        file = io.BytesIO()
        draw().savefig(file, format=form, dpi=DOTS_PER_INCH, metadata=dict(METADATA[form]))
    return file.getvalue()


def printable(text: str) -> str:
    """Return text cut to a line, without controls: an SVG forbids some, some turn text around."""
    shown = text if len(text) <= MAX_CHARACTERS else f"{text[: MAX_CHARACTERS - 1]}…"
    return "".join("\ufffd" if unicodedata.category(each) in INVISIBLE else each for each in shown)
