"""A study file to a study; every message with line and column."""

from dataclasses import replace
from pathlib import Path

from shakerproc.documents import Document, read_document
from shakerproc.errors import ShakerprocError
from shakerproc.model_files import read_model
from shakerproc.models import Model
from shakerproc.studies.claim_reading import read_claim
from shakerproc.studies.kinds import KINDS, OPTIONS
from shakerproc.studies.kinds.base import StudyJob, jobs_of
from shakerproc.studies.kinds.formula import FORMULAS
from shakerproc.studies.placing import unit_of_place
from shakerproc.studies.schema import StudySection
from shakerproc.studies.study import Measure, Study, StudyRun, Variation, Warmth
from shakerproc.units import near_miss, to_si


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
    for key, found, known in (
        ("kind", kind, tuple(KINDS)),
        ("formula", formula, tuple(FORMULAS)),
    ):
        if found not in known and not (key == "formula" and kind != "formula"):
            meant = near_miss(found, known)
            hint = f'; did you mean "{meant}"?' if meant else ""
            raise document.error(
                (key,), f"{key}: expected one of {', '.join(known)}, got {found!r}{hint}"
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
    return read_model(path)


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
    found = read_coupon(path)
    if found.fit is None:
        raise document.error(
            ("coupon",), f"coupon: {named} has no joint: the size and material of its insert"
        )
    return Warmth(found.fit, found.reference)


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
    found = []
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
        found.append((name, value))
    return tuple(found)


def _check_needs(document: Document[StudySection], study: Study) -> None:
    """Pass a study that has what its kind needs.

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
