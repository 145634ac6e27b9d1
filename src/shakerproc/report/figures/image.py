"""Values over a plane for the page: a small picture of few colours, and what they mean."""

import base64
import io
from typing import Final

import numpy as np
from markupsafe import Markup
from numpy.typing import NDArray

from shakerproc.report.figures.axes import UNIT, Box
from shakerproc.report.figures.figure import Image
from shakerproc.runs.summary import SURFACE_STEPS

COLOURS: Final = (
    "#440154", "#470d60", "#48186a", "#482374", "#472e7c", "#453882", "#424186", "#3e4a89",
    "#3a548c", "#365d8d", "#32658e", "#2e6d8e", "#2b758e", "#287d8e", "#25848e", "#228c8d",
    "#1f948c", "#1e9c89", "#20a386", "#25ab82", "#2eb37c", "#3aba76", "#48c16e", "#58c765",
    "#6ccd5a", "#7fd34e", "#93d741", "#a8db34", "#c0df25", "#d5e21a", "#eae51a", "#fde725",
)  # fmt: skip
"""Colour of each step, from little to much: those of matplotlib's viridis."""

_TICKS: Final = 5


def picture(image: Image, box: Box) -> Markup:
    """Return the values as a picture that fills the axes, low values of y below."""
    share = (image.values - image.low) / (image.high - image.low)
    steps = np.rint(np.clip(share, 0.0, 1.0) * (SURFACE_STEPS - 1)).astype(np.uint8)
    return _drawn(steps[::-1], box.left, box.top, box.width, box.height)


def scale(image: Image) -> Markup:
    """Return a bar of all colours with the values that they stand for."""
    values = np.linspace(image.low, image.high, _TICKS)
    texts = (f"{value:.0f}".replace("-", "−") for value in values)
    return Markup(
        '<div class="scale"><svg viewBox="0 0 {} {}" preserveAspectRatio="none">'
        '<g class="axes">{}</g></svg><p>{}</p></div>'  # written once in a page: `axes.shared`
    ).format(
        SURFACE_STEPS * UNIT,
        UNIT,
        _drawn(np.arange(SURFACE_STEPS, dtype=np.uint8)[np.newaxis], 0, 0, SURFACE_STEPS, 1),
        Markup("").join(Markup("<span>{}</span>").format(text) for text in texts),
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
