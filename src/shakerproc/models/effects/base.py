"""Interface of an effect: a force law with named parameters, and a multiple of one."""

import re
from abc import ABC, abstractmethod
from collections.abc import Callable, Mapping
from dataclasses import dataclass, fields, replace
from types import MappingProxyType
from typing import Any, ClassVar, Final, Literal, TypeAlias, TypeVar, final

from shakerproc import checks
from shakerproc.data import FloatArray
from shakerproc.models.identification import Identification, JointScales
from shakerproc.models.laws import Row
from shakerproc.models.motion import Motion, unit_in

Sign: TypeAlias = Literal["positive", "not negative", "any"]
Holds: TypeAlias = Literal["number", "numbers", "rows", "effects"]


@final
@dataclass(frozen=True, slots=True)
class Parameter:
    """Meaning, unit and limits of one parameter of an effect.

    Attributes
    ----------
    unit : str
        SI unit, as the model file writes it; ``1`` for none.
    symbol : str
        Letter in the formula.
    meaning : str
        A few words for the manual.
    linear : bool
        Whether the force is linear in it (jointly with the other linear ones).
    sign : {"positive", "not negative", "any"}
        Which values are physical.
    optional : bool
        Whether it may be left out (None).
    choices : tuple of str
        The words it may be, where it is a word and not a number.
    least : float, optional
        Its smallest value, where `sign` does not say it [unit].
    holds : {"number", "numbers", "rows", "effects"}
        A number (or a word), numbers in a row, rows of numbers, or effects.
    reference : bool
        Whether it only says where another number holds, so that no test can tell both.
    """

    unit: str
    symbol: str
    meaning: str
    linear: bool = False
    sign: Sign = "positive"
    optional: bool = False
    choices: tuple[str, ...] = ()
    least: float | None = None
    holds: Holds = "number"
    reference: bool = False

    @property
    def positive(self) -> bool:
        """Whether only values above 0 are physical."""
        return self.sign == "positive"


def parameter_in(parameter: Parameter, motion: Motion) -> Parameter:
    """Return a parameter with the unit that it has in a motion."""
    return replace(parameter, unit=unit_in(parameter.unit, motion))


@final
@dataclass(frozen=True, slots=True)
class Switch:
    """A surface on which the force law changes its formula.

    Attributes
    ----------
    variable : {"displacement", "velocity"}
        What is compared.
    at : float
        With which value [m or m/s].
    """

    variable: Literal["displacement", "velocity"]
    at: float


class AbstractEffect(ABC):
    """A force between two places that resists their relative motion.

    Displacement z is that of the second place minus that of the first of ``between``, and
    velocity v likewise; the force F acts on the second place as -F and on the first as +F.

    Attributes
    ----------
    kind : str
        Key in `EFFECTS` and in model files.
    parameters : mapping of str to Parameter
        Every field, in order.
    formula : str
        The law in one line of plain text.
    signature : str
        What betrays it in measurements, in one sentence.
    absolute : bool
        Whether its force depends on the absolute motion of the second place, and acts there
        alone, instead of on the relative motion of the two.
    """

    __slots__ = ()

    kind: ClassVar[str]
    parameters: ClassVar[Mapping[str, Parameter]]
    formula: ClassVar[str]
    signature: ClassVar[str]
    absolute: ClassVar[bool] = False

    def __post_init__(self) -> None:
        """Check the values; an effect with further conditions has a method of its own."""
        check_parameters(self, self.parameters)

    @abstractmethod
    def force_along(
        self, displacement: FloatArray, velocity: FloatArray, sample_rate: float
    ) -> FloatArray:
        """Return the force along a prescribed motion that starts with no memory [N].

        Parameters
        ----------
        displacement, velocity : (n_samples,) array
            The motion [m] and [m/s].
        sample_rate : float
            Samples per second [Hz].

        Returns
        -------
        (n_samples,) array
            Force [N].
        """

    @abstractmethod
    def rows(self) -> tuple[Row, ...]:
        """Return the lines of the kernels' table that make up this effect."""

    def remark(self, displacement: FloatArray, velocity: FloatArray) -> str | None:
        """Return the remark on a motion that this effect was put through, if any.

        Parameters
        ----------
        displacement, velocity : (n_samples,) array
            The relative motion [m] and [m/s].
        """
        del displacement, velocity
        return None

    @classmethod
    def estimated(cls) -> Mapping[str, Parameter]:
        """Return the meaning of the numbers of `Identification.numbers`, by name."""
        return cls.parameters

    @classmethod
    def of_numbers(cls, numbers: Mapping[str, float | str]) -> "AbstractEffect":
        """Return the effect with the numbers that `Identification.numbers` gives.

        Numbers are in the units of the parameters.

        Raises
        ------
        ValueError
            If it cannot have them.
        """
        return cls(**numbers)

    @classmethod
    def example(cls) -> "AbstractEffect | None":
        """Return one of realistic size, to draw and to try it; None where `EXAMPLES` has it."""
        return None

    @classmethod
    def identification(cls, at: JointScales) -> Identification | None:
        """Return how to look for this effect in a joint; None if it is never looked for.

        Parameters
        ----------
        at : JointScales
            How the joint moves.
        """
        del at
        return None


class AbstractMemorylessEffect(AbstractEffect):
    """An effect whose force depends on the present displacement and velocity alone."""

    __slots__ = ()

    @abstractmethod
    def force_at(self, displacement: FloatArray, velocity: FloatArray) -> FloatArray:
        """Return the force at these displacements [m] and velocities [m/s], an array [N].

        (Not called ``force``: that is a parameter of `power_law`.)
        """

    @abstractmethod
    def slopes(
        self, displacement: FloatArray, velocity: FloatArray
    ) -> tuple[FloatArray, FloatArray]:
        """Return the derivatives of the force by displacement [N/m] and velocity [N s/m]."""

    def switches(self) -> tuple[Switch, ...]:
        """Return the surfaces on which the law changes its formula; none if it is smooth."""
        return ()

    @final
    def force_along(
        self,
        displacement: FloatArray,
        velocity: FloatArray,
        sample_rate: float,
    ) -> FloatArray:
        return self.force_at(displacement, velocity)


class DependsOnSurroundings(ABC):
    """An effect that takes a number from the elements in parallel with it."""

    __slots__ = ()

    @abstractmethod
    def in_place(self, stiffness: float, mass: float) -> AbstractEffect:
        """Return the effect with its numbers filled in.

        Parameters
        ----------
        stiffness : float
            Stiffness of the springs between the same two places; where there is none, of the
            contact between them [N/m].
        mass : float
            Reduced mass of the two places, the base being infinitely heavy [kg].
        """


def check_parameters(effect: object, parameters: Mapping[str, Parameter]) -> None:
    """Pass an effect whose values are physical.

    Raises
    ------
    ValueError
        If a value is not what its `Parameter` allows, or missing.
    """
    for field in fields(effect):  # type: ignore[arg-type]
        parameter, value = parameters[field.name], getattr(effect, field.name)
        if value is None and parameter.optional:
            continue
        if parameter.choices:
            if value not in parameter.choices:
                wanted = " or ".join(parameter.choices)
                raise ValueError(f"{field.name} must be {wanted}, not {value!r}")
            continue
        _HELD[parameter.holds](field.name, value, parameter)


def _check_number(name: str, value: object, parameter: Parameter) -> None:
    if isinstance(value, bool) or not isinstance(value, (int, float)):
        raise ValueError(f"{name} must be a number [{parameter.unit}], not {value!r}")
    _CHECKS[parameter.sign](name, value, parameter.unit)
    if parameter.least is not None and value < parameter.least:
        raise ValueError(f"{name} must be at least {parameter.least:g}, not {value:g}")


def _check_numbers(name: str, value: object, parameter: Parameter) -> None:
    if not isinstance(value, tuple) or not value:
        raise ValueError(f"{name} must be numbers [{parameter.unit}], not {value!r}")
    for item in value:
        _check_number(name, item, parameter)


def _check_rows(name: str, value: object, parameter: Parameter) -> None:
    if not isinstance(value, tuple) or not value:
        raise ValueError(f"{name} must be rows of numbers [{parameter.unit}], not {value!r}")
    for row in value:
        _check_numbers(name, row, parameter)


def _check_effects(name: str, value: object, parameter: Parameter) -> None:
    if not isinstance(value, tuple) or not all(isinstance(e, AbstractEffect) for e in value):
        raise ValueError(f"{name} must be effects: {parameter.meaning}, not {value!r}")


_HELD: Mapping[Holds, Callable[[str, object, Parameter], None]] = {
    "number": _check_number,
    "numbers": _check_numbers,
    "rows": _check_rows,
    "effects": _check_effects,
}

_CHECKS = {
    "positive": checks.positive,
    "not negative": checks.not_negative,
    "any": checks.finite,
}


EffectT = TypeVar("EffectT", bound=AbstractEffect)

_FORCE: Final = re.compile(r"(?:N|kg)(?![A-Za-z])")
"""A unit that is proportional to force."""

UNSCALED: Final[Mapping[str, str]] = MappingProxyType({
    "stiffness_drift": "it changes the spring beside it; scale that",
    "general_bouc_wen": "its beta and gamma mean another loop at another force; take bouc_wen",
})


def times(effect: EffectT, factor: float) -> EffectT:
    r"""Return the effect whose force is a multiple of this one's, at every motion.

    .. math:: F(z, \dot z; s p_N, p) = s F(z, \dot z; p_N, p)

    where :math:`p_N` are the parameters whose unit holds newtons (or kilograms): a law whose
    units agree has no other way to answer.

    Parameters
    ----------
    effect : AbstractEffect
        The law.
    factor : float
        Above 0 [-].

    Raises
    ------
    ValueError
        If the factor is not above 0, or no number of the effect is one of force.
    """
    checks.positive("factor", factor, "-")
    if effect.kind in UNSCALED:
        raise ValueError(f"{effect.kind} cannot be scaled: {UNSCALED[effect.kind]}")
    scaled = {
        field.name: _multiple(value, factor)
        for field in fields(effect)  # type: ignore[arg-type]
        if (value := getattr(effect, field.name)) is not None
        and _is_of_force(effect, field.name)
    }
    if not scaled:
        names = ", ".join(effect.parameters)
        raise ValueError(f"{effect.kind} has no number with a unit of force to scale ({names})")
    return replace(effect, **scaled)  # type: ignore[type-var]


def _is_of_force(effect: AbstractEffect, name: str) -> bool:
    parameter = effect.parameters[name]
    return parameter.holds == "effects" or _FORCE.match(parameter.unit) is not None


def _multiple(value: Any, factor: float) -> Any:
    if isinstance(value, tuple):
        return tuple(_multiple(one, factor) for one in value)
    return _part(value, factor) if isinstance(value, AbstractEffect) else value * factor


def _part(effect: AbstractEffect, factor: float) -> AbstractEffect:
    """Return an element of a series, scaled; one without force, such as play, as it is."""
    forceless = not any(_is_of_force(effect, name) for name in effect.parameters)
    return effect if forceless else times(effect, factor)
