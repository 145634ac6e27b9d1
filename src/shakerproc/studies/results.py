"""Results of a study: tables, panels that any program can draw, checks with a tolerance.

A verdict is the outcome of checks and of nothing else. What a study file says in words (its
statement, its comment) is a caption.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Final, Literal, TypeAlias, final

import numpy as np
from numpy.typing import NDArray

from shakerproc.data import FloatArray

Trend: TypeAlias = Literal["falls", "rises", "changes"]
Relation: TypeAlias = Literal["equals", "above", "below"]
Verdict: TypeAlias = Literal["held", "held in part", "did not hold", "not checked"]

VERDICTS: Final[tuple[Verdict, ...]] = ("held", "held in part", "did not hold", "not checked")
MOST_SHOWN: Final = 12
"""Values of a quantity that a sentence lists; of more it gives the range."""

_WORDS: Final = {
    "neither": "goes up and down",
    "stays": "stays the same",
    "falls": "falls",
    "rises": "rises",
    "unknown": "is not known everywhere",
}


@final
@dataclass(frozen=True, slots=True)
class Check:
    """Condition on a quantity.

    Attributes
    ----------
    quantity : str
        Its name, unit at the end.
    relation : str
        ``equals``, ``above`` or ``below`` a bound in every case; ``falls``, ``rises`` or
        ``changes`` with a parameter.
    bound : float
        Value to compare with, in the SI unit of the quantity.
    within : float, optional
        How far an equal value may lie from the bound, or a trend stray: a share of the bound
        where `relative`, else in the unit of the quantity; by default a trend may stray by
        the resolution of the quantity.
    relative : bool
        Whether `within` is a share.
    along : str
        Name of the parameter of a trend.
    """

    quantity: str
    relation: Relation | Trend
    bound: float = float("nan")
    within: float | None = None
    relative: bool = False
    along: str = ""


@final
@dataclass(frozen=True, slots=True)
class Checked:
    """A check and its outcome.

    Attributes
    ----------
    quantity : str
        Name, with its unit.
    values : tuple of float
        What was found, in the order of the cases.
    found : str
        The same for people: the trend, the numbers.
    wanted : str
        What was wanted of it, with the tolerance.
    passed, of : int
        In how many cases, or groups of them, it came true.
    """

    quantity: str
    values: tuple[float, ...]
    found: str
    wanted: str
    passed: int
    of: int

    @property
    def held(self) -> bool:
        """Whether it came true everywhere."""
        return 0 < self.of == self.passed

    def __str__(self) -> str:
        """Return the quantity, its values, the expectation and how often it was met."""
        often = f", so in {self.passed} of {self.of}" if 0 < self.passed < self.of else ""
        return f"{self.quantity} {self.found} (wanted: {self.wanted}{often})"


def verdict_of(checks: Sequence[Checked]) -> Verdict:
    """Return the verdict of checks: all, some or none of their cases came true."""
    if not sum(check.of for check in checks):
        return "not checked"
    passed = sum(check.passed for check in checks)
    if all(check.held for check in checks):
        return "held"
    return "held in part" if passed else "did not hold"


def sentence_of(checks: Sequence[Checked]) -> str:
    """Return the verdict with every check behind it, for people."""
    verdict = verdict_of(checks)
    if not checks:
        return verdict
    return f"{verdict}: {'; '.join(str(check) for check in checks)}"


def equals(
    quantity: str,
    values: Sequence[float] | FloatArray | float,
    bound: float,
    within: float,
    *,
    relative: bool = False,
) -> Checked:
    """Return whether values lie within a tolerance of a bound.

    Parameters
    ----------
    quantity : str
        Name with unit.
    values : float or (n,) array
        What was found [any unit].
    bound, within : float
        What was wanted, and how far from it a value may lie [unit of the values].
    relative : bool
        Whether the tolerance is a share of the bound.
    """
    quantities = np.atleast_1d(np.asarray(values, np.float64))
    far = within * abs(bound) if relative else within
    text = f"{100.0 * within:.3g} %" if relative else f"{within:.3g}"
    near = np.abs(quantities - bound) <= far
    return _bounded(quantity, quantities, near, f"{bound:.6g} within {text}")


def above(quantity: str, values: Sequence[float] | FloatArray | float, bound: float) -> Checked:
    """Return whether values lie above a bound. Both are in the same unit."""
    quantities = np.atleast_1d(np.asarray(values, np.float64))
    return _bounded(quantity, quantities, quantities > bound, f"above {bound:.6g}")


def below(quantity: str, values: Sequence[float] | FloatArray | float, bound: float) -> Checked:
    """Return whether values lie below a bound. Both are in the same unit."""
    quantities = np.atleast_1d(np.asarray(values, np.float64))
    return _bounded(quantity, quantities, quantities < bound, f"below {bound:.6g}")


def trends(
    quantity: str,
    groups: Sequence[tuple[FloatArray, FloatArray, FloatArray]],
    wanted: Trend,
    along: str,
) -> Checked:
    """Return whether a quantity falls, rises or changes with a parameter in every group.

    Parameters
    ----------
    quantity : str
        Name with unit.
    groups : sequence of three (n,) arrays
        Parameter, quantity and its resolution, of cases that differ in this parameter alone
        [any unit].
    wanted : str
        ``falls``, ``rises`` or ``changes``.
    along : str
        Name of the parameter.
    """
    directions = [trend_of(x, y, slack) for x, y, slack in groups]
    changed = {"falls", "rises", "neither"}
    passed = sum(one in changed if wanted == "changes" else one == wanted for one in directions)
    slack = max((float(np.max(one[2])) for one in groups), default=0.0)
    ordered = [y[np.argsort(x, kind="stable")] for x, y, _ in groups]
    if all(one in {"falls", "rises"} for one in directions):
        numbers = "; ".join(f"{y[0]:.4g} to {y[-1]:.4g}" for y in ordered)
    else:
        numbers = "; ".join(shown(y.tolist()) for y in ordered)
    words = " or ".join(_WORDS[one] for one in sorted(set(directions)))
    return Checked(
        quantity,
        tuple(float(value) for y in ordered for value in y),
        f"{words} with {along}, {numbers}",
        f"{wanted} with {along}, tolerance {slack:.3g}",
        passed,
        len(groups),
    )


def trend_of(x: FloatArray, y: FloatArray, slack: FloatArray | float) -> str:
    """Return how a quantity changes: ``falls``, ``rises``, ``neither``, ``stays``, ``unknown``.

    Parameters
    ----------
    x, y : (n,) array
        Parameter and quantity [any unit].
    slack : float or (n,) array
        Resolution of the quantity: what a step the other way may amount to, and what the
        change in all must exceed [unit of the quantity].
    """
    order = np.argsort(x, kind="stable")
    values, room = y[order], np.broadcast_to(slack, y.shape)[order]
    if not np.all(np.isfinite(values)) or values.size < 2:
        return "unknown"
    change, may = np.diff(values), np.maximum(room[1:], room[:-1])
    total, least = float(values[-1] - values[0]), float(max(room[0], room[-1]))
    if np.ptp(values) <= float(np.max(room)):
        return "stays"
    if np.all(change <= may) and total < -least:
        return "falls"
    if np.all(change >= -may) and total > least:
        return "rises"
    return "neither"


def shown(values: Sequence[float]) -> str:
    """Return values for a sentence; of many only the range. `values` may be in any unit."""
    if len(values) <= MOST_SHOWN:
        return ", ".join(f"{value:.4g}" for value in values)
    known = [value for value in values if np.isfinite(value)]
    if not known:
        return "no value"
    return f"{min(known):.4g} to {max(known):.4g}"


def _bounded(
    quantity: str, quantities: FloatArray, true: NDArray[np.bool_], wanted: str
) -> Checked:
    values = tuple(float(value) for value in quantities)
    passed = int(np.count_nonzero(true))
    return Checked(quantity, values, shown(values), wanted, passed, quantities.size)


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
