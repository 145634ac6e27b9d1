"""The head of a report for a customer: who asked for the tests, of what, measured with what."""

from dataclasses import dataclass, field
from pathlib import Path
from typing import Final, final

from shakerproc.testlog.chosen_units import ChosenUnits
from shakerproc.testlog.equipment import Instrument

MOST_BYTES: Final = 20_000_000
"""Largest photo of a specimen [byte]."""

MOST_OF_TEMPLATE: Final = 1_000_000
"""Largest template of a report [byte]."""


@final
@dataclass(frozen=True, slots=True)
class Header:
    """Entries of the log for the top of the report; empty text where it has none.

    Attributes
    ----------
    client, order, specimen, operator, standard : str
        One line each.
    photo : Path, optional
        Picture of the specimen.
    template : Path, optional
        Template of the report, in place of the usual one.
    instruments : tuple of Instrument
        In the order of the log.
    units : mapping
        Units that the report shows, as `chosen_units` returns them; empty for the usual ones.
    """

    client: str = ""
    order: str = ""
    specimen: str = ""
    operator: str = ""
    standard: str = ""
    photo: Path | None = None
    template: Path | None = None
    instruments: tuple[Instrument, ...] = ()
    units: ChosenUnits = field(default_factory=dict)


def checked_photo(path: Path) -> Path:
    """Return the path of a photo that is there and not too large.

    Raises
    ------
    ValueError
        If it is not.
    """
    if not path.is_file():
        raise ValueError(f"no file {path}; put the photo there, or take the key out")
    size = path.stat().st_size
    if size > MOST_BYTES:
        raise ValueError(
            f"expected a photo of at most {MOST_BYTES / 1e6:g} MB, {path.name} has "
            f"{size / 1e6:.1f} MB; save it smaller"
        )
    return path


def checked_template(path: Path) -> Path:
    """Return the path of a template that is there and not too large.

    Raises
    ------
    ValueError
        If it is not.
    """
    if not path.is_file():
        raise ValueError(f"no file {path}; put the template there, or take the key out")
    size = path.stat().st_size
    if size > MOST_OF_TEMPLATE:
        raise ValueError(
            f"expected a template of at most {MOST_OF_TEMPLATE / 1e6:g} MB, {path.name} has "
            f"{size / 1e6:.1f} MB"
        )
    return path
