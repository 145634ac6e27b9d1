"""Results of a study: tables, and panels that any drawing program can draw."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Literal, TypeAlias, final

import numpy as np
from numpy.typing import NDArray

from shakerproc.data import FloatArray
from shakerproc.studies.checks import Checked, Verdict, sentence_of, verdict_of

Columns: TypeAlias = Mapping[str, NDArray[np.generic]]


@final
@dataclass(frozen=True, slots=True, eq=False)
class StudyLine:
    """One line, or one cloud of points.

    Attributes
    ----------
    x, y : (n,) array
        Where it runs.
    label : str
        Its name in the legend; empty for none.
    look : str
        ``line``, ``dashed``, ``dotted``, ``marked`` (with a sign at each point) or ``points``.
    style : int
        Number of the colour.
    """

    x: FloatArray
    y: FloatArray
    label: str = ""
    look: Literal["line", "dashed", "dotted", "marked", "points"] = "line"
    style: int = 0


@final
@dataclass(frozen=True, slots=True, eq=False)
class StudyImage:
    """A density over two axes.

    Attributes
    ----------
    x : (n_x,) array
        Values along.
    y : (n_y,) array
        Values up.
    values : (n_y, n_x) array
        Density, drawn in decibels.
    """

    x: FloatArray
    y: FloatArray
    values: FloatArray


@final
@dataclass(frozen=True, slots=True, eq=False)
class StudyPanel:
    """One pair of axes.

    Attributes
    ----------
    x_label, y_label : str
        Names with units.
    lines : tuple of StudyLine
        What is drawn.
    title : str
        Headline; empty for none.
    log_x, log_y : bool
        Whether an axis is logarithmic.
    image : StudyImage, optional
        What lies under the lines.
    square : bool
        Whether the panel is about as high as wide.
    """

    x_label: str
    y_label: str
    lines: tuple[StudyLine, ...]
    title: str = ""
    log_x: bool = False
    log_y: bool = False
    image: StudyImage | None = None
    square: bool = False


@final
@dataclass(frozen=True, slots=True, eq=False)
class StudyResult:
    """Tables and panels of a study.

    Attributes
    ----------
    title : str
        Headline.
    figure : str
        Figure of the thesis; empty for none.
    columns : mapping of str to (n,) array
        The table, units in the names.
    panels : tuple of StudyPanel
        The figure.
    method : str
        How the numbers came about: estimator, bin width, direction, severity.
    quantities : mapping of str to (n,) array
        What checks are made of, a row for each combination, units in the names.
    statement : str
        What was stated; empty without a claim.
    checks : tuple of Checked
        The outcome of every check of the statement.
    comment : str
        What the study file says beside its checks: a caption, never a verdict.
    notes : tuple of str
        What is to be known of single numbers.
    """

    title: str
    figure: str
    columns: Columns
    panels: tuple[StudyPanel, ...]
    method: str
    quantities: Columns = field(default_factory=dict)
    statement: str = ""
    checks: tuple[Checked, ...] = ()
    comment: str = ""
    notes: tuple[str, ...] = ()

    @property
    def outcome(self) -> Verdict:
        """Outcome of the checks; ``not checked`` where there are none."""
        return verdict_of(self.checks)

    @property
    def verdict(self) -> str:
        """The outcome with every check behind it, for people."""
        return sentence_of(self.checks)
