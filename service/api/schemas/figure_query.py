"""Options of a figure of curves: what it shows, and how it looks."""

from collections.abc import Iterator, Mapping, Sequence
from typing import Annotated, Literal

from pydantic import BaseModel, BeforeValidator, ConfigDict, Field

from service.analysis.comparison import Abscissa, Comparison
from service.analysis.curves import Band
from service.analysis.figures.design import COLUMN_INCHES, Design, FontFamily
from service.api.refusals.problems import Fault
from service.api.schemas.requests.texts import Text
from service.model.run_curve import RETURNS

MAX_METRICS = 4
MAX_LISTED = 200
COLOUR = r"^.+=#[0-9a-fA-F]{6}$"
NAME = r"^.+=.+$"

Names = Annotated[list[Text], Field(max_length=MAX_LISTED)]
Number = Annotated[float, Field(allow_inf_nan=False)]


class FigureQuery(BaseModel):
    """Curves of a sweep, and their look; by default every curve, as on the sweep's page."""

    model_config = ConfigDict(extra="forbid")

    metric: Annotated[list[Text], Field(max_length=MAX_METRICS)] = Field(
        default=list(RETURNS), description="Metrics, a row of panels each."
    )
    environment: Names = Field(default=[], description="Tasks to draw, in this order; none: all.")
    entry: Names = Field(
        default=[], description="Labels of entries to draw, in this order; none: all."
    )
    name: list[Annotated[Text, Field(pattern=NAME)]] = Field(
        default=[],
        max_length=MAX_LISTED,
        description="`label=name`: name of an entry in the figure.",
    )
    colour: list[Annotated[Text, Field(pattern=COLOUR)]] = Field(
        default=[], max_length=MAX_LISTED, description="`label=#0072b2`."
    )
    normalized: bool | None = Field(
        default=None, description="0 acts at random, 1 is the best. By default true for returns."
    )
    band: Literal["std", "ci95", "iqr", "none"] = "std"
    seeds: bool = Field(default=False, description="The curve of each run, too, as a thin line.")
    smoothing: float = Field(
        default=0.0, ge=0.0, lt=1.0, description="Weight of the debiased exponential average."
    )
    x: Abscissa = "timesteps"
    logx: bool = False
    logy: bool = False
    xmin: Number | None = None
    xmax: Number | None = None
    ymin: Number | None = None
    ymax: Number | None = None
    robust: bool = Field(
        default=False, description="2 % of the values at either end do not set the y axis."
    )
    align: bool = Field(default=False, description="One y axis for all panels of a row.")
    max_points: int = Field(default=300, ge=2, le=10_000, description="Points of a curve, at most.")
    per_row: int | None = Field(
        default=None,
        ge=1,
        le=50,
        description="Panels in a row, with a single metric; by default four.",
    )
    columns: Annotated[Literal[1, 2], BeforeValidator(int)] | None = Field(
        default=None,
        description=f"Columns of a paper: {COLUMN_INCHES[1]} or {COLUMN_INCHES[2]} inches wide.",
    )
    width: float | None = Field(default=None, ge=1.0, le=60.0, description="Inches.")
    height: float | None = Field(default=None, ge=1.0, le=60.0, description="Inches.")
    font_size: float = Field(default=8.0, ge=4.0, le=24.0, description="Size in points.")
    font_family: FontFamily = "sans-serif"
    title: bool = True
    caption: bool = Field(default=True, description="What the figure shows, in words, below it.")
    legend: bool = True

    @property
    def band_asked(self) -> Band:
        """The band of the curves, whether it is drawn or not."""
        return "std" if self.band == "none" else self.band

    @property
    def design(self) -> Design:
        """The look that the query states."""
        return Design(
            environments=tuple(self.environment),
            labels=tuple(self.entry),
            names=_pairs(self.name),
            colours=_pairs(self.colour),
            has_band=self.band != "none",
            has_seeds=self.seeds,
            smoothing=self.smoothing,
            is_log_x=self.logx,
            is_log_y=self.logy,
            x_limits=(self.xmin, self.xmax),
            y_limits=(self.ymin, self.ymax),
            is_robust=self.robust,
            is_aligned=self.align,
            per_row=self.per_row,
            width=self.width or (COLUMN_INCHES[self.columns] if self.columns else None),
            height=self.height,
            font_size=self.font_size,
            font_family=self.font_family,
            has_title=self.title,
            has_caption=self.caption,
            has_legend=self.legend,
        )

    def faults(self, comparison: Comparison) -> Iterator[Fault]:
        """Yield what the query names and the sweep does not have."""
        labels = [entry.label for entry in comparison.entries]
        tasks = [panel.environment for panel in comparison.panels]
        yield from _unknown("environment", self.environment, tasks)
        yield from _unknown("entry", self.entry, labels)
        yield from _unknown("name", list(_pairs(self.name)), labels)
        yield from _unknown("colour", list(_pairs(self.colour)), labels)
        for axis, low, high in (("xmax", self.xmin, self.xmax), ("ymax", self.ymin, self.ymax)):
            if low is not None and high is not None and low >= high:
                yield Fault(axis, f"is {high:g}, but must be above {axis[0]}min, {low:g}", low)
        if self.width and self.columns:
            yield Fault("width", "leave out width or columns: each sets the width of the figure")


def _pairs(texts: Sequence[str]) -> Mapping[str, str]:
    """Read `label=value`; a label may have signs of equality itself."""
    return dict(text.rsplit("=", 1) for text in texts)


def _unknown(field: str, asked: Sequence[str], known: Sequence[str]) -> Iterator[Fault]:
    for place, each in enumerate(asked):
        if each not in known:
            listed = ", ".join(known) or "none yet"
            yield Fault(f"{field}[{place}]", f"the sweep has no {each!r} (it has: {listed})")
