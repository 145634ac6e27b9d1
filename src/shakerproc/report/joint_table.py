"""What the recordings tell of the joints, and what they leave open."""

import math

from shakerproc.comparison import Comparison, JointMotion, NotTold
from shakerproc.report.evidence_models import loudest
from shakerproc.report.sections import Table


def joint_table(comparison: Comparison) -> Table | None:
    """Return a row for each joint in the loudest test; None of a model without joints."""
    test = comparison.tests[loudest(comparison)]
    rows = [_told(joint) for joint in test.joints] + [_open(one) for one in test.not_told]
    if not rows:
        return None
    return Table(
        f"Joints in test {test.measured.name}, from the recordings and the masses alone",
        ("between", "force rms [N]", "displacement rms [mm]", "± [mm]", "from [Hz]", "note"),
        rows,
    )


def _told(joint: JointMotion) -> tuple[str, ...]:
    force, displacement = (
        float((x**2).mean()) ** 0.5 for x in (joint.force, joint.displacement)
    )
    unsure = f"{joint.unsure * 1e3:.2g}" if math.isfinite(joint.unsure) else "unknown"
    low = f"{joint.band[0]:.3g}" if joint.band[0] > 0.0 else ""
    return (
        " - ".join(joint.between),
        f"{force:.4g}",
        f"{displacement * 1e3:.3g}",
        unsure,
        low,
        "",
    )


def _open(joint: NotTold) -> tuple[str, ...]:
    force, displacement = joint.force_rms, joint.displacement_rms
    return (
        " - ".join(joint.between),
        "" if force is None else f"{force:.4g}",
        "" if displacement is None else f"{displacement * 1e3:.3g}",
        "",
        "",
        f"not drawn: {joint.why}",
    )
