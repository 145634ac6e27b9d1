"""A figure that a notebook shows, whether or not anybody has set up matplotlib there."""

from io import BytesIO
from typing import Final

from matplotlib.figure import Figure

from shakerproc.report.figures.style import write_legibly

DOTS_PER_INCH: Final = 100


class NotebookFigure(Figure):
    """A figure that is its own picture as the last line of a cell."""

    def _repr_png_(self) -> bytes:
        write_legibly(self)
        buffer = BytesIO()
        self.savefig(buffer, format="png", dpi=DOTS_PER_INCH)
        return buffer.getvalue()
