"""What the recordings tell of the joints, and what they leave open."""

import math

import numpy as np

from shakerproc.comparison import Comparison, JointMotion, NotTold
from shakerproc.models.motion import shown_in
from shakerproc.numerals import numeral
from shakerproc.report.evidence.models import loudest
from shakerproc.report.page.sections import Table


def joint_table(comparison: Comparison) -> Table | None:
    """Return a row for each joint in the loudest test; None of a model without joints."""
    test = comparison.tests[loudest(comparison)]
    told = [float(np.sqrt(np.mean(joint.displacement**2))) for joint in test.joints]
    open_ = [one.displacement_rms or 0.0 for one in test.not_told]
    unit, factor = shown_in("m", comparison.model.motion, max(told + open_, default=None))
    rows = [_told(joint, factor) for joint in test.joints]
    rows += [_open(one, factor) for one in test.not_told]
    if not rows:
        return None
    return Table(
        f"Joints in test {test.measured.name}, from the recordings and the masses alone",
        (
            "between",
            f"force rms [{comparison.model.unit_of('N')}]",
            f"displacement rms [{unit}]",
            f"± [{unit}]",
            "from [Hz]",
            "note",
        ),
        rows,
    )


def _told(joint: JointMotion, factor: float) -> tuple[str, ...]:
    force, displacement = (
        float((x**2).mean()) ** 0.5 for x in (joint.force, joint.displacement)
    )
    unsure = numeral(joint.unsure * factor, 2) if math.isfinite(joint.unsure) else "unknown"
    low = numeral(joint.band[0]) if joint.band[0] > 0.0 else ""
    return (
        " - ".join(joint.between),
        numeral(force, 4),
        numeral(displacement * factor),
        unsure,
        low,
        "",
    )


def _open(joint: NotTold, factor: float) -> tuple[str, ...]:
    force, displacement = joint.force_rms, joint.displacement_rms
    return (
        " - ".join(joint.between),
        "" if force is None else numeral(force, 4),
        "" if displacement is None else numeral(displacement * factor),
        "",
        "",
        f"not drawn: {joint.why}",
    )
