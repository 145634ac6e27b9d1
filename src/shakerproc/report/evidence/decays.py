"""Free decays of a model beside those measured, drawn and as a page."""

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Final, final

from shakerproc.comparison.decay_departures import (
    decay_rows,
    sentence_of_decays,
    sentences_of,
    unit_of,
)
from shakerproc.comparison.decays import DecayComparison, ModeDecay, TestDecays
from shakerproc.numerals import numeral
from shakerproc.report.figures import style
from shakerproc.report.figures.to_png import save
from shakerproc.report.figures.units import read_unit
from shakerproc.report.page import methods
from shakerproc.report.page.page import Report
from shakerproc.report.page.sections import ReportSection, ReportTable, filled
from shakerproc.report.runs.analyses import draw_panel, drawing
from shakerproc.runs.analyses.decays import Amplitude, Curve, decay_panels
from shakerproc.runs.analysis import Panel

MODEL_STYLES: Final = (3, 2)
"""Styles of the curves of the model and of the older one."""

CAPTION: Final = (
    "Measured by two methods, grey their 95 % limits; the model after a start fitted to "
    "the first periods, read by least squares as the measurement is."
)


@final
@dataclass(frozen=True, slots=True, eq=False)
class Decays:
    """A model compared with free decays, and an older one if there is any.

    Attributes
    ----------
    found : DecayComparison
        With the model.
    before : DecayComparison, optional
        With the older one, against the same tests.
    """

    found: DecayComparison
    before: DecayComparison | None = None

    @property
    def names(self) -> tuple[str, str]:
        """Names of the model and the older one, distinct."""
        new = self.found.model.title
        old = "" if self.before is None else self.before.model.title
        return (new, old) if new != old else ("new model", "old model")


def panels_of(decays: Decays) -> dict[str, tuple[str, Panel]]:
    """Return the test and the panel of every figure, by the name of its file."""
    panels = {}
    for i, test in enumerate(decays.found.tests):
        for k, mode in enumerate(test.modes):
            if not mode.measured.fitted:
                continue
            older = None if decays.before is None else decays.before.tests[i].modes[k]
            for panel in _panels(decays, test, mode, older):
                panels[panel.name] = (test.measured.name, panel)
    return panels


def _panels(
    decays: Decays, test: TestDecays, mode: ModeDecay, older: ModeDecay | None
) -> list[Panel]:
    sensor = test.measured.sensors[mode.sensor]
    unit, factor = read_unit(unit_of(decays.found, sensor))
    curves: list[Curve] = [
        ("measured, least squares", 0, mode.measured.fitted),
        ("measured, peaks and crossings", 1, mode.measured.charted),
    ]
    for name, one, look in zip(decays.names, (mode, older), MODEL_STYLES, strict=True):
        if one is not None and one.model is not None and one.model.fitted:
            curves.append((name, look, one.model.fitted))
    return decay_panels(
        f"decay_{test.measured.name}_{mode.number}",
        f"mode {mode.number}, {numeral(mode.measured.line.frequency, 4)} Hz",
        CAPTION,
        Amplitude(sensor, unit, factor),
        curves,
        limited=2,
    )


def draw_decays(decays: Decays, folder: Path) -> list[Path]:
    """Draw every figure of a comparison of decays, and return the files."""
    written = []
    for name, (test, panel) in panels_of(decays).items():
        with style.look():
            figure = draw_panel(panel, f"test {test}", {})
        written.append(save(figure, folder / f"{name}.png"))
    return written


def decay_report(
    decays: Decays, title: str, command: str, inputs: Sequence[tuple[str, str, str]]
) -> Report:
    """Return the page of a comparison of decays."""
    return Report(
        title,
        [],
        command=command,
        verdict=sentence_of_decays(decays.found),
        sections=decay_sections(decays),
        inputs=inputs,
        methods=methods.methods_of(
            [],
            analyses=["decays"],
            kinds=[element.effect.kind for element in decays.found.model.elements],
        ),
    )


def decay_sections(decays: Decays) -> list[ReportSection]:
    """Return a section for each test."""
    return [_section(decays, i) for i in range(len(decays.found.tests))]


def _section(decays: Decays, index: int) -> ReportSection:
    test = decays.found.tests[index]
    name = test.measured.name
    told = [f"{text[0].upper()}{text[1:].removesuffix('.')}." for text in sentences_of(test)]
    if decays.before is not None:
        old = decays.names[1]
        told += [f"{old}: {text}" for text in sentences_of(decays.before.tests[index])]
    if index == 0:
        told += [f"{text.removesuffix('.')}." for text in decays.found.left_out]
    told += [f"{text.removesuffix('.')}." for text in test.measured.notes]
    rows = [row for row in decay_rows(decays.found) if row["test"] == name]
    return ReportSection(
        f"Test {name}: frequency and damping against amplitude",
        f"decay_{index + 1}",
        told,
        [_table(rows)],
        [
            drawing(panel, f"{panel.title} of test {owner}", {})
            for owner, panel in panels_of(decays).values()
            if owner == name
        ],
    )


def _table(rows: Sequence[dict[str, Any]]) -> ReportTable:
    shown = {
        "mode": "mode", "sensor": "sensor", "largest_amplitude": "amplitude from",
        "smallest_amplitude": "to", "unit": "unit",
        "frequency_difference_at_largest_percent": "frequency, measured less model [%]",
        "frequency_difference_at_smallest_percent": "at the smallest [%]",
        "damping_difference_at_largest_percent": "damping, measured less model [% of critical]",
        "damping_difference_at_smallest_percent": "at the smallest [% of critical]",
        "outside_percent": "stretches outside [%]",
    }  # fmt: skip
    cells = [[_cell(row[key]) for key in shown] for row in rows]
    return filled("Measured less model at both ends of each curve", list(shown.values()), cells)


def _cell(value: Any) -> str:
    if value is None:
        return ""
    return numeral(value, 4) if isinstance(value, float) else str(value)
