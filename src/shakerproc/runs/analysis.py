"""Result of a further analysis of a run: a table, a summary, figures, sentences."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, Literal, TypeAlias, final

from shakerproc.data import FloatArray

Cell: TypeAlias = str | float | bool | None

Look: TypeAlias = Literal["curve", "alarm", "abort", "demand", "paper"]
"""What a line is: a result of a channel, a limit, what is demanded, a line of the paper."""


@final
@dataclass(frozen=True, slots=True, eq=False)
class PanelLine:
    """One line of a figure.

    Attributes
    ----------
    label : str
        Name in the legend; empty for a line that needs none.
    x, y : (n,) arrays
        Points, in the units of the axes; not a number breaks the line.
    channel : str
        Whose it is, so that a channel has one colour everywhere; empty for a limit.
    look : Look
        What it is.
    style : int
        Colour and dash of a line that is no channel's.
    """

    label: str
    x: FloatArray
    y: FloatArray
    channel: str = ""
    look: Look = "curve"
    style: int = 0


@final
@dataclass(frozen=True, slots=True)
class PanelScale:
    """An axis: its label with the unit, whether it is logarithmic, and its ends if fixed."""

    label: str
    logarithmic: bool = True
    ends: tuple[float, float] | None = None


@final
@dataclass(frozen=True, slots=True, eq=False)
class Panel:
    """One figure.

    Attributes
    ----------
    name : str
        Name of its file, such as ``shock_maximax``.
    title, caption : str
        What it is, and what to look for.
    x, y : PanelScale
        Axes.
    lines : tuple of PanelLine
        What is drawn.
    equal : bool
        Whether a unit is as long along one axis as along the other, both being linear.
    """

    name: str
    title: str
    caption: str
    x: PanelScale
    y: PanelScale
    lines: tuple[PanelLine, ...]
    equal: bool = False


@final
@dataclass(frozen=True, slots=True, eq=False)
class Analysis:
    """Result of one further analysis of a run.

    Attributes
    ----------
    kind : str
        Key in the log and name of its table.
    title : str
        For people.
    columns : mapping
        The whole table, columns of equal length by header with units.
    summary : tuple of mapping
        A few rows for the report, the terminal and the table of the batch, by header.
    panels : tuple of Panel
        Figures.
    told : tuple of str
        Sentences for people.
    problems : tuple of str
        What is odd or not kept, a sentence each: flags of the run.
    """

    kind: str
    title: str
    columns: Mapping[str, Any]
    summary: tuple[Mapping[str, Cell], ...]
    panels: tuple[Panel, ...]
    told: tuple[str, ...] = ()
    problems: tuple[str, ...] = ()
