"""Sections of a report: paragraphs, tables, figures with their captions."""

from collections.abc import Sequence
from dataclasses import dataclass

from markupsafe import Markup


@dataclass(frozen=True, slots=True)
class PageFigure:
    """A figure with its caption.

    Attributes
    ----------
    title, caption : str
        What it is, and what to look for.
    drawing : Markup
        The figure.
    kind : str
        Of the curves of a run, so that those of several can be overlaid.
    broad : bool
        Whether it takes the whole width.
    paper : bool
        Whether it is printed with the page.
    """

    title: str
    caption: str
    drawing: Markup
    kind: str = ""
    broad: bool = False
    paper: bool = True


@dataclass(frozen=True, slots=True)
class ReportTable:
    """A table of a further section: cells are text already."""

    caption: str
    columns: Sequence[str]
    rows: Sequence[Sequence[str]]


@dataclass(frozen=True, slots=True)
class ReportSection:
    """A further section of the report, such as the evidence of a diagnosis.

    Attributes
    ----------
    title, anchor : str
        Its heading, and what the navigation calls it.
    paragraphs, tables, figures, parts : sequence
        What it holds, in this order; parts are sections of their own.
    """

    title: str
    anchor: str
    paragraphs: Sequence[str] = ()
    tables: Sequence[ReportTable] = ()
    figures: Sequence[PageFigure] = ()
    parts: "Sequence[ReportSection]" = ()


def filled(caption: str, columns: Sequence[str], rows: Sequence[Sequence[str]]) -> ReportTable:
    """Return a table without the columns that hold nothing."""
    kept = [i for i, _ in enumerate(columns) if any(row[i] for row in rows)]
    return ReportTable(
        caption, [columns[i] for i in kept], [[row[i] for i in kept] for row in rows]
    )
