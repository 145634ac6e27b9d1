"""Expanded uncertainty of every level, peak and damping of a run, as budgets of the GUM."""

from collections.abc import Iterator, Sequence
from typing import ClassVar, Final, final

from shakerproc.data import Recording
from shakerproc.runs.analyses import AbstractAnalysis
from shakerproc.runs.analysis import Analysis, Cell
from shakerproc.runs.budget import COVERAGE, GROUPS, NO_SHEET, Budget, is_random
from shakerproc.runs.budgets import budgets_of
from shakerproc.runs.result import RunResult

_TOLD: Final = (
    "Expanded is k = 2 times the root of the sum of squares of the standard uncertainties in "
    "the last columns, some 95 % (JCGM 100:2008).",
    "Calibration: the sheet's expanded uncertainty over 2, twice that for a density, that of "
    "both channels for a response function.",
    "Resolution: half a bin of a frequency; of a height what the window smears, which is not "
    "corrected, and half a bin beside the top.",
    "Random: scatter of the averages, which of the tallest bins is taken, and the 95 % "
    "interval of a fit over 1.96.",
    "Noise: the quiet part of the recording; of a response function, H2 less H1. Limits are "
    "rectangular laws, over the root of 3.",
    "Not included, for nothing states them: the recorder's clock, transverse sensitivity, "
    "temperature, mounting, and how far a second run differs.",
)


@final
class UncertaintyAnalysis(AbstractAnalysis):
    """Uncertainty of every reported number."""

    kind: ClassVar[str] = "uncertainty"

    def of(self, recording: Recording, result: RunResult) -> Analysis | None:
        """Return the budgets of a run; None where they are not asked for."""
        if not result.test.processing.uncertainty:
            return None
        budgets = tuple(budgets_of(recording, result))
        rows = [row for budget in budgets for row in _lines(budget)]
        return Analysis(
            kind=self.kind,
            title="Measurement uncertainty, k = 2",
            columns={name: [row[name] for row in rows] for name in (rows[0] if rows else ())},
            summary=tuple(_row(budget) for budget in budgets),
            panels=(),
            told=(*_TOLD, *_not_known(result, budgets)),
        )


def _row(budget: Budget) -> dict[str, Cell]:
    """Return a number with its expanded uncertainty, and what it is made of."""
    known, expanded = budget.standard() is not None, budget.expanded
    row: dict[str, Cell] = {
        "channel": budget.channel,
        "quantity": budget.quantity,
        "peak_hz": budget.at,
        "value": budget.value,
        "expanded": None if budget.missing else expanded,
        "unit": budget.unit,
        "expanded_percent": None if budget.missing else budget.share(expanded),
        "at_least_percent": budget.share(expanded) if budget.missing and known else None,
        "not_known": ", ".join(budget.missing) or None,
    }
    shares = {f"{group}_percent": budget.share(budget.standard(group)) for group in GROUPS}
    return row | shares


def _lines(budget: Budget) -> Iterator[dict[str, Cell]]:
    """Yield the lines of a budget, their sum, and the expanded uncertainty."""
    head: dict[str, Cell] = {
        "channel": budget.channel, "quantity": budget.quantity, "peak_hz": budget.at,
        "value": budget.value, "unit": budget.unit,
    }  # fmt: skip
    for line in budget.lines:
        known = line.given is not None
        yield head | {
            "contribution": line.group,
            "given": line.given,
            "distribution": line.distribution if known else "not known",
            "divisor": line.divisor if known else None,
            "standard_uncertainty": line.standard,
            "standard_uncertainty_percent": budget.share(line.standard),
            "source": line.source,
        }
    of = (
        f"of what is known: {', '.join(budget.missing)} missing" if budget.missing else "of all"
    )
    for name, value in (
        ("combined", budget.standard()),
        (f"expanded (k = {COVERAGE:g})", budget.expanded),
    ):
        yield head | {
            "contribution": name,
            "given": None,
            "distribution": "normal",
            "divisor": None,
            "standard_uncertainty": value,
            "standard_uncertainty_percent": budget.share(value),
            "source": of,
        }


def _not_known(result: RunResult, budgets: Sequence[Budget]) -> Iterator[str]:
    """Yield each reason why a contribution is not known, once, with what it concerns."""
    told: dict[tuple[str, str], dict[str, None]] = {}
    for budget in budgets:
        for line in budget.lines:
            if line.given is None and line.group != "calibration":
                told.setdefault((line.group, line.source), {})[budget.channel] = None
    if any(result.psd_peaks) and not is_random(result):
        yield (
            "Peaks of densities have no budget: the run is no random vibration, and nothing "
            "tells their scatter."
        )
    bare = [channel.name for channel in result.channels if channel.uncertainty is None]
    if bare:
        told = {("calibration", NO_SHEET): dict.fromkeys(bare)} | told
    for (group, reason), names in told.items():
        yield f"Not known and not taken as zero: {group} of {', '.join(names)}, {reason}."
