"""Sheets of the laboratory: dimensions of specimens, calibrations of sensors, CSV or XLSX."""

import math
import re
import zipfile
from collections.abc import Mapping, Sequence
from dataclasses import replace
from datetime import date, datetime
from pathlib import Path
from typing import Final

from shakerproc.data import ROLE_UNITS, Calibration, ChannelUse
from shakerproc.documents import Document, Key, read_document
from shakerproc.errors import LogError
from shakerproc.late import without_xlsx
from shakerproc.testlog.fields import (
    CHANNEL_UNITS,
    Below,
    MisfitError,
    csv_cells,
    relative_path,
)
from shakerproc.testlog.header import Specimen
from shakerproc.testlog.schema import LogSection, SpecimenSection, SpecimensFile
from shakerproc.units import fits_sensitivity, near_miss, quoted

Table = Mapping[tuple[str, str], Specimen]

MOST_BYTES: Final = 10_000_000
"""Largest sheet that is read [byte]."""

MOST_UNPACKED: Final = 30_000_000
"""Largest XLSX once unpacked: a row of a sheet takes some 300 bytes of XML [byte]."""

MOST_ROWS: Final = 100_000
MOST_COLUMNS: Final = 200

_COLUMNS: Final[Mapping[str, re.Pattern[str]]] = {
    "serial": re.compile(r"(sensor )?(serial|s/?n)( ?(number|no\.?))?|sensor", re.I),
    "sensitivity": re.compile(r"sensitivity", re.I),
    "unit": re.compile(r"(sensitivity )?unit", re.I),
    "calibrated": re.compile(r"(date of )?calibrat(ed|ion)( on| date)?|date", re.I),
    "valid_until": re.compile(
        r"valid (until|to)|(calibration )?due( date)?|next calibration|expir(es|y).*", re.I
    ),
    "uncertainty": re.compile(r"(expanded )?uncertainty( of (the )?sensitivity)?", re.I),
}
"""How the columns are called."""

_WANTED: Final = "serial number, sensitivity [mV/g], calibrated, valid until"

UNCERTAINTIES: Final = (0.1, 20.0)
"""Expanded uncertainties between which a cell is one: a third of that of a laser interferometer
(ISO 16063-11), and twice that of a check in the field (ISO 16063-44) [%]."""

_DATES: Final = ("%Y-%m-%d", "%d.%m.%Y", "%Y/%m/%d")


def specimens_of(document: Document[LogSection]) -> Table:
    """Return the specimens of a log by joint and name.

    Raises
    ------
    DocumentError
        If dimensions contradict each other, or the file of specimens cannot be used.
    """
    entry = document.value.specimens
    if not isinstance(entry, str):
        return _table(document, entry, ("specimens",))
    try:
        path = Below(document.path.parent).path(entry)
    except ValueError as error:
        raise document.error(("specimens",), str(error)) from error
    if not path.is_file():
        raise document.error(("specimens",), f"no file {path}")
    file = read_document(document.path.parent / relative_path(entry), SpecimensFile)
    return _table(file, file.value.joints, ("joints",))


def _table(
    document: Document[LogSection] | Document[SpecimensFile],
    joints: Mapping[str, Mapping[str, SpecimenSection]],
    place: tuple[Key, ...],
) -> Table:
    return {
        (joint, name): _specimen(document, section, joint, name, (*place, joint, name))
        for joint, names in joints.items()
        for name, section in names.items()
    }


def _specimen(
    document: Document[LogSection] | Document[SpecimensFile],
    section: SpecimenSection,
    joint: str,
    name: str,
    place: tuple[Key, ...],
) -> Specimen:
    """Return one specimen, its clearances worked out from its dimensions.

    Raises
    ------
    DocumentError
        If the hole is smaller than the bushing, or a clearance is given twice and differs.
    """
    actual = section.clearance
    if section.hole is not None and section.bushing is not None:
        measured = round(section.hole - section.bushing, 12)
        if measured < 0.0:
            raise document.error(
                (*place, "bushing"), "expected a bushing that is not larger than the hole"
            )
        if actual is not None and abs(actual - measured) > 1e-9:
            raise document.error(
                (*place, "clearance"),
                f"expected hole less bushing, {measured * 1e3:g} mm; leave one of them out",
            )
        actual = measured
    axial = None
    if section.thickness is not None and section.bushing_thickness is not None:
        axial = max(0.0, round(section.bushing_thickness - section.thickness, 12))
    return Specimen(
        joint, name, section.nominal, actual, axial, section.material or "", section.comment
    )


def read_calibrations(path: Path) -> dict[str, Calibration]:
    """Return the calibrations of a sheet by serial number.

    Raises
    ------
    LogError
        If it is no such sheet, or a row cannot be used.
    """
    if not path.is_file():
        raise LogError(f"{path}: no such file; put the calibration sheet there")
    if path.stat().st_size > MOST_BYTES:
        raise LogError(f"{path}: expected a calibration sheet, got more than 10 MB")
    is_sheet = path.suffix.lower() == ".xlsx"
    rows = _xlsx_rows(path) if is_sheet else csv_cells(path.read_bytes(), path)
    filled = [(line, cells) for line, cells in rows if any(cells)]
    if not filled:
        raise LogError(f"{path}: expected a header such as {_WANTED}, got an empty sheet")
    columns = _columns(path, *filled[0])
    calibrations: dict[str, Calibration] = {}
    for line, cells in filled[1:]:
        one = _calibration(f"{path}:{line}", columns, cells)
        if one.serial in calibrations:
            raise LogError(f"{path}:{line}: sensor {quoted(one.serial)} stands twice")
        calibrations[one.serial] = one
    return calibrations


def _xlsx_rows(path: Path) -> list[tuple[int, list[str]]]:
    """Return the cells of every row of the first sheet.

    Raises
    ------
    LogError
        If openpyxl is not installed, or cannot read the file.
    """
    if lacks := without_xlsx():
        raise LogError(f"{path}: {lacks}")
    import openpyxl

    try:
        with zipfile.ZipFile(path) as archive:
            unpacked = sum(entry.file_size for entry in archive.infolist())
        if unpacked > MOST_UNPACKED:
            raise LogError(
                f"{path}: expected a calibration sheet, got {unpacked / 1e6:.0f} MB once "
                f"unpacked; {MOST_UNPACKED / 1e6:g} MB are the most"
            )
        book = openpyxl.load_workbook(path, read_only=True, data_only=True)
        try:
            some = book.worksheets[0].iter_rows(
                max_row=MOST_ROWS + 1, max_col=MOST_COLUMNS, values_only=True
            )
            rows = list(some)
        finally:
            book.close()
    except LogError:
        raise
    except Exception as error:
        raise LogError(f"{path}: no sheet that can be read: {error}") from error
    if len(rows) > MOST_ROWS:
        raise LogError(
            f"{path}: expected at most {MOST_ROWS} rows; delete the empty ones below"
        )
    return [(line, [_text(cell) for cell in cells]) for line, cells in enumerate(rows, 1)]


def _text(cell: object) -> str:
    if isinstance(cell, datetime | date):
        return cell.strftime("%Y-%m-%d")
    whole = isinstance(cell, float) and cell.is_integer()
    return "" if cell is None else str(int(cell) if whole else cell).strip()  # type: ignore[call-overload]


def _columns(path: Path, line: int, header: Sequence[str]) -> dict[str, tuple[int, str]]:
    """Return place and unit in brackets of each column that is known.

    Raises
    ------
    LogError
        If one that is needed is missing.
    """
    columns: dict[str, tuple[int, str]] = {}
    for i, cell in enumerate(header):
        name, _, unit = cell.replace("(", "[").partition("[")
        for key, pattern in _COLUMNS.items():
            is_share = key != "uncertainty" or "%" in unit
            if is_share and pattern.fullmatch(name.strip()):
                columns.setdefault(key, (i, unit.strip(" ])")))
    if not {"serial", "sensitivity"} <= columns.keys():
        got = ", ".join(cell for cell in header if cell)
        raise LogError(f"{path}:{line}: expected a header such as {_WANTED}, got {got}")
    return columns


def _calibration(
    place: str, columns: Mapping[str, tuple[int, str]], cells: Sequence[str]
) -> Calibration:
    """Return the calibration of a row.

    Raises
    ------
    LogError
        If it has no serial number, no sensitivity in volts, a date that is none, one that
        ends before it begins, or an uncertainty that is no per cent.
    """
    cell = {key: cells[at] if at < len(cells) else "" for key, (at, _) in columns.items()}
    unit = cell.get("unit") or columns["sensitivity"][1]
    sensitivity = " ".join(part for part in (cell["sensitivity"], unit) if part)
    if not cell["serial"]:
        raise LogError(f"{place}: no serial number")
    if not any(fits_sensitivity(sensitivity, unit) for unit in CHANNEL_UNITS):
        raise LogError(
            f"{place}: sensor {quoted(cell['serial'])}: expected volts per unit, such as "
            f"100 mV/g, got {quoted(sensitivity)}"
        )
    dates = [_date(place, cell.get(key, "")) for key in ("calibrated", "valid_until")]
    if all(dates) and dates[1] < dates[0]:
        raise LogError(
            f"{place}: sensor {quoted(cell['serial'])}: expected valid until after calibrated, "
            f"got {dates[1]} and {dates[0]}"
        )
    share = _uncertainty(place, cell.get("uncertainty", ""))
    return Calibration(cell["serial"], sensitivity, dates[0], dates[1], share)


def _uncertainty(place: str, text: str) -> float | None:
    """Return an expanded uncertainty, given in per cent, as a share [-]; None without one.

    Raises
    ------
    LogError
        If it is no number of per cent.
    """
    if not text:
        return None
    least, most = UNCERTAINTIES
    try:
        value = float(text.removesuffix("%").strip().replace(",", "."))
    except ValueError:
        value = math.nan
    if not least <= value <= most:
        raise LogError(
            f"{place}: expected an expanded uncertainty (k = 2) of {least:g} to {most:g} %, "
            f"such as 1.5, got {quoted(text)}"
        )
    return value / 100.0


def _date(place: str, text: str) -> str:
    """Return a date as YYYY-MM-DD; empty where there is none.

    Raises
    ------
    LogError
        If it is none.
    """
    for form in _DATES if text else ():
        try:
            return datetime.strptime(text, form).strftime("%Y-%m-%d")  # noqa: DTZ007 - a day
        except ValueError:
            continue
    if text:
        raise LogError(f"{place}: expected a date such as 2026-03-31, got {quoted(text)}")
    return ""


def calibrated(
    uses: Sequence[ChannelUse], sheet: Mapping[str, Calibration]
) -> tuple[ChannelUse, ...]:
    """Return channels with the calibration of their sensor.

    Raises
    ------
    MisfitError
        If the sheet lacks the sensor, or it measures something else than the channel.
    """
    return tuple(use if use.sensor is None else _with_sheet(use, sheet) for use in uses)


def _with_sheet(use: ChannelUse, sheet: Mapping[str, Calibration]) -> ChannelUse:
    calibration = sheet.get(use.sensor or "")
    if calibration is None:
        meant = near_miss(use.sensor or "", list(sheet))
        question = f'; did you mean "{meant}"?' if meant else ""
        raise MisfitError(
            f"expected a sensor of the calibration sheet, got {quoted(use.sensor)}{question}",
            use.key,
            "sensor",
        )
    wanted = () if use.role == "ignore" else ROLE_UNITS[use.role]
    if wanted and not any(fits_sensitivity(calibration.sensitivity, unit) for unit in wanted):
        raise MisfitError(
            f"sensor {quoted(calibration.serial)} has {calibration.sensitivity} in the "
            f"calibration sheet, but role {use.role} is in {' or '.join(wanted)}; correct "
            "sensor, role or sheet",
            use.key,
            "sensor",
        )
    return replace(use, calibration=calibration)
