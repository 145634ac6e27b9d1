"""One look for everything that is drawn: colours, dashes, sizes, and legible characters."""

import math
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from functools import cache
from io import BytesIO
from threading import RLock
from typing import TYPE_CHECKING, Any, Final, Literal

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure


NOTEBOOK_DPI: Final = 100
"""Resolution of a figure in a notebook [dots per inch]."""

FIRST: Final = "DejaVu Sans"
"""Comes with matplotlib: Latin, Greek, Cyrillic, Hebrew, Arabic, signs of mathematics."""

OTHERS: Final = (
    "Noto Sans CJK SC", "Noto Sans CJK JP", "Noto Sans CJK KR", "Source Han Sans SC",
    "WenQuanYi Zen Hei", "WenQuanYi Micro Hei", "Microsoft YaHei", "SimHei", "PingFang SC",
    "Hiragino Sans", "Yu Gothic", "IPAGothic", "Malgun Gothic", "NanumGothic",
    "Noto Sans Devanagari", "Noto Sans Thai", "Arial Unicode MS",
)  # fmt: skip
"""Fonts of common systems for what it lacks, tried in this order."""

COLOURS: Final = (
    "#0072b2", "#d55e00", "#009e73", "#cc79a7", "#e69f00", "#56b4e9", "#000000", "#767676",
    "#8a6d00", "#8b0000",
)  # fmt: skip
"""Okabe and Ito's colours for people of any colour vision; then two for controls and two for
the limits of tests."""

DASHES: Final = ("", "7 2", "2 2", "7 2 2 2", "4 4", "10 3", "", "5 3", "1 2", "12 2 2 2")
"""Dash of each colour, so that the lines differ in grey too [px]."""

SHADES: Final = (
    "#ffffff", "#eef3f8", "#d9e5f0", "#bcd2e6", "#8fb3d3", "#5d8fbd", "#2f6aa0", "#0e4374",
)  # fmt: skip
"""From little to much, ever darker: one hue, so that grey tells the same."""

CONTROL_STYLES: Final = (6, 7)
ALARM_STYLE: Final = 8
ABORT_STYLE: Final = 9
RESPONSE_STYLES: Final = (0, 1, 2, 3, 4, 5)


HEAD: Final = 0.45
"""Room for a title and a note [in]."""

LEGEND: Final = 0.27
"""Room for a legend of one or two rows [in]."""


@cache
def families() -> tuple[str, ...]:
    """Return the fonts of a picture, of those that are installed."""
    from matplotlib.font_manager import fontManager

    installed = {font.name for font in fontManager.ttflist}
    return (FIRST, *(name for name in OTHERS if name in installed))


def legible(text: str) -> str:
    r"""Return text in which a character that no font has is its code, such as ``\u4e2d``."""
    if text.isascii() and text.replace("\n", "").isprintable():
        return text
    return "".join(c if c == "\n" or _is_drawn(c) else _code(c) for c in text)


def write_legibly(picture: "Figure") -> None:
    """Write every text of a picture so that it can be drawn."""
    from matplotlib.text import Text

    for item in picture.findobj(Text):
        text = item.get_text()
        if (new := legible(text)) != text:
            item.set_text(new)


def _code(character: str) -> str:
    return character.encode("unicode_escape").decode()


@cache
def _is_drawn(character: str) -> bool:
    from matplotlib.font_manager import FontProperties, findfont, get_font

    if not character.isprintable():
        return False
    fonts = (get_font(findfont(FontProperties(family=name))) for name in families())
    return any(font.get_char_index(ord(character)) for font in fonts)


def styles(roles: Sequence[str]) -> list[int]:
    """Return the style of each channel: responses in colour, controls in black and grey."""
    counts = {"control": 0, "other": 0}
    chosen = []
    for role in roles:
        kind = "control" if role == "control" else "other"
        row = CONTROL_STYLES if kind == "control" else RESPONSE_STYLES
        chosen.append(row[counts[kind] % len(row)])
        counts[kind] += 1
    return chosen


def line(style: int) -> dict[str, Any]:
    """Return matplotlib's arguments for a line of this style."""
    style %= len(COLOURS)
    dash = DASHES[style]
    pattern = "-" if not dash else (0, tuple(float(n) for n in dash.split()))
    return {"color": COLOURS[style], "linestyle": pattern, "linewidth": 1.2}


_RAISED: Final = str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹")

_SETTINGS: Final = RLock()
"""Matplotlib's settings are those of the whole process: one thread changes them at a time."""


@contextmanager
def look() -> Iterator[None]:
    """Draw in the program's look, whatever the person's matplotlib settings."""
    import matplotlib as mpl
    from cycler import cycler

    with _SETTINGS, mpl.rc_context():
        mpl.rcdefaults()
        mpl.rcParams.update({
            "font.family": list(families()),
            "font.size": 9.0,
            "axes.titlesize": 10.0,
            "axes.titlelocation": "left",
            "axes.grid": True,
            "grid.color": "#dddddd",
            "grid.linewidth": 0.6,
            "axes.spines.top": False,
            "axes.spines.right": False,
            "axes.prop_cycle": cycler(color=COLOURS[:6]),
            "legend.frameon": False,
            "legend.fontsize": 8.0,
            "svg.hashsalt": "shakerproc",
            "path.simplify_threshold": 0.5,
            "agg.path.chunksize": 20000,
        })
        yield


def figure(
    width: float = 7.0,
    height: float = 3.6,
    rows: int = 1,
    *,
    sharex: bool = False,
    left: float | None = None,
    legend: bool = True,
) -> tuple["Figure", list["Axes"]]:
    """Return a figure and its axes, one above the other; call it inside `look`.

    With a left margin [in] all margins are fixed, which draws twice as fast, and there is room
    for a `head` and, if wanted, a `legend` above the axes; otherwise matplotlib finds room for
    every label.
    """
    if left is None:
        made = notebook_figure()(figsize=(width, height), layout="constrained")
        axes = made.subplots(rows, 1, sharex=sharex, squeeze=False)
    else:
        above = HEAD + (LEGEND if legend else 0.0)
        height += above
        made = notebook_figure()(figsize=(width, height))
        grid = {
            "left": left / width,
            "right": 1.0 - 0.15 / width,
            "bottom": 0.48 / height,
            "top": 1.0 - above / height,
            "hspace": 0.12 if sharex else 0.35,
        }
        axes = made.subplots(rows, 1, sharex=sharex, squeeze=False, gridspec_kw=grid)
    return made, [row[0] for row in axes]


def logarithmic(axis: "Axes", low: float, high: float) -> None:
    """Make the vertical axis logarithmic over whole decades, without minor ticks.

    `low` and `high` are in the unit of the axis.
    """
    from matplotlib.ticker import FuncFormatter, LogLocator, NullLocator

    axis.set_yscale("log")
    axis.set_ylim(low, high)
    axis.yaxis.set_major_locator(LogLocator(numticks=8))
    axis.yaxis.set_major_formatter(FuncFormatter(power_of_ten))
    axis.yaxis.set_minor_locator(NullLocator())


def plain_logarithmic(axis: "Axes", along: Literal["x", "y"]) -> None:
    """Make an axis logarithmic, with plain numbers at 1, 2 and 5 of each decade."""
    from matplotlib.ticker import FuncFormatter, LogLocator, NullLocator

    line = axis.xaxis if along == "x" else axis.yaxis
    (axis.set_xscale if along == "x" else axis.set_yscale)("log")
    line.set_major_locator(LogLocator(subs=(1.0, 2.0, 5.0)))
    line.set_major_formatter(FuncFormatter(lambda value, _: f"{value:g}"))
    line.set_minor_locator(NullLocator())


def power_of_ten(value: float, _: int | None = None) -> str:
    """Return a power of ten as text; matplotlib's own formulas take a third of a figure's time.

    `value` is in the unit of its axis.

    Examples
    --------
    >>> power_of_ten(1e-12)
    '10⁻¹²'
    """
    return "10" + str(round(math.log10(value))).translate(_RAISED)


def head(
    axis: "Axes", title: str, note: str = "", *, alarming: bool = False, legend: bool = True
) -> None:
    """Write a title above the axes and a note below it; a legend has room beneath."""
    points = 5.0 + (72.0 * LEGEND if legend else 0.0)
    axis.set_title(title, pad=points + 12.0, y=1.0)  # or every label is measured for it
    axis.annotate(
        note,
        (0.0, 1.0),
        xytext=(0.0, points),
        xycoords="axes fraction",
        textcoords="offset points",
        fontsize=8.5,
        color="#a62b00" if alarming else "#444444",
    )


def legend(axis: "Axes", width: float = 6.0) -> None:
    """Write the legend above the axes [in], where it hides nothing if it has room there."""
    lines, labels = axis.get_legend_handles_labels()
    widths = [0.45 + 0.06 * len(label) for label in labels]
    widest = max(widths, default=0.0)
    n_rows = 1 if widest * len(labels) <= width else 2
    columns = max(1, -(-len(labels) // n_rows))
    if widest * columns > n_rows * width:
        axis.legend(lines, labels, loc="best", fontsize=7.0)
        return
    axis.legend(
        lines,
        labels,
        ncols=columns,
        loc="lower left",
        bbox_to_anchor=(0.0, 1.0),
        borderaxespad=0.1,
        borderpad=0.1,
        labelspacing=0.1,
        fontsize=8.0 if n_rows == 1 else 6.5,
        handlelength=2.0,
        columnspacing=1.2,
    )


def name(axis: "Axes", name: str) -> None:
    """Write the name of a channel into its axes, where it has room whatever its length."""
    axis.annotate(
        name,
        (0.006, 0.93),
        xycoords="axes fraction",
        va="top",
        fontsize=8.0,
        bbox={"facecolor": "white", "edgecolor": "none", "alpha": 0.8, "pad": 1.0},
    )


@cache
def notebook_figure() -> "type[Figure]":
    """Return the class of figures that show themselves in a notebook without any set-up."""
    from matplotlib.figure import Figure

    class NotebookFigure(Figure):
        """A figure that is its own picture as the last line of a cell."""

        def _repr_png_(self) -> bytes:
            write_legibly(self)
            buffer = BytesIO()
            self.savefig(buffer, format="png", dpi=NOTEBOOK_DPI)
            return buffer.getvalue()

    return NotebookFigure
