"""Conditions of a test, such as a voltage or a preload, and effects that one of them scales."""

from collections.abc import Mapping
from dataclasses import dataclass
from types import MappingProxyType
from typing import Final, final

from shakerproc.errors import ModelError
from shakerproc.units import any_quantity, near_miss, quoted, to_si

NOTHING: Final = 1e-12
"""Share of its force with which an effect that remembers, or moves by itself, stands at a
condition of 0, so that the model has the same motions and states in every test: no simulation
shows it [-]."""


@final
@dataclass(frozen=True, slots=True)
class Conditions:
    """Conditions of a test: voltage of a damper, preload, temperature.

    Attributes
    ----------
    values : mapping of str to str
        Quantity with its unit, by the name of the condition.
    of : str
        What has them, such as ``test 2``, for messages.
    """

    values: Mapping[str, str]
    of: str = "conditions"


NO_CONDITIONS: Final = Conditions(MappingProxyType({}), "the test")
"""Those of a test of which nothing is said."""


@final
@dataclass(frozen=True, slots=True)
class Scale:
    r"""The condition that the force of an effect is proportional to.

    .. math:: F(z, \dot z; c) = \frac{c}{c_0} F(z, \dot z; c_0)

    Attributes
    ----------
    condition : str
        Its name, as tests state it.
    at : str
        Condition at which the numbers of the effect hold, :math:`c_0`, with its unit.
    """

    condition: str
    at: str

    def __post_init__(self) -> None:
        if not self.condition.strip():
            raise ValueError(
                "expected the name of a condition, such as voltage, before its value"
            )
        if any_quantity(self.at)[0] <= 0.0:
            raise ValueError(f"expected more than 0, got {quoted(self.at)}")

    def __str__(self) -> str:
        return f"{{{self.condition}: {self.at}}}"

    def share(self, conditions: Conditions) -> float:
        """Return the force under conditions over that at the reference, at least 0 [-].

        Raises
        ------
        ModelError
            If the condition is not said, of another unit, or below 0.
        """
        name, of = self.condition, conditions.of
        said = conditions.values.get(name)
        if said is None:
            meant = near_miss(name, list(conditions.values))
            hint = f"; did you mean its {meant}? Else add" if meant else "; add"
            raise ModelError(f"{of} says no {name}{hint} conditions: {self} to it")
        reference, unit = any_quantity(self.at)
        try:
            value = to_si(said, unit)
        except ValueError as error:
            raise ModelError(f"{name} of {of}: {error}") from error
        if value < 0.0:
            raise ModelError(
                f"{name} of {of} is {said}; a condition that scales an effect is at least 0. "
                "Where its channel has an offset, state it in the test, under conditions"
            )
        return value / reference


def share_of(scale: Scale | None, conditions: Conditions) -> float:
    """Return the force under conditions over that of an effect; 1 where none scales it [-]."""
    return 1.0 if scale is None else scale.share(conditions)
