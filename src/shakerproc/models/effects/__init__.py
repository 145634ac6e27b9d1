"""The effects shakerproc knows, one in each file, and the mapping of them all."""

from collections.abc import Mapping
from types import MappingProxyType

from shakerproc.models.effects.attached_mode import AttachedMode
from shakerproc.models.effects.base import AbstractEffect
from shakerproc.models.effects.bouc_wen import BoucWen
from shakerproc.models.effects.constant_force import ConstantForce
from shakerproc.models.effects.contact_damping import ContactDamping
from shakerproc.models.effects.coulomb_friction import CoulombFriction
from shakerproc.models.effects.cubic_stiffness import CubicStiffness
from shakerproc.models.effects.damper import Damper
from shakerproc.models.effects.gap import Gap
from shakerproc.models.effects.general_bouc_wen import GeneralBoucWen
from shakerproc.models.effects.hertz_contact import HertzContact
from shakerproc.models.effects.iwan import Iwan
from shakerproc.models.effects.jenkins import Jenkins
from shakerproc.models.effects.jump_gap import JumpGap
from shakerproc.models.effects.lugre_friction import LuGreFriction
from shakerproc.models.effects.offset_gap import OffsetGap
from shakerproc.models.effects.power_iwan import PowerIwan
from shakerproc.models.effects.power_law import PowerLaw
from shakerproc.models.effects.power_law_damping import PowerLawDamping
from shakerproc.models.effects.quadratic_damping import QuadraticDamping
from shakerproc.models.effects.quadratic_stiffness import QuadraticStiffness
from shakerproc.models.effects.series import Series
from shakerproc.models.effects.spring import Spring
from shakerproc.models.effects.stiffness_drift import StiffnessDrift
from shakerproc.models.effects.stop import Stop
from shakerproc.models.effects.stribeck_friction import StribeckFriction
from shakerproc.models.effects.table import Table
from shakerproc.models.own_effects import EffectRegistry, tried

EXAMPLES: Mapping[str, AbstractEffect] = MappingProxyType({
    example.kind: example
    for example in (
        Spring(1.2e5),
        Damper(damping=1.5),
        Gap(1.2e5, 5e-5),
        OffsetGap(1.2e5, 3e-5, 7e-5),
        Stop(1.2e5, 5e-5, "positive"),
        JumpGap(1.2e5, 5e-5),
        CubicStiffness(1e13),
        QuadraticStiffness(5e8),
        PowerLaw(6.0, 1e-4, 5.0),
        PowerLawDamping(3.0, 1e-4, 4.0),
        CoulombFriction(2.0),
        StribeckFriction(1.5, 2.5, 5e-3),
        LuGreFriction(1.5, 2.5, 5e-3, 3e5, 20.0, 1.0),
        QuadraticDamping(30.0),
        ContactDamping(10.0, 5e-5),
        HertzContact(1.2e7, 5e-5, 2.0, "both"),
        Jenkins(1.2e5, 4.0),
        Iwan(1.2e5, 6e-5),
        PowerIwan(1.2e5, 6e-5, -0.5),
        BoucWen(1.2e5, 4e-5, 2.0),
        GeneralBoucWen(5e4, 3e4, -1e4, 1.0),
        AttachedMode(5e-3, 200.0, 0.02),
        StiffnessDrift(-2e-3, 0.0, 1.2e5),
        ConstantForce(0.5),
        Series((Gap(1.2e5, 3e-5), CoulombFriction(4.0))),
        Table(
            (-2e-4, -1e-4, 0.0, 1e-4, 2e-4),
            (-0.1, 0.0, 0.1),
            tuple((f - 1.0, f, f + 1.0) for f in (-9.0, -3.0, 0.0, 3.0, 9.0)),
        ),
    )
})
"""One effect of each kind, of the size that a small bolted joint on a shaker has."""

EFFECTS: EffectRegistry = EffectRegistry({
    kind: type(example) for kind, example in EXAMPLES.items()
})

SPELLINGS: Mapping[tuple[str, str], str] = MappingProxyType({
    (BoucWen.kind, "alpha"): GeneralBoucWen.kind,
    (Iwan.kind, "chi"): PowerIwan.kind,
})
"""Kinds that model files write as another one: that, and the parameter that tells them."""


def example_of(kind: str) -> AbstractEffect:
    """Return an effect of realistic size: an example, or where one's own effect is sought.

    Raises
    ------
    KeyError
        If there is no such kind.
    """
    return EXAMPLES[kind] if kind in EXAMPLES else tried(EFFECTS[kind])[0]
