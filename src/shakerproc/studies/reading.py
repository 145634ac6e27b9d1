"""A study file to a study; every message with line and column."""

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import Annotated, Any, Final, Literal, TypeAlias

from pydantic import Field

from shakerproc.documents import Document, FromList, Section, read_document
from shakerproc.errors import ShakerprocError
from shakerproc.model_files import read_model
from shakerproc.models import Model
from shakerproc.models.validation import check_unscaled
from shakerproc.runs.tables import former_note, present_name
from shakerproc.studies.kinds import KINDS, OPTIONS
from shakerproc.studies.kinds.base import StudyJob, jobs_of
from shakerproc.studies.kinds.formula import FORMULAS
from shakerproc.studies.results import Check, Relation, Trend
from shakerproc.studies.study import (
    Claim,
    Measure,
    Study,
    StudyRun,
    Variation,
    Warmth,
    unit_of_place,
)
from shakerproc.units import in_unit, near_miss, to_si

Hertz: TypeAlias = Annotated[float, in_unit("Hz", positive=True)]
FromZero: TypeAlias = Annotated[float, in_unit("Hz", not_negative=True)]
Seconds: TypeAlias = Annotated[float, in_unit("s", positive=True)]


class RunSection(Section):
    """One simulated run."""

    excitation: Literal["free", "sine", "sine sweep", "random"]
    level: Any = None
    start: FromZero = Field(0.0, alias="from")
    stop: FromZero = Field(0.0, alias="to")
    frequency: FromZero = 0.0
    phase: Annotated[float, in_unit("rad")] = 0.0
    duration: Seconds = 30.0
    sample_rate: Hertz = Field(500.0, alias="sample rate")
    direction: Literal["up", "down"] = "up"
    spacing: Literal["linear", "octaves"] = "linear"
    initial_displacement: Annotated[float, in_unit("m")] = Field(
        0.0, alias="initial displacement"
    )
    initial_velocity: Annotated[float, in_unit("m/s")] = Field(0.0, alias="initial velocity")
    settle: Annotated[float | int, Field(ge=0.0, lt=1.0)] = 0.0
    seed: Annotated[int, Field(ge=0)] = 0
    method: Literal["exact", "Newmark", "RK45", "BDF"] = "exact"
    tolerance: Annotated[float, Field(gt=0.0, lt=1.0)] = 1e-3


class MeasureSection(Section):
    """Reading taken from a run."""

    of: Literal["acceleration", "velocity", "displacement"] = "acceleration"
    estimator: Literal["periodogram", "welch"] = "periodogram"
    segment: Annotated[int, Field(ge=16)] = 2048
    take: Literal["tallest", "first"] = "tallest"
    start: FromZero = Field(0.0, alias="from")
    stop: FromZero = Field(0.0, alias="to")
    ensemble: Annotated[int, Field(ge=0, le=1000)] = 16


class VariationSection(Section):
    """One parameter that takes several values."""

    name: str
    set: str | Annotated[tuple[str, ...], FromList]
    values: Annotated[tuple[Any, ...], FromList, Field(min_length=1)]


class CheckSection(Section):
    """One check: a quantity, one thing that is wanted of it, a tolerance."""

    quantity: str | None = None
    equals: Any = None
    above: Any = None
    below: Any = None
    falls_with: str | None = Field(None, alias="falls with")
    rises_with: str | None = Field(None, alias="rises with")
    changes_with: str | None = Field(None, alias="changes with")
    within: Any = None


class ClaimSection(Section):
    """A published statement, and the checks that it must pass."""

    statement: str
    quantity: str | None = None
    falls_with: str | None = Field(None, alias="falls with")
    rises_with: str | None = Field(None, alias="rises with")
    checks: Annotated[tuple[CheckSection, ...], FromList] = ()
    comment: str = ""


class StudySection(Section):
    """A study file."""

    study: Literal[1]
    title: str
    kind: str
    figure: str = ""
    model: str | None = None
    coupon: str | None = None
    formula: str = ""
    run: RunSection | None = None
    measure: MeasureSection = Field(default_factory=MeasureSection)
    vary: Annotated[tuple[VariationSection, ...], FromList] = ()
    claim: ClaimSection | None = None
    options: dict[str, Any] = Field(default_factory=dict)


BOUNDS: Final[tuple[Relation, ...]] = ("equals", "above", "below")
TRENDS: Final[tuple[Trend, ...]] = ("falls", "rises", "changes")
DEFAULT: Final = "peak_frequency_hz"
"""Quantity of a claim that names none."""


def read_claim(document: Document[StudySection]) -> Claim | None:
    """Return the claim of a study.

    Raises
    ------
    DocumentError
        If a check names no quantity or variation of the study, wants two things at once, or
        compares with something that is no value.
    """
    section = document.value.claim
    if section is None:
        return None
    checks = [
        _check(document, ("claim", "checks", i), one) for i, one in enumerate(section.checks)
    ]
    if section.falls_with is not None or section.rises_with is not None:
        checks.insert(0, _check(document, ("claim",), _claimed_trend(section)))
    elif section.quantity is not None:
        raise document.error(
            ("claim", "quantity"), "claim: quantity: belongs to falls with or rises with"
        )
    said = (section.quantity, *(one.quantity for one in section.checks))
    notes = dict.fromkeys(former_note(name or "", str(document.path)) for name in said)
    return Claim(section.statement, tuple(checks), section.comment, tuple(filter(None, notes)))


def _claimed_trend(section: ClaimSection) -> CheckSection:
    """Return the trend that a claim states beside its checks, as a check."""
    said = section.model_dump(
        by_alias=True, include={"quantity", "falls_with", "rises_with"}, exclude_none=True
    )
    return CheckSection.model_validate(said)


def _check(
    document: Document[StudySection], where: Sequence[str | int], said: CheckSection
) -> Check:
    """Return one check.

    Raises
    ------
    DocumentError
        As `read_claim` does.
    """
    place = ": ".join(str(part) for part in where if isinstance(part, str))
    known = KINDS[document.value.kind].quantities
    quantity = present_name(said.quantity or DEFAULT)
    if quantity not in known:
        meant = near_miss(quantity, tuple(known))
        hint = f'did you mean "{meant}"?' if meant else f"there are {', '.join(known)}"
        raise document.error(
            (*where, "quantity") if said.quantity else where,
            f"{place}: quantity: a study of kind {document.value.kind} has no {quantity!r}; "
            f"{hint}",
        )
    wanted = [name for name in BOUNDS if getattr(said, name) is not None]
    trends = [name for name in TRENDS if getattr(said, f"{name}_with") is not None]
    if len(wanted) + len(trends) != 1:
        several = [*wanted, *(f"{name} with" for name in trends)]
        raise document.error(
            where,
            f"{place}: expected one of equals, above, below, falls with, rises with, changes "
            f"with; got {' and '.join(several) or 'none'}"
            + (": either or, not both" if several else ""),
        )
    within, relative = _tolerance(document, where, said, known[quantity])
    if trends:
        along = getattr(said, f"{trends[0]}_with")
        names = [variation.name for variation in document.value.vary]
        if along not in names:
            raise document.error(
                (*where, f"{trends[0]} with"),
                f"{place}: {trends[0]} with: expected one of "
                f"{', '.join(map(repr, names)) or 'no variation: the study varies nothing'}, "
                f"got {along!r}",
            )
        return Check(quantity, trends[0], within=within, relative=relative, along=along)
    bound = _number(document, (*where, wanted[0]), getattr(said, wanted[0]), known[quantity])
    if wanted[0] == "equals" and within is None:
        raise document.error(where, f"{place}: equals needs a tolerance, such as within: 2 %")
    return Check(quantity, wanted[0], bound, within, relative)


def _tolerance(
    document: Document[StudySection],
    where: Sequence[str | int],
    said: CheckSection,
    unit: str,
) -> tuple[float | None, bool]:
    """Return a tolerance and whether it is a share.

    Raises
    ------
    DocumentError
        If it is no such value, or below 0.
    """
    if said.within is None:
        return None, False
    relative = isinstance(said.within, str) and said.within.strip().endswith("%")
    within = _number(document, (*where, "within"), said.within, "1" if relative else unit)
    if within < 0.0:
        raise document.error(
            (*where, "within"), f"within: expected at least 0, got {said.within}"
        )
    return within, relative


def _number(
    document: Document[StudySection], where: Sequence[str | int], said: object, unit: str
) -> float:
    """Return a value in SI.

    Raises
    ------
    DocumentError
        If it is none of this unit.
    """
    try:
        return to_si(said, unit)
    except ValueError as error:
        raise document.error(where, f"{where[-1]}: {error}") from error


def read_study(path: Path) -> Study:
    """Return the study that a file describes.

    Parameters
    ----------
    path : Path
        A YAML file; its model stands in a file of its own, named relative to it.

    Raises
    ------
    DocumentError
        If the file cannot be used, with line and column.
    """
    document = read_document(path, StudySection)
    section = document.value
    _check_kind(document)
    model, warmth = _model(document), _warmth(document)
    study = Study(
        title=section.title,
        kind=section.kind,
        figure=section.figure,
        model=model,
        run=_run(document, model),
        measure=_measure(document),
        vary=tuple(_variation(document, model, warmth, i) for i in range(len(section.vary))),
        claim=read_claim(document),
        options=_options(document),
        formula=section.formula,
        warmth=warmth,
    )
    _check_needs(document, study)
    return study


def _check_kind(document: Document[StudySection]) -> None:
    """Pass a kind and a formula that are known.

    Raises
    ------
    DocumentError
        If they are not.
    """
    kind, formula = document.value.kind, document.value.formula
    for key, given, known in (
        ("kind", kind, tuple(KINDS)),
        ("formula", formula, tuple(FORMULAS)),
    ):
        if given not in known and not (key == "formula" and kind != "formula"):
            meant = near_miss(given, known)
            hint = f'; did you mean "{meant}"?' if meant else ""
            raise document.error(
                (key,), f"{key}: expected one of {', '.join(known)}, got {given!r}{hint}"
            )


def _model(document: Document[StudySection]) -> Model | None:
    """Return the model of a study.

    Raises
    ------
    DocumentError
        If its file is not there, or not below the study's folder.
    """
    if document.value.model is None:
        return None
    folder = document.path.parent.resolve()
    path = (folder / document.value.model).resolve()
    if not path.is_relative_to(folder) or not path.is_file():
        raise document.error(
            ("model",),
            f"model: expected a model file in {folder.name}/ or below, got "
            f"{document.value.model!r}",
        )
    model = read_model(path)
    check_unscaled(model, "a study")
    return model


def _run(document: Document[StudySection], model: Model | None) -> StudyRun | None:
    """Return the run of a study, its level in SI.

    Raises
    ------
    DocumentError
        If the level is none of the unit that drives the model.
    """
    section = document.value.run
    if section is None:
        return None
    level = 0.0
    if section.level is not None:
        unit = "m/s^2" if model is None else model.drive_unit
        try:
            level = to_si(section.level, unit)
        except ValueError as error:
            raise document.error(("run", "level"), f"run: level: {error}") from error
    return StudyRun(
        excitation=section.excitation,
        level=level,
        from_hz=section.start,
        to_hz=section.stop,
        frequency=section.frequency,
        duration=section.duration,
        sample_rate=section.sample_rate,
        down=section.direction == "down",
        octaves=section.spacing == "octaves",
        phase=section.phase,
        initial_displacement=section.initial_displacement,
        initial_velocity=section.initial_velocity,
        settle=float(section.settle),
        seed=section.seed,
        method=section.method,
        tolerance=section.tolerance,
    )


def _measure(document: Document[StudySection]) -> Measure:
    section = document.value.measure
    return Measure(
        of=section.of,
        estimator=section.estimator,
        segment=section.segment,
        take=section.take,
        from_hz=section.start,
        to_hz=section.stop,
        ensemble=section.ensemble,
    )


def _warmth(document: Document[StudySection]) -> Warmth | None:
    """Return how the joint of the study's coupon expands.

    Raises
    ------
    DocumentError
        If the coupon is not there, or says nothing of its joint.
    """
    named = document.value.coupon
    if named is None:
        return None
    from shakerproc.model_files.coupon_files import read_coupon  # brings the finite elements

    path = document.path.parent / named
    if not path.is_file():
        raise document.error(("coupon",), f"coupon: expected a coupon file, got {named!r}")
    coupon_file = read_coupon(path)
    if coupon_file.fit is None:
        raise document.error(
            ("coupon",), f"coupon: {named} has no joint: the size and material of its insert"
        )
    return Warmth(coupon_file.fit, coupon_file.reference)


def _variation(
    document: Document[StudySection], model: Model | None, warmth: Warmth | None, index: int
) -> Variation:
    """Return one variation with its values in SI.

    Raises
    ------
    DocumentError
        If a place does not exist or a value does not suit it.
    """
    section = document.value.vary[index]
    where = ("vary", index)
    if model is None:
        raise document.error(where, "vary: a study without a model varies nothing")
    places = (section.set,) if isinstance(section.set, str) else section.set
    try:
        units = {unit_of_place(model, place, warmth) for place in places}
    except ValueError as error:
        raise document.error((*where, "set"), f"vary: set: {error}") from error
    if len(units) != 1:
        raise document.error(
            (*where, "set"),
            f"vary: set: places of one unit belong together, not {sorted(units)}",
        )
    unit = units.pop()
    values = []
    for i, text in enumerate(section.values):
        try:
            values.append(_value(text, unit))
        except ValueError as error:
            raise document.error((*where, "values", i), f"vary: values: {error}") from error
    texts = tuple(" ".join(str(text).split()) for text in section.values)
    return Variation(section.name, unit, places, tuple(values), texts)


def _value(written: object, unit: str) -> float:
    """Return a value in SI; plain numbers where there is no unit.

    Raises
    ------
    ValueError
        If it is no such value.
    """
    if unit == "1" and isinstance(written, int | float) and not isinstance(written, bool):
        return float(written)
    return to_si(written, unit)


def _options(document: Document[StudySection]) -> tuple[tuple[str, float], ...]:
    """Return the options of the kind, in SI.

    Raises
    ------
    DocumentError
        If the kind knows no such option, or the value does not suit it.
    """
    known = OPTIONS.get(document.value.kind, {})
    options = []
    for name, written in document.value.options.items():
        if name not in known:
            raise document.error(
                ("options", name),
                f"options: a study of kind {document.value.kind} knows "
                f"{', '.join(known) or 'no options'}, not {name!r}",
                at_key=True,
            )
        try:
            value = _value(written, known[name].unit)
        except ValueError as error:
            raise document.error(("options", name), str(error)) from error
        if problem := known[name].problem(value):
            raise document.error(("options", name), f"{problem}, got {written}")
        options.append((name, value))
    return tuple(options)


def _check_needs(document: Document[StudySection], study: Study) -> None:
    """Raise where a study lacks a need of its kind.

    Raises
    ------
    DocumentError
        If something is missing.
    """
    try:
        KINDS[study.kind].check(study)
    except (ValueError, ShakerprocError) as error:
        raise document.error(("kind",), f"kind: {study.kind}: {error}") from error
    _check_jobs(document, study)


def _check_jobs(document: Document[StudySection], study: Study) -> None:
    """Pass a study whose every combination can be run, before the first one is.

    Raises
    ------
    DocumentError
        If a model or a run of one of them is none.
    """
    kind = KINDS[study.kind]
    try:
        for job in jobs_of(study):
            kind.check_job(study, job)
    except (ValueError, ShakerprocError) as error:
        raise document.error(_blamed(study), str(error)) from error


def _blamed(study: Study) -> tuple[str | int, ...]:
    """Return the place of the part without which the study has no or another problem."""
    whole = _problem(study)
    if study.vary and not whole:
        return ("vary", 0)
    if study.options and _problem(replace(study, options=())) != whole:
        return ("options",)
    if _problem(replace(study, measure=Measure())) != whole:
        return ("measure",)
    return ("run",) if study.run is not None else ("options",)


def _problem(study: Study) -> str:
    """Return the error of a study without its variations; empty where it can be done."""
    try:
        KINDS[study.kind].check_job(study, StudyJob(study.model, study.run))
    except ValueError as error:
        return str(error)
    return ""
