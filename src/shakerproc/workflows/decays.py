"""A model compared with free decays: what `shakerproc compare` does where nothing drives it."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any, final

from shakerproc import files
from shakerproc.comparison.decay_departures import (
    curve_columns,
    decay_rows,
    document_of_decays,
    sentence_of_decays,
    sentences_of,
)
from shakerproc.comparison.decays import DecayComparison as Compared
from shakerproc.comparison.decays import compare_decays
from shakerproc.errors import ArgumentError, DiagnosisError
from shakerproc.models import Model
from shakerproc.testlog import TestLog
from shakerproc.workflows.arguments import choice_of
from shakerproc.workflows.evidence import check_same
from shakerproc.workflows.shown import Shown, frame, html

if TYPE_CHECKING:
    from matplotlib.figure import Figure
    from pandas import DataFrame

    from shakerproc.comparison import Measured
    from shakerproc.report.evidence.decays import Decays


@final
@dataclass(frozen=True, slots=True, eq=False, repr=False)
class DecayComparison(Shown):
    """A model compared with free decays: frequency and damping against amplitude.

    Attributes
    ----------
    found : shakerproc.comparison.decays.DecayComparison
        Curves of every test and mode.
    before : shakerproc.comparison.decays.DecayComparison, optional
        Those of the older model.
    """

    found: Compared
    before: Compared | None = None

    @property
    def model(self) -> Model:
        """The model."""
        return self.found.model

    @property
    def measured(self) -> "tuple[Measured, ...]":
        """The tests."""
        return tuple(test.measured for test in self.found.tests)

    @property
    def sentence(self) -> str:
        """Where the model disagrees most, and which law it lacks."""
        return sentence_of_decays(self.found)

    @property
    def sentences(self) -> tuple[str, ...]:
        """The sentences of every mode."""
        return tuple(text for test in self.found.tests for text in sentences_of(test))

    @property
    def rows(self) -> list[dict[str, Any]]:
        """Measured less model at both ends of the curves: a row for each mode."""
        return decay_rows(self.found)

    def to_pandas(self) -> "DataFrame":
        """Return the curves: a row for each reading, as decay_curves.csv."""
        return frame(curve_columns(self.found))

    def as_json(self) -> dict[str, Any]:
        """Return the comparison as compare.json holds it."""
        return document_of_decays(self.found)

    @property
    def drawn(self) -> "Decays":
        """The content of the report's figures."""
        from shakerproc.report.evidence.decays import Decays

        return Decays(self.found, self.before)

    @property
    def figures(self) -> tuple[str, ...]:
        """Names of the figures that `plot` draws."""
        from shakerproc.report.evidence.decays import panels_of

        return tuple(panels_of(self.drawn))

    def plot(self, figure: str = "") -> "Figure":
        """Return a figure of the comparison.

        Parameters
        ----------
        figure : str
            One of `figures`; by default the frequency of the first mode.

        Raises
        ------
        ArgumentError
            If there is no such figure.
        """
        from shakerproc.report.evidence.decays import panels_of
        from shakerproc.report.figures import style
        from shakerproc.report.runs.analyses import draw_panel

        known = panels_of(self.drawn)
        if not known:
            raise ArgumentError("figure", "no mode has a curve")
        test, panel = known[choice_of("figure", figure, known, "a figure")]
        with style.look():
            return draw_panel(panel, f"test {test}", {})

    def write(
        self,
        folder: Path,
        title: str,
        command: str,
        inputs: Sequence[tuple[str, str, str]],
        *,
        figures: bool,
    ) -> Path:
        """Write tables, figures and the page; return the page."""
        from shakerproc.report.evidence.decays import decay_report, draw_decays
        from shakerproc.report.page.page import write_report

        rows = self.rows
        table = {name: [row[name] for row in rows] for name in rows[0]}
        files.write_csv(folder / "decay_differences.csv", table)
        files.write_csv(folder / "decay_curves.csv", curve_columns(self.found))
        if figures:
            draw_decays(self.drawn, folder)
        page = folder / "report.html"
        write_report(page, decay_report(self.drawn, title, command, inputs))
        return page

    def _repr_html_(self) -> str:
        table = frame({name: [row[name] for row in self.rows] for name in self.rows[0]})
        notes = (note for test in self.measured for note in test.notes)
        told = [*self.sentences, *self.found.left_out, *notes]
        return html(f"{self.model.title}, decays compared", told, table.drop(columns="said"))


def compare_free_decays(
    model: Model,
    log: TestLog,
    *,
    before: Model | None = None,
    fit: bool = False,
    tell: Callable[[str], None] = lambda _text: None,
    warn: Callable[[str], None] = lambda _text: None,
) -> DecayComparison:
    """Return a comparison of decays, told of what is going on and of faulty channels.

    Raises
    ------
    DiagnosisError
        If a fit is asked for, or the older model is driven by something.
    """
    if fit:
        raise DiagnosisError(
            f"{model.title}: nothing drives the model, and compare fits no numbers to free "
            "decays; take `shakerproc add` or `diagnose`, which do"
        )
    if before is not None and before.excitation.role is not None:
        raise DiagnosisError(
            f"{before.title}: something drives the older model, and nothing the new one; give "
            "both excitation: {free: decay}"
        )
    found = compare_decays(model, log, tell=tell, warn=warn)
    if before is None:
        return DecayComparison(found)
    old = compare_decays(before, log, tell=tell)
    if before.sensors.keys() != model.sensors.keys():
        raise DiagnosisError(
            f"{before.title} and {model.title} have not the same sensors; curves of decays are "
            "overlaid sensor by sensor"
        )
    check_same(*([test.measured for test in one.tests] for one in (old, found)))
    return DecayComparison(found, old)
