"""The head of a report: what the log says for the customer, ready for the page."""

import base64
import io
import warnings
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Final, final

from markupsafe import Markup

from shakerproc.errors import LogError
from shakerproc.report.page.sections import ReportTable, filled
from shakerproc.report.page.templating import Template, read_template
from shakerproc.runs.flags import EXPIRED
from shakerproc.runs.summary import RunSummary
from shakerproc.testlog import TestLog

if TYPE_CHECKING:
    from PIL.ImageFile import ImageFile

FORMATS: Final = ("JPEG", "PNG", "WEBP", "TIFF", "BMP")
"""What is read."""

SIDE: Final = 1200
"""Longest side in the page [px]: sharp on half a page of A4."""

QUALITY: Final = 82
"""Of the JPEG in the page."""

_LABELS: Final = ("client", "order", "specimen", "standard", "operator")
_COLUMNS: Final = ("instrument", "serial number", "calibrated", "valid until")
_EXPIRED: Final = Markup('<b class="flag">{}, expired when used</b>')


def photo_uri(path: Path) -> str:
    """Return a photo as a data URI: turned upright, at most `SIDE` large, without metadata.

    Raises
    ------
    LogError
        If it is no picture that can be read, or too large a one.
    """
    from PIL import Image, ImageOps, UnidentifiedImageError

    try:
        with warnings.catch_warnings(), _opened(path) as picture:
            picture.draft("RGB", (2 * SIDE, 2 * SIDE))
            upright = ImageOps.exif_transpose(picture)
            upright.thumbnail((SIDE, SIDE))
            flat = Image.new("RGB", upright.size, "white")
            layer = upright.convert("RGBA")
            flat.paste(layer, mask=layer.getchannel("A"))
    except (Image.DecompressionBombWarning, Image.DecompressionBombError) as error:
        most = (Image.MAX_IMAGE_PIXELS or 0) / 1e6
        raise LogError(
            f"{path}: the photo has more than {most:.0f} million pixels; save it smaller"
        ) from error
    except (UnidentifiedImageError, SyntaxError) as error:
        raise LogError(f"{path}: {_NO_PICTURE}") from error
    except (OSError, ValueError, EOFError) as error:
        raise LogError(f"{path}: {_NO_PICTURE} ({error})") from error
    content = io.BytesIO()
    flat.save(content, "JPEG", quality=QUALITY)
    return f"data:image/jpeg;base64,{base64.b64encode(content.getvalue()).decode()}"


def _opened(path: Path) -> "ImageFile":
    """Return a picture that is opened, if it does not unfold to more than Pillow deems safe."""
    from PIL import Image

    warnings.simplefilter("error", Image.DecompressionBombWarning)
    return Image.open(path, formats=FORMATS)


_NO_PICTURE: Final = f"no photo that can be read; save it as one of {', '.join(FORMATS)}"


@final
@dataclass(frozen=True, slots=True)
class HeaderView:
    """The head of a report; what the log does not say is left out.

    Attributes
    ----------
    lines : sequence of (str, str)
        Label and text.
    instruments : ReportTable, optional
        Instruments and sensors with their calibration, the last column until when it is valid.
    told : sequence of str
        The same, one for each row, as flags of runs begin with it.
    photo : str
        The specimen as a data URI; empty where there is none.
    template : Template, optional
        The log's own template of the page.
    """

    lines: Sequence[tuple[str, str]]
    instruments: ReportTable | None = None
    told: Sequence[str] = ()
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
    sensors = {
        one.serial: one
        for test in log.active
        for use in test.channels
        if (one := use.calibration) is not None
    }
    rows = [(one.name, one.serial, one.calibrated, one.valid_until) for one in said.instruments]
    rows += [
        (f"sensor, {one.sensitivity}", one.serial, one.calibrated, one.valid_until)
        for one in sensors.values()
    ]
    photo = "" if said.photo is None else photo_uri(said.photo)
    table = filled("Instruments", _COLUMNS, rows) if rows else None
    template = None if said.template is None else read_template(said.template)
    return HeaderView(
        lines,
        table,
        [*(i.told for i in said.instruments), *(s.told for s in sensors.values())],
        photo,
        template,
    )


def with_expired(view: HeaderView, runs: Sequence[RunSummary]) -> HeaderView:
    """Return the head of a report with a mark at each calibration that a run is flagged for."""
    if view.instruments is None:
        return view
    flagged = {flag.message for run in runs for flag in run.flags if flag.kind == EXPIRED}
    rows = [
        (*row[:-1], _EXPIRED.format(row[-1]))
        if any(message.startswith(f"{told}: ") for message in flagged)
        else row
        for row, told in zip(view.instruments.rows, view.told, strict=True)
    ]
    return replace(view, instruments=replace(view.instruments, rows=rows))
