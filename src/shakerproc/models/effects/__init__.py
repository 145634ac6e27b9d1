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
from shakerproc.models.own_effects import EffectRegistry

EFFECTS: EffectRegistry = EffectRegistry({
    Spring.kind: Spring,
    Damper.kind: Damper,
    Gap.kind: Gap,
    OffsetGap.kind: OffsetGap,
    Stop.kind: Stop,
    JumpGap.kind: JumpGap,
    CubicStiffness.kind: CubicStiffness,
    QuadraticStiffness.kind: QuadraticStiffness,
    PowerLaw.kind: PowerLaw,
    PowerLawDamping.kind: PowerLawDamping,
    CoulombFriction.kind: CoulombFriction,
    StribeckFriction.kind: StribeckFriction,
    LuGreFriction.kind: LuGreFriction,
    QuadraticDamping.kind: QuadraticDamping,
    ContactDamping.kind: ContactDamping,
    HertzContact.kind: HertzContact,
    Jenkins.kind: Jenkins,
    Iwan.kind: Iwan,
    PowerIwan.kind: PowerIwan,
    BoucWen.kind: BoucWen,
    GeneralBoucWen.kind: GeneralBoucWen,
    AttachedMode.kind: AttachedMode,
    StiffnessDrift.kind: StiffnessDrift,
    ConstantForce.kind: ConstantForce,
    Series.kind: Series,
    Table.kind: Table,
})

SPELLINGS: Mapping[tuple[str, str], str] = MappingProxyType({
    (BoucWen.kind, "alpha"): GeneralBoucWen.kind,
    (Iwan.kind, "chi"): PowerIwan.kind,
})
"""Kinds that model files write as another one: that, and the parameter that tells them."""

__all__ = [
    "EFFECTS",
    "SPELLINGS",
    "AbstractEffect",
    "AttachedMode",
    "BoucWen",
    "ConstantForce",
    "ContactDamping",
    "CoulombFriction",
    "CubicStiffness",
    "Damper",
    "Gap",
    "GeneralBoucWen",
    "HertzContact",
    "Iwan",
    "Jenkins",
    "JumpGap",
    "LuGreFriction",
    "OffsetGap",
    "PowerIwan",
    "PowerLaw",
    "PowerLawDamping",
    "QuadraticDamping",
    "QuadraticStiffness",
    "Series",
    "Spring",
    "StiffnessDrift",
    "Stop",
    "StribeckFriction",
    "Table",
]
