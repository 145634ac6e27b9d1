"""The head of a report: what the log says for the customer, ready for the page."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final, final

from shakerproc.report.photo import photo_uri
from shakerproc.report.sections import Table, filled
from shakerproc.report.templating import Template, read_template
from shakerproc.testlog import TestLog

_LABELS: Final = ("client", "order", "specimen", "standard", "operator")
_COLUMNS: Final = ("instrument", "serial number", "calibrated", "valid until")


@final
@dataclass(frozen=True, slots=True)
class HeaderView:
    """The head of a report; what the log does not say is left out.

    Attributes
    ----------
    lines : sequence of (str, str)
        Label and text.
    instruments : Table, optional
        Instruments and sensors with their calibration.
    photo : str
        The specimen as a data URI; empty where there is none.
    template : Template, optional
        The log's own template of the page.
    """

    lines: Sequence[tuple[str, str]]
    instruments: Table | None = None
    photo: str = ""
    template: Template | None = None


def header_view(log: TestLog) -> HeaderView | None:
    """Return the head of the report of a log; None where the log says nothing for it.

    Raises
    ------
    LogError
        If the photo cannot be read, or the template is none.
    """
    said = log.header
    if said is None:
        return None
    lines = [(name, text) for name in _LABELS if (text := getattr(said, name))]
    rows = [(one.name, one.serial, one.calibrated, one.valid_until) for one in said.instruments]
    rows += _sensors(log)
    photo = "" if said.photo is None else photo_uri(said.photo)
    table = filled("Instruments", _COLUMNS, rows) if rows else None
    template = None if said.template is None else read_template(said.template)
    return HeaderView(lines, table, photo, template)


def _sensors(log: TestLog) -> list[tuple[str, str, str, str]]:
    """Return the sensors of the calibration sheet that the tests use, each once."""
    found = {
        one.serial: (f"sensor, {one.sensitivity}", one.serial, one.calibrated, one.valid_until)
        for test in log.active
        for use in test.channels
        if (one := use.calibration) is not None
    }
    return list(found.values())
