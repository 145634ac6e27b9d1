"""The claim of a study file: a statement, and the checks that it must pass."""

from collections.abc import Sequence
from typing import Final

from shakerproc.documents import Document
from shakerproc.runs.tables import former_note, present_name
from shakerproc.studies.checks import Check, Relation, Trend
from shakerproc.studies.kinds import KINDS
from shakerproc.studies.schema import CheckSection, ClaimSection, StudySection
from shakerproc.studies.study import Claim
from shakerproc.units import near_miss, to_si

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
        checks.insert(0, _check(document, ("claim",), _own_trend(section)))
    elif section.quantity is not None:
        raise document.error(
            ("claim", "quantity"), "claim: quantity: belongs to falls with or rises with"
        )
    said = (section.quantity, *(one.quantity for one in section.checks))
    notes = dict.fromkeys(former_note(name or "", str(document.path)) for name in said)
    return Claim(section.statement, tuple(checks), section.comment, tuple(filter(None, notes)))


def _own_trend(section: ClaimSection) -> CheckSection:
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
