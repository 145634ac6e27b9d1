"""One example of each kind, of the size that a small bolted joint on a shaker has.

For figures, for the manual, and for the contract that every kind has to keep.
"""

from collections.abc import Mapping
from types import MappingProxyType

from shakerproc.models import effects, faults
from shakerproc.models.effects.base import AbstractEffect
from shakerproc.models.faults import AbstractFault
from shakerproc.models.own_effects import tried

EXAMPLES: Mapping[str, AbstractEffect] = MappingProxyType({
    example.kind: example
    for example in (
        effects.Spring(1.2e5),
        effects.Damper(damping=1.5),
        effects.Gap(1.2e5, 5e-5),
        effects.OffsetGap(1.2e5, 3e-5, 7e-5),
        effects.Stop(1.2e5, 5e-5, "positive"),
        effects.JumpGap(1.2e5, 5e-5),
        effects.CubicStiffness(1e13),
        effects.QuadraticStiffness(5e8),
        effects.PowerLaw(6.0, 1e-4, 5.0),
        effects.PowerLawDamping(3.0, 1e-4, 4.0),
        effects.CoulombFriction(2.0),
        effects.StribeckFriction(1.5, 2.5, 5e-3),
        effects.LuGreFriction(1.5, 2.5, 5e-3, 3e5, 20.0, 1.0),
        effects.QuadraticDamping(30.0),
        effects.ContactDamping(10.0, 5e-5),
        effects.HertzContact(1.2e7, 5e-5, 2.0, "both"),
        effects.Jenkins(1.2e5, 4.0),
        effects.Iwan(1.2e5, 6e-5),
        effects.PowerIwan(1.2e5, 6e-5, -0.5),
        effects.BoucWen(1.2e5, 4e-5, 2.0),
        effects.GeneralBoucWen(5e4, 3e4, -1e4, 1.0),
        effects.AttachedMode(5e-3, 200.0, 0.02),
        effects.StiffnessDrift(-2e-3, 0.0, 1.2e5),
        effects.ConstantForce(0.5),
        effects.Series((effects.Gap(1.2e5, 3e-5), effects.CoulombFriction(4.0))),
        effects.Table(
            (-2e-4, -1e-4, 0.0, 1e-4, 2e-4),
            (-0.1, 0.0, 0.1),
            tuple((f - 1.0, f, f + 1.0) for f in (-9.0, -3.0, 0.0, 3.0, 9.0)),
        ),
    )
})


def example_of(kind: str) -> AbstractEffect:
    """Return an effect of realistic size: an example, or where one's own effect is sought.

    Raises
    ------
    KeyError
        If there is no such kind.
    """
    return EXAMPLES[kind] if kind in EXAMPLES else tried(effects.EFFECTS[kind])[0]


FAULT_EXAMPLES: Mapping[str, AbstractFault] = MappingProxyType({
    example.kind: example
    for example in (
        faults.SensorDelay(2e-5),
        faults.SensorGain(1.1),
        faults.SensorPolarity(),
        faults.Clipping(50.0),
        faults.MainsHum(50.0, 0.3),
    )
})
