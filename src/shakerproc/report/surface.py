"""Values over a plane for the page: a small picture of few colours, and what they mean."""

import base64
import io
from typing import Final

import numpy as np
from markupsafe import Markup
from numpy.typing import NDArray

from shakerproc.report.axes import UNIT, Box
from shakerproc.report.drawn import Image
from shakerproc.runs.summary import SURFACE_STEPS

_VIRIDIS: Final = (
    "440154", "482475", "414487", "355f8d", "2a788e", "21918c", "22a884", "44bf70", "7ad151",
    "bddf26", "fde725",
)  # fmt: skip
"""Colours of matplotlib's viridis at even distances, from little to much."""

_TICKS: Final = 5
_SCALE_WIDTH, _SCALE_LEFT, _SCALE_RIGHT = 560, 58, 18  # [px], as the axes above it
_BAR, _SCALE_HEIGHT = 8, 24  # [px]


def _colours() -> NDArray[np.uint8]:
    """Return the colour of each step, (n, 3)."""
    known = np.array([list(bytes.fromhex(colour)) for colour in _VIRIDIS], dtype=float)
    place = np.linspace(0.0, len(known) - 1.0, SURFACE_STEPS)
    columns = [np.interp(place, np.arange(len(known)), column) for column in known.T]
    return np.array(np.rint(np.transpose(columns)), dtype=np.uint8)


COLOURS: Final = tuple(f"#{bytes(row).hex()}" for row in _colours())
"""Colour of each step, from little to much."""


def picture(image: Image, box: Box) -> Markup:
    """Return the values as a picture that fills the axes, low values of y below."""
    share = (image.values - image.low) / (image.high - image.low)
    steps = np.rint(np.clip(share, 0.0, 1.0) * (SURFACE_STEPS - 1)).astype(np.uint8)
    return _drawn(steps[::-1], box.left, box.top, box.width, box.height)


def scale(image: Image) -> Markup:
    """Return a bar of all colours with the values that they stand for."""
    steps = np.arange(SURFACE_STEPS, dtype=np.uint8)[np.newaxis]
    width = _SCALE_WIDTH - _SCALE_LEFT - _SCALE_RIGHT
    places = np.linspace(_SCALE_LEFT, _SCALE_LEFT + width, _TICKS)
    values = np.linspace(image.low, image.high, _TICKS)
    texts = [f"{value:.0f}".replace("-", "−") for value in values]
    texts[-1] = f"{texts[-1]} {image.label}"
    sides = ["start", *["middle"] * (_TICKS - 2), "end"]
    return Markup('<svg viewBox="0 0 {} {}" class="plot">{}{}</svg>').format(
        _SCALE_WIDTH * UNIT,
        _SCALE_HEIGHT * UNIT,
        _drawn(steps, _SCALE_LEFT, 0, width, _BAR),
        Markup("").join(
            Markup('<text class="{}" x="{:.0f}" y="{}">{}</text>').format(
                side, place * UNIT, (_SCALE_HEIGHT - 2) * UNIT, text
            )
            for side, place, text in zip(sides, places, texts, strict=True)
        ),
    )


def _drawn(
    steps: NDArray[np.uint8], left: float, top: float, wide: float, high: float
) -> Markup:
    return Markup(
        '<image x="{}" y="{}" width="{}" height="{}" preserveAspectRatio="none" '
        'href="data:image/png;base64,{}"/>'
    ).format(
        left * UNIT,
        top * UNIT,
        wide * UNIT,
        high * UNIT,
        base64.b64encode(_png(steps)).decode(),
    )


def _png(steps: NDArray[np.uint8]) -> bytes:
    from PIL import Image as Pictures

    found = Pictures.fromarray(np.ascontiguousarray(steps))
    found.putpalette(bytes.fromhex("".join(COLOURS).replace("#", "")))
    file = io.BytesIO()
    found.save(file, "PNG", optimize=True)
    return file.getvalue()
