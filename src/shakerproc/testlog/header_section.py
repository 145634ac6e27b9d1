"""The keys of ``report:`` in a test log."""

from collections.abc import Callable
from datetime import date, datetime
from pathlib import Path
from typing import Annotated, TypeAlias

from pydantic import AfterValidator, BeforeValidator

from shakerproc.documents import FromList, Section
from shakerproc.testlog.chosen_units import chosen_units
from shakerproc.testlog.equipment import Instrument
from shakerproc.testlog.header import Header, checked_photo, checked_template
from shakerproc.testlog.misfit import MisfitError
from shakerproc.units import quoted


def _as_text(written: object) -> object:
    """Return numbers and days, such as an order of digits alone, as the text that they are."""
    plain = isinstance(written, int | float | date) and not isinstance(written, bool)
    return str(written) if plain else written


def _as_list(written: object) -> object:
    """Return one text, such as ``g, in/s, mil``, as the list that it stands for."""
    return written.split(",") if isinstance(written, str) else written


def _one_line(text: str) -> str:
    if not text.strip() or not text.isprintable() or len(text) > 200:
        raise ValueError(f"expected one line of text, got {quoted(text)}")
    return text.strip()


def _day(text: str) -> str:
    for form in ("%Y-%m-%d", "%d.%m.%Y"):
        try:
            return datetime.strptime(text.strip(), form).date().isoformat()  # noqa: DTZ007
        except ValueError:
            continue
    raise ValueError(f"expected a day such as 2026-03-31, got {quoted(text)}")


Line: TypeAlias = Annotated[str, BeforeValidator(_as_text), AfterValidator(_one_line)]
Day: TypeAlias = Annotated[str, BeforeValidator(_as_text), AfterValidator(_day)]


class InstrumentSection(Section):
    """An instrument and its calibration."""

    instrument: Line
    serial: Line | None = None
    calibrated: Day | None = None
    valid_until: Day | None = None


class HeaderSection(Section):
    """The head of the report."""

    client: Line | None = None
    order: Line | None = None
    specimen: Line | None = None
    photo: str | None = None
    template: str | None = None
    operator: Line | None = None
    standard: Line | None = None
    instruments: Annotated[tuple[InstrumentSection, ...], FromList] = ()
    units: Annotated[tuple[str, ...], FromList, BeforeValidator(_as_list)] = ()


def header_of(section: HeaderSection, below: Callable[[str], Path]) -> Header:
    """Return the head of the report.

    Parameters
    ----------
    section : HeaderSection
        What the log says.
    below : callable
        From a path in the log to one below its folder.

    Raises
    ------
    MisfitError
        If photo, template, a unit or the days of an instrument cannot be used.
    """
    found: dict[str, Path] = {}
    for key, name, check in (
        ("photo", section.photo, checked_photo),
        ("template", section.template, checked_template),
    ):
        if name is not None:
            try:
                found[key] = check(below(name))
            except ValueError as error:
                raise MisfitError(str(error), key) from error
    try:
        shown = chosen_units(section.units)
    except ValueError as error:
        raise MisfitError(str(error), "units") from error
    for i, one in enumerate(section.instruments):
        if one.calibrated and one.valid_until and one.valid_until < one.calibrated:
            raise MisfitError(
                f"expected a day after {one.calibrated}, when it was calibrated, got "
                f"{one.valid_until}",
                "instruments",
                i,
                "valid_until",
            )
    return Header(
        client=section.client or "",
        order=section.order or "",
        specimen=section.specimen or "",
        operator=section.operator or "",
        standard=section.standard or "",
        photo=found.get("photo"),
        template=found.get("template"),
        instruments=tuple(
            Instrument(
                one.instrument, one.serial or "", one.calibrated or "", one.valid_until or ""
            )
            for one in section.instruments
        ),
        units=shown,
    )
