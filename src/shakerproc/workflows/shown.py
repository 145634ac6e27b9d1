"""How results show themselves in a notebook: a heading, sentences, tables."""

import re
from abc import ABC, abstractmethod
from collections.abc import Mapping, Sequence
from html import escape, unescape
from typing import TYPE_CHECKING, Any, Final

from shakerproc.numerals import numeral

if TYPE_CHECKING:
    from pandas import DataFrame

    from shakerproc.diagnosis.result import Errors

MOST_ROWS: Final = 20
"""Rows of a table that a notebook shows."""


class Shown(ABC):
    """A result that shows itself: as HTML in a notebook, without tables in a terminal."""

    __slots__ = ()

    @abstractmethod
    def _repr_html_(self) -> str:
        """Return its summary as HTML."""

    def __repr__(self) -> str:
        lines = self._repr_html_().splitlines()
        said = [line for line in lines if line.startswith(("<h4>", "<p>"))]
        return "\n".join(unescape(re.sub(r"<[^>]+>", "", line)) for line in said)


def frame(columns: Mapping[str, Any]) -> "DataFrame":
    """Return a table of columns of equal length."""
    from pandas import DataFrame

    return DataFrame(dict(columns))


def frame_of_rows(names: Sequence[str], rows: Sequence[Sequence[object]]) -> "DataFrame":
    """Return a table of rows."""
    from pandas import DataFrame

    return DataFrame([tuple(row) for row in rows], columns=list(names))


def frame_of_errors(errors: "Errors") -> "DataFrame":
    """Return the free-run errors before and after, fitted and held out, and the floor [-]."""
    rows = [
        ("before", errors.fitted.before, errors.held_out.before),
        ("after", errors.fitted.after, errors.held_out.after),
        ("noise floor", None, errors.noise_floor),
    ]
    return frame_of_rows(("error", "fitted", "held_out"), rows)


def html(heading: str, sentences: Sequence[str] = (), *tables: "DataFrame") -> str:
    """Return a heading, sentences and tables as HTML; whatever they hold is text in it."""
    parts = [f"<h4>{escape(heading)}</h4>"]
    parts += [f"<p>{escape(text)}</p>" for text in sentences if text]
    for table in tables:
        shown = table.head(MOST_ROWS)
        parts.append(
            shown.to_html(
                index=False, border=0, na_rep="", float_format=lambda x: numeral(x, 4)
            )
        )
        if len(table) > MOST_ROWS:
            parts.append(f"<p>{len(table) - MOST_ROWS} more rows</p>")
    return "\n".join(parts)
