"""A model with one effect more, for `shakerproc add`."""

import datetime
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final, final

from shakerproc import __version__, files
from shakerproc.diagnosis.adding import Added
from shakerproc.diagnosis.adding import add as add_effect
from shakerproc.diagnosis.estimate import ESTIMATE_COLUMNS
from shakerproc.diagnosis.wanted import Wanted
from shakerproc.errors import ArgumentError, DiagnosisError
from shakerproc.model_files import (
    NewNumbers,
    Provenance,
    add_element,
    model_text,
)
from shakerproc.models import EFFECTS, Model, Scale
from shakerproc.testlog import TestLog
from shakerproc.units import near_miss, to_si
from shakerproc.workflows.arguments import (
    AnyPath,
    GivenModel,
    argument_text,
    list_of,
    log_of,
    model_of,
    path_of,
    switch_of,
)
from shakerproc.workflows.shown import Shown, frame_of_errors, frame_of_rows, html

if TYPE_CHECKING:
    from matplotlib.figure import Figure
    from pandas import DataFrame

    from shakerproc.diagnosis.result import Errors

_NO_HASHES: Final[Mapping[str, str]] = {}


@final
@dataclass(frozen=True, slots=True, eq=False, repr=False)
class UpdatedModel(Shown):
    """A model with one effect more, fitted, and its errors before and after.

    Attributes
    ----------
    kind : str
        Key of the effect.
    known : GivenModel
        The model as it was, and its file.
    log : TestLog
        The tests that it was fitted to and scored on.
    added : Added
        The fit.
    effect_hashes : mapping of str to str
        SHA-256 of the files of own effects that play a part, by name.
    """

    kind: str
    known: GivenModel
    log: TestLog
    added: Added
    effect_hashes: Mapping[str, str] = field(default_factory=dict)

    @property
    def model(self) -> Model:
        """The new model; `compare` takes it as it is."""
        return replace(self.added.model, title=self.title)

    @property
    def title(self) -> str:
        """Title of the new model."""
        joint = " to ".join(self.added.element.between)
        return f"{self.known.model.title}, with {self.kind.replace('_', ' ')} ({joint})"

    @property
    def errors(self) -> "Errors":
        """The free-run errors before and after, fitted and held out [-]."""
        return self.added.errors

    @property
    def intervals(self) -> "DataFrame":
        """The fitted numbers in SI units, of the effect and of the model, with intervals."""
        rows = [
            (whose, name, *p.row)
            for whose, numbers in (
                (self.kind, self.added.parameters),
                ("model", self.added.linear),
            )
            for name, p in numbers.items()
        ]
        return frame_of_rows(("of", "parameter", *ESTIMATE_COLUMNS), rows)

    def to_pandas(self) -> "DataFrame":
        """Return the errors before and after, on fitted and on held-out tests [-]."""
        return frame_of_errors(self.errors)

    def plot(self) -> "Figure":
        """Return the response functions of the model as it was and of the new one."""
        from shakerproc.workflows.comparison import compare_any

        comparison = compare_any(self.model, self.log, before=self.known.model)
        return comparison.plot()

    def save(self, path: AnyPath, *, modes: bool = False) -> Path:
        """Write the new model file, comments and order of the old one kept.

        Parameters
        ----------
        path : path
            The new file; not the old one.
        modes : bool
            Whether to write further linear modes that were fitted, too.

        Returns
        -------
        Path
            The file.

        Raises
        ------
        ArgumentError
            If it is the file of the old model.
        OutputError
            If nothing can be written there.
        DocumentError
            If the old file is laid out so that it cannot be changed in place.
        """
        out, old = path_of("path", path, "a new model file"), self.known.file
        files.checked_folder(out.parent)
        if old is None:
            files.write_text(out, model_text(self.model, heading=f"shakerproc {__version__}"))
            return out
        if out.resolve() == old.path.resolve():
            raise ArgumentError("path", "NEW must be another file than MODEL")
        known, new = self.known.model, self.added.model
        add_element(
            old.path,
            self.added.element,
            out,
            self._provenance(),
            numbers=NewNumbers(
                _changes(known, new),
                {n: m for n, m in new.masses.items() if m != known.masses[n]},
                {n: s for n, s in new.structures.items() if s != known.structures[n]},
            ),
            modes=self.added.modes if switch_of("modes", modes) else (),
            title=self.title,
        )
        return out

    def _provenance(self) -> Provenance:
        """Return where the fitted numbers come from, as the model file says it."""
        added = self.added
        spans = {
            name: (p.low, p.high)
            for name, p in added.parameters.items()
            if p.low is not None and p.high is not None
        }
        hashes = {
            f"{test.recording.parent.name}/{test.recording.name}": added.sha256[str(test.id)]
            for test in self.log.tests
            if test.recording is not None and str(test.id) in added.tests
        }
        hashes |= self.effect_hashes
        today = datetime.datetime.now(tz=datetime.UTC).date().isoformat()
        return Provenance(added.tests, hashes, spans, f"shakerproc {__version__}", today)

    def _repr_html_(self) -> str:
        sentences = [self.added.worse, *self.added.left_out, *self.added.notes]
        return html(self.title, sentences, self.to_pandas(), self.intervals)


def add(
    effect: str,
    model: Any,
    log: TestLog,
    *,
    between: Sequence[str] | None = None,
    start: Mapping[str, str | float] | None = None,
    scaled_by: Mapping[str, str] | None = None,
    force: bool = False,
) -> UpdatedModel:
    """Return a model with one effect more, fitted to a log together with its own numbers.

    Parameters
    ----------
    effect : str
        Key of `effects`, such as ``gap``.
    model : ModelFile or Model
        What `read_model` returned, or a model made in Python.
    log : TestLog
        What `read_log` returned; tests with ``hold_out: true`` are only scored.
    between : pair of str, optional
        Its two places; by default where it fits best.
    start : mapping of str to str or float, optional
        Where its fit may start besides: numbers with their unit (``"0.1 mm"``), or in SI.
    scaled_by : mapping of str to str, optional
        Condition of the tests that its force is proportional to, and the value at which its
        numbers shall hold, such as ``{"voltage": "2 V"}``.
    force : bool
        Whether to return it even where it is no gain.

    Returns
    -------
    UpdatedModel
        Model, intervals, errors before and after, and ``.save(path)``.

    Raises
    ------
    ArgumentError
        If an argument cannot be used.
    DiagnosisError
        If the effect does not fit these tests, or the held-out error does not fall.
    """
    known, tests = model_of(model), log_of(log)
    check_kind(effect)
    places = None if between is None else places_of(between, known.model)
    forced = switch_of("force", force)
    numbers = start_of(effect, {} if start is None else start)
    scale = None if scaled_by is None else scale_of(scaled_by)
    updated_model = fitted_effect(Wanted(effect, places, numbers, scale), known, tests)
    if not forced:
        check_gain(effect, updated_model.added)
    return updated_model


def fitted_effect(
    wanted: Wanted,
    known: GivenModel,
    log: TestLog,
    *,
    effect_hashes: Mapping[str, str] = _NO_HASHES,
    progress: Callable[[str], None] | None = None,
    warn: Callable[[str], None] = lambda _text: None,
) -> UpdatedModel:
    """Return a model with one effect more, whether or not it is a gain."""
    added = add_effect(wanted, known.model, log, force=True, progress=progress, warn=warn)
    return UpdatedModel(wanted.kind, known, log, added, effect_hashes)


def check_gain(effect: str, added: Added) -> None:
    """Pass an effect with which the held-out error falls.

    Raises
    ------
    DiagnosisError
        If it does not fall by more than its standard error.
    """
    if added.worse:
        raise DiagnosisError(
            f"{effect} between {' and '.join(added.element.between)}: {added.worse}. No model "
            "is written; --force writes it all the same."
        )


def _changes(known: Model, new: Model) -> dict[int, dict[str, float]]:
    """Return the numbers of a model that another has changed, by the number of the element."""
    changes = {
        i: {
            name: getattr(other.effect, name)
            for name in own.effect.parameters
            if getattr(other.effect, name) != getattr(own.effect, name)
        }
        for i, (own, other) in enumerate(zip(known.elements, new.elements, strict=False))
    }
    return {i: values for i, values in changes.items() if values}


def check_kind(effect: Any) -> None:
    """Pass an effect that there is.

    Raises
    ------
    ArgumentError
        If there is none of that name.
    """
    if not isinstance(effect, str):
        raise ArgumentError(
            "effect", f"expected the name of an effect, got {argument_text(effect)}"
        )
    if effect not in EFFECTS:
        meant = near_miss(effect, list(EFFECTS))
        question = f"; did you mean {meant}?" if meant else f"; there are {', '.join(EFFECTS)}"
        raise ArgumentError("effect", f"no effect {effect!r}{question}")


def start_of(effect: str, given: Mapping[str, str | float]) -> dict[str, float | str]:
    """Return numbers to start from [SI].

    Raises
    ------
    ArgumentError
        If one is no number of the effect, or not written with its unit.
    """
    if not isinstance(given, Mapping):
        raise ArgumentError(
            "start",
            f'expected numbers such as {{"clearance": "0.1 mm"}}, got {argument_text(given)}',
        )
    known = EFFECTS[effect].estimated()
    starts: dict[str, float | str] = {}
    for name, value in given.items():
        parameter = known.get(name)
        if parameter is None:
            raise ArgumentError(
                "start", f"{effect} has no number {name!r}; it has {', '.join(known)}"
            )
        if parameter.choices or not isinstance(value, str):
            starts[name] = value
            continue
        try:
            starts[name] = to_si(value, parameter.unit)
        except ValueError as error:
            raise ArgumentError("start", f"{name}: {error}") from error
    return starts


def scale_of(given: Any) -> Scale:
    """Return the condition that is to scale an effect.

    Raises
    ------
    ArgumentError
        If it is not one condition with a value above 0 and its unit.
    """
    if not isinstance(given, Mapping) or len(given) != 1:
        raise ArgumentError(
            "scaled_by",
            f'expected one condition such as {{"voltage": "2 V"}}, got {argument_text(given)}',
        )
    ((name, written),) = given.items()
    try:
        return Scale(str(name), written)
    except ValueError as error:
        raise ArgumentError("scaled_by", f"{name}: {error}".removeprefix(": ")) from error


def places_of(between: Sequence[str], model: Model) -> tuple[str, str]:
    """Return two places of a model.

    Raises
    ------
    ArgumentError
        If they are not two of its places.
    """
    there = list(model.places)
    places = [str(place) for place in list_of("between", between, "two places")]
    unknown = [place for place in places if place not in there]
    if unknown:
        raise ArgumentError(
            "between",
            f"{model.title} has no place {unknown[0]!r}; there are {', '.join(there)}",
        )
    if len(places) != 2 or places[0] == places[1]:
        raise ArgumentError(
            "between",
            f"expected two places such as {there[0]},{there[1]}, got {','.join(places)!r}",
        )
    return places[0], places[1]
