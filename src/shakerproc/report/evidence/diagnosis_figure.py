"""The errors of all hypotheses of a diagnosis as one figure."""

import math
from typing import TYPE_CHECKING

from shakerproc.diagnosis.result import Diagnosis
from shakerproc.report.evidence.estimates import candidate_name
from shakerproc.report.figures import style

if TYPE_CHECKING:
    from matplotlib.figure import Figure


def candidate_errors(diagnosis: Diagnosis) -> "Figure":
    """Return the held-out error of the model as it was and with each hypothesis, as points."""
    from matplotlib.ticker import NullFormatter, PercentFormatter

    errors = diagnosis.errors
    tried = [one for one in diagnosis.candidates if one.held_out_error is not None]
    several = len({one.between for one in tried}) > 1
    names = ["model as it was"]
    for one in tried:
        place = f", {' - '.join(one.between)}" if several else ""
        names.append(candidate_name(one.kind, one.parameters) + place)
    values = [errors.held_out.before, *(one.held_out_error or 0.0 for one in tried)]
    with style.look():
        figure, (axis,) = style.figure(7.0, 1.2 + 0.28 * len(names), legend=False)
        places = range(len(names))
        colours = [style.COLOURS[7], *(style.COLOURS[0] for _ in tried)]
        axis.scatter(values, places, color=colours, s=30.0, zorder=3)
        axis.set_yticks(list(places), names)
        axis.invert_yaxis()
        axis.grid(visible=False, axis="y")
        floors = [errors.noise_floor] if math.isfinite(errors.noise_floor) else []
        for floor in floors:
            axis.axvline(floor, color=style.COLOURS[1], lw=1.2, label="noise floor")
        axis.set_xscale("log")
        inside = [*values, *floors]
        axis.set_xlim(0.6 * min(inside), 1.8 * max(inside))
        axis.xaxis.set_major_formatter(PercentFormatter(1.0, decimals=None))
        axis.xaxis.set_minor_formatter(NullFormatter())
        axis.set_xlabel("held-out error, share of the response [%]")
        axis.set_title(f"{diagnosis.verdict}: free-run errors of what was tried")
        axis.legend(loc="best")
    return figure
