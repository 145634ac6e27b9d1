"""A model compared with tests of a log or with response functions: `shakerproc compare`."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final, final

from shakerproc import __version__, files
from shakerproc.comparison import (
    COLUMNS,
    Comparison,
    compare_tests,
    document_of,
    rows_of,
    scored_alike,
    sentence,
    usable_tests,
)
from shakerproc.comparison.decays import (
    DecayComparison,
    compare_decays,
    curve_columns,
    decay_rows,
    document_of_decays,
    sentence_of_decays,
    sentences_of,
)
from shakerproc.comparison.document import mode_tables, modes_document
from shakerproc.comparison.modes import ComparedModes, compared_modes
from shakerproc.comparison.response_functions import FunctionComparison, compare_functions
from shakerproc.errors import ArgumentError, DiagnosisError, ShakerprocError
from shakerproc.models import Model
from shakerproc.numerals import numeral
from shakerproc.recordings.response_functions import read_functions
from shakerproc.report.evidence.functions import function_report
from shakerproc.report.page.page import write_report
from shakerproc.testlog import Modal, TestLog
from shakerproc.workflows.arguments import choice_of, log_of, model_of, pairs, switch_of
from shakerproc.workflows.evidence import check_same
from shakerproc.workflows.shown import Shown, frame, frame_of_rows, html

if TYPE_CHECKING:
    from matplotlib.figure import Figure
    from pandas import DataFrame

    from shakerproc.comparison import Measured
    from shakerproc.report.evidence.functions import Decays


@final
@dataclass(frozen=True, slots=True, eq=False, repr=False)
class ShownDecayComparison(Shown):
    """A model compared with free decays: frequency and damping against amplitude.

    Attributes
    ----------
    found : shakerproc.comparison.decays.DecayComparison
        Curves of every test and mode.
    before : shakerproc.comparison.decays.DecayComparison, optional
        Those of the older model.
    """

    found: DecayComparison
    before: DecayComparison | None = None

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
        from shakerproc.report.evidence.functions import Decays

        return Decays(self.found, self.before)

    @property
    def figures(self) -> tuple[str, ...]:
        """Names of the figures that `plot` draws."""
        from shakerproc.report.evidence.functions import panels_of

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
        from shakerproc.report.evidence.functions import panels_of
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
        from shakerproc.report.evidence.functions import decay_report, draw_decays
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
        sentences = [*self.sentences, *self.found.left_out, *notes]
        return html(
            f"{self.model.title}, decays compared", sentences, table.drop(columns="said")
        )


def compare_free_decays(
    model: Model,
    log: TestLog,
    *,
    before: Model | None = None,
    fit: bool = False,
    tell: Callable[[str], None] = lambda _text: None,
    warn: Callable[[str], None] = lambda _text: None,
) -> ShownDecayComparison:
    """Return a comparison of decays, with callbacks for progress and faulty channels.

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
    comparison = compare_decays(model, log, tell=tell, warn=warn)
    if before is None:
        return ShownDecayComparison(comparison)
    old = compare_decays(before, log, tell=tell)
    if before.sensors.keys() != model.sensors.keys():
        raise DiagnosisError(
            f"{before.title} and {model.title} have not the same sensors; curves of decays are "
            "overlaid sensor by sensor"
        )
    check_same(*([test.measured for test in one.tests] for one in (old, comparison)))
    return ShownDecayComparison(comparison, old)


@final
@dataclass(frozen=True, slots=True, eq=False, repr=False)
class ShownComparison(Shown):
    """A model compared with every test of a log: where, and by how much, they disagree.

    Attributes
    ----------
    found : shakerproc.comparison.Comparison
        Arrays and errors of every test.
    before : shakerproc.comparison.Comparison, optional
        The older model, or the model before it was fitted, scored alike.
    modes : ComparedModes, optional
        Modes of the gentlest test beside those of the model, where it has several coordinates.
    """

    found: Comparison
    before: Comparison | None = None
    modes: ComparedModes | None = None

    @property
    def model(self) -> Model:
        """The model; with its numbers as fitted, where that was asked."""
        return self.found.model

    @property
    def error(self) -> float:
        """The free-run error over all tests, as a share of the measured response [-]."""
        return self.found.error

    @property
    def held_out_error(self) -> float | None:
        """Error over the held-out tests; None where nothing is held out [-]."""
        return self.found.held_out

    @property
    def noise_floor(self) -> float:
        """Error of the true model; NaN where the noise is unknown [-]."""
        return self.found.noise

    @property
    def sentence(self) -> str:
        """Where the model fails, in words."""
        return sentence(self.found)

    def to_pandas(self) -> "DataFrame":
        """Return the errors: a row for each sensor of each test, as errors.csv."""
        return frame_of_rows(COLUMNS, rows_of(self.found))

    @property
    def fitted(self) -> "DataFrame":
        """The fitted numbers with 95 % intervals; empty where nothing was fitted."""
        refit = self.found.refit
        rows = [] if refit is None else [
            (p.kind, " - ".join(p.between), p.name, p.before, p.value, p.low, p.high, p.unit)
            for p in refit.parameters
        ]  # fmt: skip
        names = ("element", "between", "number", "before", "fitted", "low", "high", "unit")
        return frame_of_rows(names, rows)

    def as_json(self) -> dict[str, Any]:
        """Return the comparison as compare.json holds it."""
        modes = {} if self.modes is None else {"modes": modes_document(self.modes)}
        return {**document_of(self.found), **modes}

    @property
    def figures(self) -> tuple[str, ...]:
        """Names of the figures that `plot` draws."""
        from shakerproc.report.evidence.comparison import figures_of

        return tuple(figures_of(self.found))

    def plot(self, figure: str = "") -> "Figure":
        """Return a figure of the comparison.

        Parameters
        ----------
        figure : str
            One of `figures`; by default the response function of the first sensor.

        Raises
        ------
        ArgumentError
            If there is no such figure.
        """
        from shakerproc.report.evidence.comparison import figures_of
        from shakerproc.report.figures import style

        known = figures_of(self.found)
        with style.look():
            return known[choice_of("figure", figure, known, "a figure")]()

    def _repr_html_(self) -> str:
        errors = self.to_pandas()[["test", "level", "held_out", "sensor", "error", "noise"]]
        sentences = [self.sentence, *self.found.left_out, *self.found.warnings]
        return html(f"{self.model.title}, compared", sentences, errors)


def compare(
    model: Any, log: TestLog, *, before: Any = None, fit: bool = False
) -> ShownComparison | ShownDecayComparison:
    """Return where, and by how much, a model and the tests of a log disagree.

    Parameters
    ----------
    model : ModelFile or Model
        What `read_model` returned, or a model made in Python.
    log : TestLog
        What `read_log` returned.
    before : ModelFile or Model, optional
        An older model, scored on the same tests alike.
    fit : bool
        Whether to fit the numbers of the model first, to tests that are not held out.

    Returns
    -------
    ShownComparison or ShownDecayComparison
        Errors as shares of the measured response [-], tables and figures; where nothing drives
        the model, frequency and damping against amplitude.

    Raises
    ------
    ArgumentError
        If an argument is of another kind.
    DiagnosisError
        If the model and the log do not fit together.
    ShakerprocError
        If a recording cannot be used, or the model's motion runs away.
    """
    older = None if before is None else model_of(before, "before").model
    fitted = switch_of("fit", fit)
    return compare_any(model_of(model).model, log_of(log), before=older, fit=fitted)


def compare_any(
    model: Model, log: TestLog, *, before: Model | None = None, fit: bool = False
) -> ShownComparison | ShownDecayComparison:
    """Return a comparison with whole tests, or with decays where nothing drives a model."""
    how = compare_free_decays if model.excitation.role is None else compare_models
    return how(model, log, before=before, fit=fit)


def compare_models(
    model: Model,
    log: TestLog,
    *,
    before: Model | None = None,
    fit: bool = False,
    tell: Callable[[str], None] = lambda _text: None,
    warn: Callable[[str], None] = lambda _text: None,
) -> ShownComparison:
    """Return a comparison, with callbacks for progress and faulty channels; see `compare`."""
    usable = given = usable_tests(log, model)
    usable.tell(warn)
    if before is not None:
        given = usable_tests(log, before).with_those_of(usable)
        usable = usable.with_those_of(given)
        check_same(given.tests, usable.tests)
    comparison = compare_tests(
        model, usable.tests, left_out=usable.left_out, fit=fit, tell=tell
    )
    modes = _modes(comparison, log, warn)
    if before is None and not fit:
        return ShownComparison(comparison, modes=modes)
    old = compare_tests(before or model, given.tests, left_out=given.left_out, tell=tell)
    old, comparison = scored_alike(old, comparison, tell=tell)
    return ShownComparison(comparison, old, modes)


def structure_sentences(model: Model) -> list[str]:
    """Return the modes of each structure that the base moves, and their mass [kg]."""
    if not model.excitation.moves_base:
        return []
    return [
        f"{name}: {len(one.modes)} modes up to "
        f"{numeral(max(mode.frequency for mode in one.modes))} Hz; they move "
        f"{numeral(one.moved_mass, 4)} kg with the base"
        for name, one in model.structures.items()
    ]


_FEW_SENSORS: Final = "sensors at one place tell no shapes; use two places or more"


def _modes(
    comparison: Comparison, log: TestLog, warn: Callable[[str], None]
) -> ComparedModes | None:
    """Return modes of test and model; None where one place alone moves or has sensors."""
    sensed = {sensor.at for sensor in comparison.model.sensors.values()}
    if comparison.model.structures and len(sensed) < 2:
        warn(f"modes of test and model are not compared: {_FEW_SENSORS}")
    if (
        comparison.model.n_coordinates < 2
        or len(sensed) < 2
        or comparison.model.excitation.imposed
    ):
        return None
    try:
        return compared_modes(comparison.model, log, [one.measured for one in comparison.tests])
    except ShakerprocError as error:
        warn(f"modes of test and model are not compared: {error}")
        return None


SCHEMA: Final = "shakerproc-compare-functions/1"
FUNCTION_COLUMNS: Final = (
    "response", "input", "error_percent", "frac", "peak_hz", "model_peak_hz", "coherence",
)  # fmt: skip


@final
@dataclass(frozen=True, slots=True, eq=False)
class ComparedFile:
    """A model beside the response functions of a file.

    Attributes
    ----------
    found : FunctionComparison
        Errors, functions and modes.
    path : Path
        The file.
    """

    found: FunctionComparison
    path: Path

    @property
    def rows(self) -> list[tuple[Any, ...]]:
        """A row for each function, as functions.csv."""
        comparison = self.found
        return [
            (
                one.response, one.input, 100.0 * one.error, one.frac,
                comparison.peak(one.measured), comparison.peak(one.model),
                None if one.coherence is None else float(one.coherence.mean()),
            )
            for one in comparison.functions
        ]  # fmt: skip

    def as_json(self) -> dict[str, Any]:
        """Return the comparison as compare.json holds it."""
        comparison = self.found
        return {
            "schema": SCHEMA,
            "version": __version__,
            "model": comparison.model.title,
            "functions_file": self.path.name,
            "functions_sha256": comparison.measured.sha256,
            "band_hz": [float(comparison.frequency[0]), float(comparison.frequency[-1])],
            "error": comparison.error,
            "sentence": comparison.sentence,
            "functions": [dict(zip(FUNCTION_COLUMNS, row, strict=True)) for row in self.rows],
            "modes": None if comparison.modes is None else modes_document(comparison.modes),
            "notes": list(comparison.notes),
        }

    def write(self, folder: Path, command: str, inputs: Sequence[tuple[str, str, str]]) -> Path:
        """Write tables and page; return the page."""
        files.write_json(folder / "compare.json", self.as_json())
        table = {name: [row[i] for row in self.rows] for i, name in enumerate(FUNCTION_COLUMNS)}
        files.write_csv(folder / "functions.csv", table)
        for name, columns in mode_tables(self.found.modes).items():
            files.write_csv(folder / name, columns)
        page = folder / "report.html"
        write_report(page, function_report(self.found, command, tuple(inputs)))
        return page


def compare_file(model: Model, path: Path, at: Sequence[str] = ()) -> ComparedFile:
    """Return a model beside the response functions of a file.

    Parameters
    ----------
    model : Model
        Its linear part is compared.
    path : Path
        UFF, CSV or MAT.
    at : sequence of str
        ``NAME=PLACE``: the sensor or place of the model that a name of the file stands for.

    Raises
    ------
    ArgumentError
        If one of `at` is no pair of names.
    """
    measured = read_functions(path)
    return ComparedFile(compare_functions(model, measured, pairs(at), Modal()), path)
