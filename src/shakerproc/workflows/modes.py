"""Modes of the tests of a log, for `shakerproc modal`."""

from base64 import b64encode
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final, final

from shakerproc.campaign.trends import mode_shifts
from shakerproc.errors import ArgumentError
from shakerproc.modal.analysis import ModalAnalysis, TestModes
from shakerproc.modal.from_measurements import analyse_functions, analyse_log
from shakerproc.recordings.response_functions import holds_functions, read_functions
from shakerproc.testlog import Modal, Test, TestLog
from shakerproc.workflows.arguments import (
    choice_of,
    list_of,
    log_of,
    number_of,
    positive_of,
    switch_of,
    whole_of,
)
from shakerproc.workflows.modal_tables import (
    document_of,
    mode_columns,
    reciprocity_columns,
    shape_columns,
    track_columns,
)
from shakerproc.workflows.shown import Shown, frame, html

if TYPE_CHECKING:
    from matplotlib.figure import Figure
    from pandas import DataFrame


MOST_MODES: Final = 200
"""More modes than this are not asked for."""


@final
@dataclass(frozen=True, slots=True, eq=False, repr=False)
class Modes(Shown):
    """Modes of the tests of a log, followed from test to test.

    Attributes
    ----------
    found : shakerproc.modal.analysis.ModalAnalysis
        Poles, shapes, models, diagrams and response functions of every test.
    path : Path
        The test log, or the file of response functions, that was analysed.
    """

    found: ModalAnalysis
    path: Path

    def to_pandas(self) -> "DataFrame":
        """Return frequency and damping with 95 % limits: a row for each mode of each test."""
        return frame(mode_columns(self.found))

    @property
    def shapes(self) -> "DataFrame":
        """Mode shapes: a row for each mode and sensor, as shapes.csv."""
        return frame(shape_columns(self.found))

    @property
    def tracks(self) -> "DataFrame":
        """Each mode through the tests, with shift and MAC, as tracks.csv."""
        return frame(track_columns(self.found))

    @property
    def reciprocity(self) -> "DataFrame":
        """Functions between the same two places there and back, as reciprocity.csv."""
        return frame(reciprocity_columns(self.found))

    def as_json(self) -> dict[str, Any]:
        """Return the analysis as report.json holds it."""
        return document_of(self.found, self.path)

    @property
    def figures(self) -> tuple[str, ...]:
        """Names of the figures that `plot` draws, such as ``test_1_shapes``."""
        from shakerproc.report.modal.figures import figures_of

        return tuple(figures_of(self.found))

    def plot(self, figure: str = "") -> "Figure":
        """Return a figure of the analysis.

        Parameters
        ----------
        figure : str
            One of `figures`; by default the stabilisation diagram of the first test.

        Raises
        ------
        ArgumentError
            If there is no such figure.
        """
        from shakerproc.report.figures import style
        from shakerproc.report.modal.figures import figures_of

        with style.look():
            known = figures_of(self.found)
            return known[choice_of("figure", figure, known, "a figure")]()

    def shape(self, mode: int, test: str | int | None = None) -> "ModeShape":
        """Return a mode shape that swings in a notebook, on the geometry where there is one.

        Parameters
        ----------
        mode : int
            Its number, from 1.
        test : str or int, optional
            Name of the test; by default the first.

        Raises
        ------
        ArgumentError
            If there is no such test, mode or shape.
        """
        known = {one.name: one for one in self.found.tests if len(one.sensors) > 1}
        one = known[choice_of("test", "" if test is None else str(test), known, "a test")]
        return ModeShape(one, whole_of("mode", mode, 1, one.modes.poles.size) - 1)

    def _repr_html_(self) -> str:
        sentences = [*mode_shifts(self.found), *self.found.notes]
        sentences += [f"test {name} left out: {reason}" for name, reason in self.found.failed]
        sentences += [
            f"test {one.name}: {note}" for one in self.found.tests for note in one.notes
        ]
        names = ["test", "mode", "frequency_hz", "damping", "damping_low", "damping_high"]
        return html(f"{self.found.title}: modes", sentences, self.to_pandas()[names])


@final
@dataclass(frozen=True, slots=True, eq=False, repr=False)
class ModeShape(Shown):
    """A mode shape of a test; a notebook shows it moving.

    Attributes
    ----------
    test : shakerproc.modal.analysis.TestModes
        The test.
    number : int
        Of the mode, from 0.
    """

    test: TestModes
    number: int

    @property
    def svg(self) -> str:
        """The moving picture, whole in itself, as an SVG file holds it."""
        from shakerproc.report.modal.figures import moving_shape
        from shakerproc.report.page.page import svg_file

        one, shape = self.test, self.test.modes.shapes[self.number]
        title = f"Shape of mode {self.number + 1}"
        return svg_file(moving_shape(one.geometry, shape, one.sensor_names, title))

    def plot(self) -> "Figure":
        """Return the shape at its largest, at rest grey."""
        from shakerproc.report.figures import style
        from shakerproc.report.modal.figures import draw_shape

        with style.look():
            figure, (axis,) = style.figure(5.0, 3.4)
            axis.set_axis_off()
            one = self.test
            draw_shape(axis, one.geometry, one.modes.shapes[self.number], one.sensor_names)
        return figure

    def _repr_html_(self) -> str:
        modes, i = self.test.modes, self.number
        heading = (
            f"Mode {i + 1} of test {self.test.name}: {modes.frequency[i]:.5g} Hz, "
            f"damping {modes.damping[i]:.3%}"
        )
        picture = b64encode(self.svg.encode()).decode()
        source = f"data:image/svg+xml;base64,{picture}"
        return f'{html(heading)}\n<img width="540" alt="mode shape" src="{source}">'


def modes(
    log: TestLog | Path | str,
    *,
    tests: Sequence[object] = (),
    against: TestLog | None = None,
    band: tuple[float, float] | None = None,
    count: int | None = None,
    keep: Sequence[float] = (),
    together: bool = False,
) -> Modes:
    """Return natural frequencies, damping and mode shapes from the tests of a log.

    What is not said here is that of ``modal:`` in the log.

    Parameters
    ----------
    log : TestLog, Path or str
        What `read_log` returned; or a file of response functions (UFF, CSV or MAT).
    tests : sequence of int or str
        Ids of the tests; by default all that are not discarded.
    against : TestLog, optional
        A second log, whose modes are followed too.
    band : (float, float), optional
        Where modes are looked for [Hz].
    count : int, optional
        How many modes; by default as many as the measurement needs.
    keep : sequence of float
        Frequencies near which a pole is kept, whatever the automatic selection says [Hz].
    together : bool
        Whether all tests go into one fit.

    Returns
    -------
    Modes
        Tables and figures; tests that cannot be analysed are told with the reason.

    Raises
    ------
    ArgumentError
        If an argument is of another kind, or the band is empty.
    LogError
        If there is no such test.
    """
    if isinstance(log, (str, Path)) and holds_functions(Path(log)):
        return modes_of_functions(Path(log), _wish(Modal(), band, count, keep))
    read = log_of(log)
    other = None if against is None else log_of(against, "against")
    ids = list_of("tests", tests, "ids of tests")
    chosen = [read.find(str(one)) for one in ids] if ids else read.active
    wish = _wish(read.modal, band, count, keep)
    wish = replace(wish, together=switch_of("together", together) or wish.together)
    return modes_of(read, chosen, wish, other)


def _wish(
    said: Modal, band: tuple[float, float] | None, count: int | None, keep: Sequence[float]
) -> Modal:
    """Return how modes are looked for: by arguments, else by the log."""
    near = tuple(positive_of("keep", one) for one in list_of("keep", keep, "frequencies"))
    wish = wish_of(
        said,
        band=None if band is None else _band_of(band),
        count=None if count is None else whole_of("count", count, 1, MOST_MODES),
    )
    return replace(wish, keep=near or wish.keep)


def _band_of(given: Any) -> tuple[float, float]:
    """Return a band [Hz].

    Raises
    ------
    ArgumentError
        If it is no pair of numbers.
    """
    ends = list_of("band", given, "two frequencies")
    if len(ends) != 2:
        raise ArgumentError("band", f"expected two frequencies, got {len(ends)}")
    return number_of("band", ends[0]), number_of("band", ends[1])


def modes_of(
    log: TestLog,
    tests: Sequence[Test],
    wish: Modal,
    against: TestLog | None = None,
    progress: Callable[[str], None] = lambda _name: None,
) -> Modes:
    """Return the modes of tests, and of those of a second log; see `modes`."""
    more = None if against is None else (against, against.active)
    return Modes(analyse_log(log, tests, wish, against=more, progress=progress), log.path)


def modes_of_functions(path: Path, wish: Modal | None = None) -> Modes:
    """Return the modes of the response functions in a file, without a test log.

    Parameters
    ----------
    path : Path
        UFF, CSV or MAT.
    wish : Modal, optional
        How modes are looked for.

    Raises
    ------
    RecordingError
        If it holds no response functions.
    SpectrumError
        If they do not allow it.
    """
    return Modes(analyse_functions(read_functions(path), wish or Modal()), path)


def wish_of(
    said: Modal,
    *,
    band: tuple[float, float] | None = None,
    count: int | None = None,
    order: int | None = None,
) -> Modal:
    """Return how modes are looked for in a band [Hz]: arguments before the log.

    Raises
    ------
    ArgumentError
        If the band is empty.
    """
    if band is not None and not 0.0 < band[0] < band[1]:
        raise ArgumentError("band", f"expected from below to, above 0 Hz, got {band}")
    return replace(
        said,
        band=said.band if band is None else band,
        modes=said.modes if count is None else count,
        order=said.order if order is None else order,
    )
