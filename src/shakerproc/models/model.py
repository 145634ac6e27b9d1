"""A model: masses, the elements between them, its excitation and its sensors."""

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from types import MappingProxyType
from typing import Final, Literal, TypeAlias, final

from shakerproc import checks
from shakerproc.errors import ModelError
from shakerproc.models.conditions import NOTHING, Conditions, Scale
from shakerproc.models.effects.attached_mode import AttachedMode
from shakerproc.models.effects.base import AbstractEffect, AbstractMemorylessEffect, times
from shakerproc.models.faults import AbstractFault
from shakerproc.models.motion import Motion, unit_in
from shakerproc.models.structure import Mode, Structure
from shakerproc.models.validation import check_model

BASE: Final = "base"
"""Name of the shaker table in ``between`` and ``at``."""

Measures: TypeAlias = Literal[
    "acceleration",
    "relative displacement",
    "relative velocity",
    "displacement",
    "velocity",
    "force",
]
MEASURES: Final[tuple[Measures, ...]] = (
    "acceleration",
    "relative displacement",
    "relative velocity",
    "displacement",
    "velocity",
    "force",
)


@final
@dataclass(frozen=True, slots=True)
class Element:
    """One effect between two places.

    Attributes
    ----------
    effect : AbstractEffect
        The force law.
    between : tuple of str
        Two places, masses or ``base``; displacement is that of the second minus that of the
        first. An attached mode may name its one place alone and gets the base as the first.
    scaled_by : Scale, optional
        Condition of the test that the force is proportional to.
    """

    effect: AbstractEffect
    between: tuple[str, str]
    scaled_by: Scale | None = None

    def __post_init__(self) -> None:
        between = tuple(self.between)
        if len(between) == 1 and isinstance(self.effect, AttachedMode):
            between = (BASE, *between)
        if len(between) != 2:
            raise ValueError(f"between must name two places, not {list(self.between)}")
        object.__setattr__(self, "between", between)
        if self.scaled_by is not None:
            times(self.effect, 1.0)  # tells what cannot be scaled

    def under(self, conditions: Conditions) -> "Element | None":
        """Return the element with the force that it has under conditions; None without any.

        One that remembers or moves by itself stays, so that tests have the same motions.
        """
        if self.scaled_by is None:
            return self
        share = self.scaled_by.share(conditions)
        if share == 0.0 and isinstance(self.effect, AbstractMemorylessEffect):
            return None
        return Element(times(self.effect, max(share, NOTHING)), self.between)


@final
@dataclass(frozen=True, slots=True)
class Sensor:
    """Place, direction and quantity of one channel.

    Attributes
    ----------
    at : str
        Mass that it sits on, or ``base``.
    measures : str
        ``acceleration``, ``displacement`` and ``velocity`` are absolute; ``relative
        displacement`` and ``relative velocity`` are against the base; ``force`` is what imposes
        the displacement of the mass.
    faults : tuple of AbstractFault
        What goes wrong between the motion and the recording, in this order.
    """

    at: str
    measures: Measures = "acceleration"
    faults: tuple[AbstractFault, ...] = ()

    def __post_init__(self) -> None:
        if self.measures not in MEASURES:
            wanted = ", ".join(MEASURES)
            raise ValueError(f"measures must be one of {wanted}, not {self.measures!r}")


Kind: TypeAlias = Literal["base acceleration", "force", "imposed displacement", "free decay"]


@final
@dataclass(frozen=True, slots=True)
class Excitation:
    """Input of the model: motion of its base, or a force.

    Attributes
    ----------
    kind : {"base acceleration", "force", "imposed displacement", "free decay"}
        Absolute acceleration of the base [m/s^2], a force [N], the displacement of a mass
        against a base at rest [m] (a component test, in which the force is the answer), or
        nothing but a start away from rest.
    on : str, optional
        Mass that the force acts on, or whose displacement is imposed.
    """

    kind: Kind
    on: str | None = None

    def __post_init__(self) -> None:
        if self.kind not in UNITS:
            wanted = " or ".join(UNITS)
            raise ValueError(f"kind must be {wanted}, not {self.kind!r}")
        if (self.kind in {"force", "imposed displacement"}) != (self.on is not None):
            raise ValueError(
                "a force needs the mass it acts on and an imposed displacement the mass that "
                "it moves, a base acceleration and a free decay none"
            )

    @property
    def unit(self) -> str:
        """SI unit of the input; 1 where there is none."""
        return UNITS[self.kind]

    @property
    def role(self) -> Literal["control", "force", "displacement"] | None:
        """Role of the channels that measure the input; None where there is none."""
        return ROLES[self.kind]

    @property
    def imposed(self) -> bool:
        """Whether the motion of a mass is imposed."""
        return self.kind == "imposed displacement"

    @property
    def moves_base(self) -> bool:
        """Whether the base moves."""
        return self.kind == "base acceleration"


UNITS: Final[Mapping[Kind, str]] = MappingProxyType({
    "base acceleration": "m/s^2",
    "force": "N",
    "imposed displacement": "m",
    "free decay": "1",
})
"""SI unit of each kind of input."""

SENSOR_UNITS: Final[Mapping[Measures, str]] = MappingProxyType({
    "acceleration": "m/s^2",
    "displacement": "m",
    "velocity": "m/s",
    "relative displacement": "m",
    "relative velocity": "m/s",
    "force": "N",
})
"""SI unit of what each kind of sensor measures in a translation."""

ROLES: Final[Mapping[Kind, Literal["control", "force", "displacement"] | None]] = (
    MappingProxyType({
        "base acceleration": "control",
        "force": "force",
        "imposed displacement": "displacement",
        "free decay": None,
    })
)
"""Role of the channels that measure each kind of input."""


@final
@dataclass(frozen=True, slots=True)
class Model:
    """Masses and structures, the elements between them, sensors and excitation.

    Attributes
    ----------
    title : str
        One line for reports.
    masses : mapping of str to float
        Mass of each place that moves, in order [kg].
    elements : tuple of Element
        The forces.
    excitation : Excitation
        What shakes it.
    sensors : mapping of str to Sensor
        Which channel measures what.
    modes : tuple of Mode
        Further linear modes of the specimen.
    motion : Motion
        Whether the masses move along an axis, or turn about it: then they are moments of
        inertia, displacements angles and forces torques, and every unit is that of `unit_of`.
    structures : mapping of str to Structure
        Elastic bodies by their modes; their points are places as masses are.

    Raises
    ------
    ModelError
        If a place is unknown, nothing holds a mass, or a stiffness drives its mass away.
    """

    title: str
    masses: Mapping[str, float]
    elements: tuple[Element, ...]
    excitation: Excitation
    sensors: Mapping[str, Sensor] = field(default_factory=dict)
    modes: tuple[Mode, ...] = ()
    motion: Motion = "translation"
    structures: Mapping[str, Structure] = field(default_factory=dict)

    def __post_init__(self) -> None:
        object.__setattr__(self, "structures", MappingProxyType(dict(self.structures)))
        object.__setattr__(self, "masses", MappingProxyType(dict(self.masses)))
        object.__setattr__(self, "sensors", MappingProxyType(dict(self.sensors)))
        object.__setattr__(self, "elements", tuple(self.elements))
        object.__setattr__(self, "modes", tuple(self.modes))
        for name, mass in self.masses.items():
            checks.positive(f"mass of {name}", mass, self.unit_of("kg"))
        check_model(self)
        for name, mass in self.rigid_masses.items():
            checks.positive(f"mass of {name} less that of the modes", mass, self.unit_of("kg"))

    def unit_of(self, unit: str) -> str:
        """Return the unit that a quantity has here, by the one that it has in a translation."""
        return unit_in(unit, self.motion)

    def sensor_unit(self, sensor: Sensor) -> str:
        """Return the SI unit of the channel that is a sensor."""
        return self.unit_of(SENSOR_UNITS[sensor.measures])

    @property
    def drive_unit(self) -> str:
        """SI unit of the input; 1 where there is none."""
        return self.unit_of(self.excitation.unit)

    def __reduce__(self) -> tuple[type["Model"], tuple[object, ...]]:
        """Let a model travel to another process (a mapping proxy cannot)."""
        masses, sensors = dict(self.masses), dict(self.sensors)
        return Model, (
            self.title, masses, self.elements, self.excitation, sensors, self.modes,
            self.motion, dict(self.structures),
        )  # fmt: skip

    @property
    def scales(self) -> tuple[Scale, ...]:
        """Conditions of a test that scale elements, one for each of these."""
        return tuple(one.scaled_by for one in self.elements if one.scaled_by is not None)

    def under(self, conditions: Conditions) -> "Model":
        """Return the model of a test: that under the conditions of the test.

        Nothing scales it any more. A model that nothing scales is the same in every test.

        Raises
        ------
        ModelError
            If a condition that scales an element is not said, of another unit, or below 0.
        """
        if not self.scales:
            return self
        try:
            every = [one.under(conditions) for one in self.elements]
        except ModelError as error:
            raise ModelError(f"{self.title}: {error}") from error
        return replace(self, elements=tuple(one for one in every if one is not None))

    @property
    def rigid_masses(self) -> dict[str, float]:
        """Mass of each place less the masses of its further modes [kg]."""
        return {
            name: mass - sum(m.mass * m.participation.get(name, 0.0) ** 2 for m in self.modes)
            for name, mass in self.masses.items()
        }

    @property
    def moved_mass(self) -> float:
        """Mass that moves with the base, of structures as their modes tell it [kg]."""
        modal = (float((one.participations**2).sum()) for one in self.structures.values())
        return sum(self.masses.values()) + sum(modal)

    @property
    def places(self) -> tuple[str, ...]:
        """The base, every mass and every point of a structure."""
        return (BASE, *self.moving)

    @property
    def n_coordinates(self) -> int:
        """Number of masses and of modes of structures."""
        return len(self.masses) + sum(
            len(one.with_residuals) for one in self.structures.values()
        )

    @property
    def points(self) -> tuple[str, ...]:
        """Every point of a structure."""
        return tuple(p for one in self.structures.values() for p in one.points)

    @property
    def moving(self) -> tuple[str, ...]:
        """Every mass and every point of a structure."""
        return (*self.masses, *self.points)
