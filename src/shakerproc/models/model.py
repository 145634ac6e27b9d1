"""A model: masses, the elements between them, what shakes it and what is measured."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from types import MappingProxyType
from typing import Final, Literal, TypeAlias, final

from shakerproc import checks
from shakerproc.models.effects.attached_mode import AttachedMode
from shakerproc.models.effects.base import AbstractEffect
from shakerproc.models.faults.base import AbstractFault
from shakerproc.models.mode import Mode
from shakerproc.models.soundness import check_model

BASE: Final = "base"
"""Name of the shaker table in ``between`` and ``at``."""

Measures: TypeAlias = Literal[
    "acceleration", "relative displacement", "relative velocity", "displacement", "velocity"
]
MEASURES: Final[tuple[Measures, ...]] = (
    "acceleration",
    "relative displacement",
    "relative velocity",
    "displacement",
    "velocity",
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
    """

    effect: AbstractEffect
    between: tuple[str, str]

    def __post_init__(self) -> None:
        between = tuple(self.between)
        if len(between) == 1 and isinstance(self.effect, AttachedMode):
            between = (BASE, *between)
        if len(between) != 2:
            raise ValueError(f"between must name two places, not {list(self.between)}")
        object.__setattr__(self, "between", between)


@final
@dataclass(frozen=True, slots=True)
class Sensor:
    """What one channel measures.

    Attributes
    ----------
    at : str
        Mass that it sits on, or ``base``.
    measures : str
        ``acceleration``, ``displacement`` and ``velocity`` are absolute; ``relative
        displacement`` and ``relative velocity`` are against the base.
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


@final
@dataclass(frozen=True, slots=True)
class Excitation:
    """What shakes the model.

    Attributes
    ----------
    kind : {"base acceleration", "force"}
        Absolute acceleration of the base [m/s^2], or a force [N].
    on : str, optional
        Mass that the force acts on.
    """

    kind: Literal["base acceleration", "force"]
    on: str | None = None

    def __post_init__(self) -> None:
        if self.kind not in {"base acceleration", "force"}:
            raise ValueError(f"kind must be base acceleration or force, not {self.kind!r}")
        if (self.kind == "force") != (self.on is not None):
            raise ValueError("a force needs the mass it acts on, a base acceleration none")


@final
@dataclass(frozen=True, slots=True)
class Model:
    """What is shaken.

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

    def __post_init__(self) -> None:
        object.__setattr__(self, "masses", MappingProxyType(dict(self.masses)))
        object.__setattr__(self, "sensors", MappingProxyType(dict(self.sensors)))
        object.__setattr__(self, "elements", tuple(self.elements))
        object.__setattr__(self, "modes", tuple(self.modes))
        for name, mass in self.masses.items():
            checks.positive(f"mass of {name}", mass, "kg")
        check_model(self)

    def __reduce__(self) -> tuple[type["Model"], tuple[object, ...]]:
        """Let a model travel to another process (a mapping proxy cannot)."""
        masses, sensors = dict(self.masses), dict(self.sensors)
        return Model, (
            self.title, masses, self.elements, self.excitation, sensors, self.modes
        )  # fmt: skip

    @property
    def places(self) -> tuple[str, ...]:
        """The base and every mass."""
        return (BASE, *self.masses)
