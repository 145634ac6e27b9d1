"""Prediction of planned tests: the workflow of `shakerproc forecast`."""

import json
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any, final

from shakerproc.diagnosis.data.from_files import tests_of
from shakerproc.errors import ArgumentError, LogError
from shakerproc.forecasts import CampaignForecast as Found
from shakerproc.forecasts import document_of, forecast_tests, headline, sentences
from shakerproc.forecasts.document import SCHEMA
from shakerproc.forecasts.levels import amplitude_of_measured, quantity_of
from shakerproc.forecasts.notch_plan import (
    EDGE_DB_PER_OCTAVE,
    PROBABILITY,
    NotchWish,
    check_notches,
)
from shakerproc.forecasts.notches import profile_csv, profile_yaml
from shakerproc.models import Model
from shakerproc.testlog import Test, TestLog, level_of
from shakerproc.workflows.arguments import (
    log_of,
    model_of,
    switch_of,
    text_of,
    whole_of,
    within_of,
)
from shakerproc.workflows.shown import Shown, frame_of_rows, html

if TYPE_CHECKING:
    from collections.abc import Sequence

    from matplotlib.figure import Figure
    from pandas import DataFrame

    from shakerproc.comparison import Measured

COLUMNS = ("test", "of", "name", "what", "value", "low", "high", "linear", "unit")
"""Columns of the table of a forecast."""


SHARES = (0.5, 0.999)
"""Probabilities that a notch plan may keep: a plan is verified by some thousands of values."""

SLOPES = (1.0, 1000.0)
"""Edges of notches that make sense [dB/oct]."""


@final
@dataclass(frozen=True, slots=True, eq=False, repr=False)
class Forecast(Shown):
    """Predicted responses of planned tests, with 90 % bands and the limits of the log.

    Attributes
    ----------
    found : shakerproc.forecasts.Forecast
        The whole of it, typed.
    """

    found: Found

    @property
    def sentence(self) -> str:
        """Go or no-go, and the limit that decides."""
        return headline(self.found)

    @property
    def go(self) -> bool | None:
        """Whether every limit is kept with 95 %; None where the log has none."""
        each = [one.go for one in self.found.tests]
        return None if None in each else all(each)

    def as_json(self) -> dict[str, Any]:
        """Return the forecast as forecast.json holds it."""
        return document_of(self.found)

    @property
    def rows(self) -> list[tuple[Any, ...]]:
        """Every quantity of every planned test in SI units, as forecast.csv has it."""
        return [
            (
                one.planned.test.id, q.whose, q.name, q.what, spread.value, *spread.band,
                one.linear.get(q), q.unit,
            )
            for one in self.found.tests
            for q, spread in one.spreads.items()
        ]  # fmt: skip

    def to_pandas(self) -> "DataFrame":
        """Return every quantity of every planned test, with its band, in SI units."""
        return frame_of_rows(COLUMNS, self.rows)

    def plot(self) -> "Figure":
        """Return the predicted densities of the first planned test beside measured levels."""
        from shakerproc.report.figures.to_png import matplotlib_figure
        from shakerproc.report.models.forecast import density_figures

        first = density_figures(self.found.tests[0], self.found)[0]
        return matplotlib_figure(first, str(first.plots[0].title))

    def _repr_html_(self) -> str:
        texts = [text for one in self.found.tests for text in sentences(one)]
        return html(self.sentence, [*texts, *self.found.notes], self.to_pandas())


def forecast(
    model: Any,
    log: TestLog,
    *,
    level: str | None = None,
    notch: bool = False,
    probability: float = PROBABILITY,
    edges_db_per_octave: float = EDGE_DB_PER_OCTAVE,
    seed: int = 0,
) -> Forecast:
    """Return the predicted responses of the tests that a log plans, with 90 % bands.

    Parameters
    ----------
    model : ModelFile or Model
        The model, with the effects that the specimen has.
    log : TestLog
        What `read_log` returned; its tests with ``planned: true`` are forecast.
    level : str, optional
        Level of the planned tests in place of the log's, such as ``0.04 g^2/Hz``; where the
        log plans none, of the loudest test that was run.
    notch : bool
        Whether to plan the least notches that keep every limit.
    probability : float
        With which notches keep each limit, from 0.5 to 0.999 [-].
    edges_db_per_octave : float
        Steepest edge of a notch, from 1 to 1000 [dB/oct].
    seed : int
        Of all that is drawn.

    Raises
    ------
    ArgumentError
        If an argument is of another kind.
    DiagnosisError
        If fewer than two levels were run, or the model does not fit the tests.
    LogError
        If nothing is planned, or a limit cannot be judged.
    ShakerprocError
        If a recording cannot be used, or a motion runs away.
    """
    wanted = None if level is None else text_of("level", level)
    number = whole_of("seed", seed, 0)
    share = within_of("probability", probability, *SHARES)
    slope = within_of("edges_db_per_octave", edges_db_per_octave, *SLOPES)
    wish = NotchWish(share, slope) if switch_of("notch", notch) else None
    known = model_of(model).model
    return forecast_log(known, log_of(log), level=wanted, wish=wish, seed=number)


def forecast_log(
    model: Model,
    log: TestLog,
    *,
    level: str | None = None,
    wish: NotchWish | None = None,
    earlier: Mapping[str, Any] | None = None,
    seed: int = 0,
    say: Callable[[str], None] = lambda _text: None,
    warn: Callable[[str], None] = lambda _text: None,
) -> Forecast:
    """Return a forecast, with callbacks for progress and faulty channels; see `result`.

    Raises
    ------
    LogError
        If nothing drives the model, nothing is planned, or a limit cannot be judged.
    """
    if model.excitation.role is None or model.excitation.imposed:
        raise LogError(
            f"{model.title}: a forecast needs a model that a base acceleration or a force "
            "drives. Give what excites it in the model: {base: acceleration}, say."
        )
    for limit in log.limits:  # before recordings are read
        quantity_of(limit, model, log)
    if wish is not None:
        check_notches(log, log.planned)
    if level is None and not log.planned:
        raise LogError(
            f"{log.path.name}: no test is planned. Add one with planned: true, or give --level "
            "(level=...), such as 0.04 g^2/Hz."
        )
    usable = tests_of(replace(log, planned=()), model)
    usable.tell(warn)
    planned = list(log.planned) if level is None else _at_level(log, usable.tests, level)
    result = forecast_tests(
        model, log, usable.tests, planned, wish=wish, earlier=earlier, seed=seed, say=say
    )
    return Forecast(result)


def _at_level(log: TestLog, tests: "Sequence[Measured]", level: str) -> list[Test]:
    """Return the planned tests, or else the loudest that was run, at another level.

    Raises
    ------
    ArgumentError
        If the level is none of their excitation.
    """
    loudest = max(tests, key=amplitude_of_measured)
    length = (loudest.stop - loudest.start) / loudest.sample_rate
    again = replace(
        loudest.test, id=f"{loudest.name} at {level}", recording=None, planned=True,
        hold_out=False, duration=loudest.test.duration or length,
    )  # fmt: skip
    at_level = []
    for test in log.planned or (again,):
        try:
            value, unit = level_of(level, test.excitation)
        except ValueError as error:
            raise ArgumentError("level", str(error)) from error
        at_level.append(replace(test, level=value, level_unit=unit, level_text=level))
    return at_level


def earlier_document(folder: Path) -> dict[str, Any] | None:
    """Return the document of the forecast in a folder; None where there is none to read."""
    try:
        entries = json.loads((folder / "forecast.json").read_text(encoding="utf-8"))
    except (OSError, ValueError):
        return None
    return entries if isinstance(entries, dict) and entries.get("schema") == SCHEMA else None


def _write_notches(folder: Path, result: Forecast) -> None:
    """Write the notched profile of each planned test as YAML and as CSV."""
    from shakerproc import files

    for one in result.found.tests:
        notched = None if one.notch is None else one.notch.notched
        if notched is None or notched.test.profile is None:
            continue
        name, profile = f"notched_{one.planned.test.id}", notched.test.profile
        note = f'of test {one.planned.test.id}: give it profile: "{profile.name}" and no level'
        files.write_text(folder / f"{name}.yaml", profile_yaml(profile, note))
        files.write_text(folder / f"{name}.csv", profile_csv(profile))


def write_forecast(
    folder: Path, result: Forecast, command: str, inputs: "Sequence[tuple[str, str, str]]",
    *, figures: bool,
) -> Path:  # fmt: skip
    """Write report.html, forecast.json, forecast.csv and figures; return the page."""
    from shakerproc import files
    from shakerproc.report.models.forecast import density_figures, profile_figure, sections
    from shakerproc.report.page.methods import methods_of
    from shakerproc.report.page.page import Report, write_report

    files.write_json(folder / "forecast.json", result.as_json())
    rows = result.rows
    table = {name: [row[i] for row in rows] for i, name in enumerate(COLUMNS)}
    files.write_text(folder / "forecast.csv", files.csv_text(table))
    _write_notches(folder, result)
    if figures:
        from shakerproc.report.figures.to_png import matplotlib_figure, save

        for one in result.found.tests:
            profile = profile_figure(one)
            for figure in (
                *([profile] if profile else []),
                *density_figures(one, result.found),
            ):
                picture = matplotlib_figure(figure, str(figure.plots[0].title))
                save(picture, folder / f"{figure.name}.png")
    report = Report(
        result.found.title,
        [],
        command=command,
        verdict=f"{result.sentence}.",
        sections=sections(result.found),
        inputs=inputs,
        methods=methods_of([], analyses=["forecast"]),
    )
    write_report(folder / "report.html", report)
    return folder / "report.html"
