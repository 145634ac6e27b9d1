"""Motion of the shaker in a test, at the level that the log asks for."""

from abc import ABC, abstractmethod
from dataclasses import dataclass
from typing import Final, Literal, TypeAlias, final

import numpy as np

from shakerproc import checks
from shakerproc.data import FloatArray
from shakerproc.simulation.closed_forms import displacement_amplitude
from shakerproc.testlog import BROADBAND, Test
from shakerproc.testlog.excitation import FORCES, LEVELS

PEAK_FACTOR: Final = 3.0
"""Peak of random motion as a multiple of its rms value [-]; controllers clip at about 3."""

Quantity: TypeAlias = Literal["base acceleration", "force"]


@final
@dataclass(frozen=True, slots=True)
class TableMotion:
    """Largest motion of the shaker's table: amplitudes, or 3 sigma of random motion.

    Attributes
    ----------
    acceleration, velocity, displacement : float
        Zero to peak [m/s²], [m/s], [m].
    """

    acceleration: float
    velocity: float
    displacement: float


class AbstractInput(ABC):
    """Motion or force that drives a test, in a band of frequencies."""

    __slots__ = ()

    low: float
    high: float
    quantity: Quantity

    @property
    @abstractmethod
    def peak(self) -> float:
        """Largest value of the input itself: its amplitude, or 3 sigma [m/s² or N]."""

    @abstractmethod
    def largest_motion(self) -> TableMotion:
        """Return the largest motion of the table; only for base acceleration."""

    @abstractmethod
    def frequency_of_displacement(self, displacement: float) -> float:
        """Return the frequency above which less than a displacement is left [Hz].

        Of a sine, where its amplitude is the displacement [m]; of random motion, where 3 sigma
        of all that lies above is.
        """

    @abstractmethod
    def scaled(self, factor: float) -> "AbstractInput":
        """Return the input with so many times its amplitude [-]."""


@final
@dataclass(frozen=True, slots=True)
class SineInput(AbstractInput):
    """A sine, fixed, stepped or swept at constant amplitude.

    Attributes
    ----------
    amplitude : float
        Of acceleration [m/s²] or force [N].
    low, high : float
        Limits of its frequency, the same for a fixed one [Hz].
    quantity : {"base acceleration", "force"}
        What it is.
    """

    amplitude: float
    low: float
    high: float
    quantity: Quantity = "base acceleration"

    def __post_init__(self) -> None:
        checks.positive("amplitude", self.amplitude, "m/s²")
        checks.positive("low", self.low, "Hz")
        checks.not_negative("high - low", self.high - self.low, "Hz")

    @property
    def peak(self) -> float:
        return self.amplitude

    def displacement(self, frequency: FloatArray) -> FloatArray:
        """Return the amplitude of displacement at frequencies [Hz], an array (eq. 5.5) [m]."""
        return displacement_amplitude(np.asarray(self.amplitude), frequency)

    def largest_motion(self) -> TableMotion:
        omega = 2.0 * np.pi * self.low
        return TableMotion(self.amplitude, self.amplitude / omega, self.amplitude / omega**2)

    def frequency_of_displacement(self, displacement: float) -> float:
        checks.positive("displacement", displacement, "m")
        return float(np.sqrt(self.amplitude / displacement) / (2.0 * np.pi))

    def scaled(self, factor: float) -> "SineInput":
        return SineInput(factor * self.amplitude, self.low, self.high, self.quantity)


@final
@dataclass(frozen=True, slots=True)
class RandomInput(AbstractInput):
    r"""Random motion of constant density in a band.

    .. math:: \sigma_x^2 = \int_{f_1}^{f_2} \frac{S_a}{(2 \pi f)^4} df
              = \frac{S_a}{48 \pi^4} \left(f_1^{-3} - f_2^{-3}\right)

    Attributes
    ----------
    density : float
        One-sided [(m/s²)²/Hz] or [N²/Hz].
    low, high : float
        Limits of the band [Hz].
    quantity : {"base acceleration", "force"}
        What it is.
    """

    density: float
    low: float
    high: float
    quantity: Quantity = "base acceleration"

    def __post_init__(self) -> None:
        checks.positive("density", self.density, "(m/s²)²/Hz")
        checks.positive("low", self.low, "Hz")
        checks.positive("high - low", self.high - self.low, "Hz")

    @property
    def rms(self) -> float:
        """Root mean square of the input [m/s²] or [N]."""
        return float(np.sqrt(self.density * (self.high - self.low)))

    @property
    def peak(self) -> float:
        return PEAK_FACTOR * self.rms

    @property
    def rms_velocity(self) -> float:
        """Root mean square of the velocity of the table [m/s]."""
        square = self.density / (4.0 * np.pi**2) * (1.0 / self.low - 1.0 / self.high)
        return float(np.sqrt(square))

    @property
    def rms_displacement(self) -> float:
        """Root mean square of the displacement of the table [m]."""
        span = self.low**-3 - self.high**-3
        return float(np.sqrt(self.density * span / 3.0) / (4.0 * np.pi**2))

    def largest_motion(self) -> TableMotion:
        return TableMotion(
            PEAK_FACTOR * self.rms,
            PEAK_FACTOR * self.rms_velocity,
            PEAK_FACTOR * self.rms_displacement,
        )

    def frequency_of_displacement(self, displacement: float) -> float:
        checks.positive("displacement", displacement, "m")
        square = (displacement * 4.0 * np.pi**2 / PEAK_FACTOR) ** 2
        return float((self.high**-3 + 3.0 * square / self.density) ** (-1.0 / 3.0))

    def scaled(self, factor: float) -> "RandomInput":
        return RandomInput(factor**2 * self.density, self.low, self.high, self.quantity)


def input_of_test(test: Test) -> AbstractInput | None:
    """Return the input of a test; None where its log does not state it, or no law fits."""
    if test.level is None or test.level_unit is None or test.excitation == "sine on random":
        return None
    by_force = LEVELS[test.level_unit][1] in FORCES
    quantity: Quantity = "force" if by_force else "base acceleration"
    band = test.band
    if test.excitation in BROADBAND:
        if band is None or not band[0] < band[1]:
            return None
        rms = test.level_unit.endswith("rms")
        density = test.level**2 / (band[1] - band[0]) if rms else test.level
        return RandomInput(density, *band, quantity)
    if test.excitation in {"sine sweep", "stepped sine"} and band is not None:
        return SineInput(test.level, *band, quantity)
    if test.excitation == "sine" and test.frequency_hz is not None:
        return SineInput(test.level, test.frequency_hz, test.frequency_hz, quantity)
    return None
