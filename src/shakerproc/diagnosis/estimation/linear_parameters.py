"""The numbers of the linear model, their priors, and what they make of model and channels."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from types import MappingProxyType
from typing import Final, final

import numpy as np

from shakerproc.data import ComplexArray, FloatArray
from shakerproc.diagnosis.data.controls import CONTRAST, contrasts
from shakerproc.diagnosis.estimation.linear_response import DrivenMode
from shakerproc.diagnosis.hypotheses.own_numbers import (
    OwnNumber,
    modal_numbers,
    own_names,
    with_values,
)
from shakerproc.models import Mode, Model
from shakerproc.models.laws import Law

PRIORS: Final[Mapping[str, float]] = MappingProxyType({
    "N/m": 0.3,
    "N s/m": 1.0,
    "1": 1.0,
})
"""Standard deviations of the logarithm of a model's own numbers, by unit: joints are known to
a third in stiffness and to a factor of e in damping (starting values) [-]."""

GAIN: Final = 0.01
"""Standard deviation of the logarithm of a sensor's gain: what calibration leaves [-]."""

SKEW: Final = 20e-6
"""Standard deviation of the time of a response against the controls: multiplexed converters,
filters of unequal sensors [s]."""

MODE_SHARE: Final = (0.02, 1.5)
"""Middle and standard deviation of the logarithm of a further mode's mass over what is left of
that of its place: 0.1 to 40 % [-]."""

MODE_DAMPING: Final = (0.01, 1.0)
"""Middle and standard deviation of the logarithm of its damping ratio: 0.14 to 7 % [-]."""


PARTICIPATION: Final = 1.0
"""Standard deviation of the participation of a mode that the drive alone excites: 1.6 and -0.9
are those of the tip of a beam in its first two [-]."""


@final
@dataclass(frozen=True, slots=True, eq=False)
class Chain:
    """Chain of measurement between the motion and the samples.

    Attributes
    ----------
    gains : (n_sensors,) array
        Of the responses, relative to the input [-].
    delays : (n_sensors,) array
        By which the responses lag behind the input [s].
    weights : (n_controls,) array
        Of the controls in what drives the model; their sum is 1 [-].
    """

    gains: FloatArray
    delays: FloatArray
    weights: FloatArray

    def responses(self, frequency: FloatArray) -> ComplexArray:
        """Return gain and delay of every sensor at [Hz], (n_sensors, n) array [-]."""
        turn = np.exp(-2j * np.pi * frequency * self.delays[:, np.newaxis])
        return np.asarray(turn * self.gains[:, np.newaxis])


@final
@dataclass(frozen=True, slots=True)
class Coordinate:
    """One unknown of the linear fit, 0 at its prior.

    Attributes
    ----------
    name : str
        For people.
    unit : str
        Of the number that it stands for.
    spread : float
        Standard deviation of the prior.
    step : float
        For slopes.
    """

    name: str
    unit: str
    spread: float
    step: float


@final
class LinearParameters:
    """The unknowns of the linear fit: own numbers, chain of measurement, further modes.

    Parameters
    ----------
    model : Model
        The prior.
    n_controls : int
        Channels that drive it.
    places : sequence of (str or None, float)
        Mass at which each further mode sits, None of one that the drive alone excites, and the
        frequency around which it is sought [Hz].
    """

    def __init__(
        self, model: Model, n_controls: int, places: Sequence[tuple[str | None, float]] = ()
    ) -> None:
        self.model, self.places = model, tuple(places)
        self.n_controls, self.n_sensors = n_controls, len(model.sensors)
        self.own = _own_numbers(model)
        self.contrasts = contrasts(n_controls)
        self.coordinates = (
            *(self._own(number) for number in self.own),
            *(Coordinate(f"gain of {s}", "1", GAIN, 1e-5) for s in model.sensors),
            *(Coordinate(f"delay of {s}", "s", SKEW, 1e-8) for s in model.sensors),
            *(
                Coordinate(f"weight of control {i + 1}", "1", CONTRAST, 1e-4)
                for i in range(n_controls - 1)
            ),
            *(
                Coordinate(f"{what} of the mode at {frequency:.4g} Hz", unit, spread, 1e-4)
                for place, frequency in self.places
                for what, unit, spread in (
                    ("frequency", "Hz", 0.05),
                    ("damping ratio", "1", MODE_DAMPING[1]),
                    *(
                        [(f"participation of {s}", "1", PARTICIPATION) for s in model.sensors]
                        if place is None
                        else [("mass", "kg", MODE_SHARE[1])]
                    ),
                )
            ),
        )

    def _own(self, number: OwnNumber) -> Coordinate:
        model, unit = self.model, number.unit(self.model)
        # what holds a structure is the least known of it, its modes are the best
        spread = number.spread if model.structures else PRIORS[unit]
        if number.element is None:
            (name,) = own_names(model, (number,))
            return Coordinate(name, unit, spread, 1e-5)
        element = model.elements[number.element]
        between = " and ".join(element.between)
        name = f"{number.name} of the {element.effect.kind} between {between}"
        return Coordinate(name, unit, spread, 1e-5)

    @property
    def spreads(self) -> FloatArray:
        """Standard deviations of the priors, (n,) array."""
        return np.array([c.spread for c in self.coordinates])

    def model_at(self, values: FloatArray) -> Model:
        """Return the model with its own numbers and further modes."""
        factors = np.exp(values[: len(self.own)])
        own = [n.value(self.model) * x for n, x in zip(self.own, factors, strict=True)]
        found = with_values(self.model, self.own, own)
        return (
            replace(found, modes=(*found.modes, *self._modes(values))) if self.places else found
        )

    def size_of(self, place: str | None) -> int:
        """Return how many numbers a further mode has at a place."""
        return 3 if place is not None else 2 + self.n_sensors

    @property
    def n_of_modes(self) -> int:
        """How many numbers all further modes have; they are the last."""
        return sum(self.size_of(place) for place, _ in self.places)

    def heaviest(self, values: FloatArray) -> float:
        """Return the largest mass of the modes of one place over what is left of it [-]."""
        return max(self._shares(values)[1].values(), default=0.0)

    def _shares(self, values: FloatArray) -> tuple[list[float], dict[str, float]]:
        """Return the mass of each mode over what is left of its place, and their sums [-]."""
        at = [(place, own[2]) for place, _, own in self._attached(values)]
        shares = [MODE_SHARE[0] * float(np.exp(share)) for _, share in at]
        whole = {place: 0.0 for place, _ in at}
        for (place, _), share in zip(at, shares, strict=True):
            whole[place] += share
        return shares, whole

    def _of_modes(self, values: FloatArray) -> list[tuple[str | None, float, FloatArray]]:
        """Return place, frequency [Hz] and values of each further mode."""
        found, first = [], len(values) - self.n_of_modes
        for place, frequency in self.places:
            last = first + self.size_of(place)
            found.append((place, frequency, values[first:last]))
            first = last
        return found

    def _modes(self, values: FloatArray) -> list[Mode]:
        """Return the further modes: together they never take all of the mass of a place."""
        shares, whole = self._shares(values)
        rigid = self.model.rigid_masses
        return [
            Mode(*_tuned(frequency, own), rigid[at] * share / (1.0 + whole[at]), {at: 1.0})
            for (at, frequency, own), share in zip(self._attached(values), shares, strict=True)
        ]

    def _attached(self, values: FloatArray) -> list[tuple[str, float, FloatArray]]:
        """Return, as `_of_modes`, those that sit at a mass."""
        every = self._of_modes(values)
        return [(at, frequency, own) for at, frequency, own in every if at is not None]

    def driven(self, values: FloatArray) -> tuple[DrivenMode, ...]:
        """Return the further modes that the drive alone excites."""
        return tuple(
            DrivenMode(*_tuned(frequency, own), own[2:])
            for place, frequency, own in self._of_modes(values)
            if place is None
        )

    def last_mode(self, values: FloatArray) -> tuple[float, float]:
        """Return natural frequency [Hz] and damping ratio [-] of the mode that came last."""
        _, frequency, own = self._of_modes(values)[-1]
        return _tuned(frequency, own)

    def chain_at(self, values: FloatArray) -> Chain:
        """Return the chain of measurement."""
        first = len(self.own)
        gains, delays = (
            values[first + k * self.n_sensors : first + (k + 1) * self.n_sensors]
            for k in range(2)
        )
        at = first + 2 * self.n_sensors
        weights = np.full(self.n_controls, 1.0 / self.n_controls)
        weights = weights + self.contrasts @ values[at : at + self.n_controls - 1]
        return Chain(np.exp(gains), delays, weights)

    def with_mode(self, place: str | None, frequency: float) -> "LinearParameters":
        """Return the parameters with one more mode."""
        return LinearParameters(self.model, self.n_controls, (*self.places, (place, frequency)))


def _tuned(frequency: float, own: FloatArray) -> tuple[float, float]:
    """Return natural frequency [Hz] and damping ratio [-] by the first values of a mode."""
    return frequency * float(np.exp(own[0])), MODE_DAMPING[0] * float(np.exp(own[1]))


def _own_numbers(model: Model) -> list[OwnNumber]:
    """Return every number of the springs, the dampers and the modes that is not 0."""
    found = []
    for i, element in enumerate(model.elements):
        try:
            laws = {row.law for row in element.effect.rows()}
        except ValueError:  # takes a number from what it stands in parallel with
            laws = {Law.LINEAR}
        if laws != {Law.LINEAR}:
            continue
        for name, parameter in element.effect.parameters.items():
            value = getattr(element.effect, name)
            if value is not None and value != 0.0 and parameter.unit in PRIORS:
                found.append(OwnNumber(i, name))
    return [*found, *modal_numbers(model)]
