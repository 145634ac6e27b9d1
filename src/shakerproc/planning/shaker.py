"""Motion of the shaker in a test, and the limits of its envelope."""

from abc import ABC, abstractmethod
from dataclasses import dataclass
from math import inf, pi
from typing import Final, Literal, TypeAlias, final

import numpy as np

from shakerproc import checks
from shakerproc.data import STANDARD_GRAVITY, FloatArray
from shakerproc.numerals import numeral
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


@final
@dataclass(frozen=True, slots=True)
class ShakerLimits:
    """Limits of a shaker, each zero to peak; random motion is compared with them by 3 sigma.

    Attributes
    ----------
    acceleration, velocity, displacement : float
        [m/s²], [m/s], [m]; half the stroke is the displacement. Infinite where unknown.
    force : float
        [N]; infinite where unknown.
    moving_mass : float
        What the force has to move besides the table's own springs; 0 where unknown [kg].
    """

    acceleration: float = inf
    velocity: float = inf
    displacement: float = inf
    force: float = inf
    moving_mass: float = 0.0

    def __post_init__(self) -> None:
        for name in ("acceleration", "velocity", "displacement", "force"):
            if not getattr(self, name) > 0.0:
                raise ValueError(f"{name} must be above 0, not {getattr(self, name):g}")

    @property
    def known(self) -> bool:
        """Whether there is any limit."""
        return min(self.by_force, self.velocity, self.displacement) < inf

    @property
    def by_force(self) -> float:
        """Largest acceleration, by itself and by the force over the moving mass [m/s²]."""
        moved = self.force / self.moving_mass if self.moving_mass > 0.0 else inf
        return min(self.acceleration, moved)

    def largest_acceleration(self, frequency: FloatArray) -> FloatArray:
        r"""Return the largest amplitude of a sine at frequencies [Hz], an array [m/s²].

        .. math:: \min(a, F / m, 2 \pi f v, (2 \pi f)^2 d)
        """
        omega = 2.0 * pi * frequency
        most = np.full_like(omega, self.by_force)
        if self.velocity < inf:
            most = np.minimum(most, omega * self.velocity)
        if self.displacement < inf:
            most = np.minimum(most, omega**2 * self.displacement)
        return most

    def crossovers(self) -> tuple[float, ...]:
        """Return the frequencies at which one limit hands over to the next [Hz], rising."""
        a, v, d = self.by_force, self.velocity, self.displacement
        if max(a, v, d) < inf and a * d > v * v:
            return v / (2.0 * pi * d), a / (2.0 * pi * v)
        if max(a, d) < inf:
            return ((a / d) ** 0.5 / (2.0 * pi),)
        if max(v, d) < inf:
            return (v / (2.0 * pi * d),)
        return (a / (2.0 * pi * v),) if max(a, v) < inf else ()

    def exceeded_by(self, shaken: AbstractInput) -> tuple[str, ...]:
        """Return the limits that the motion of the table exceeds, a clause each."""
        peak = "amplitude" if isinstance(shaken, SineInput) else "3 sigma"
        if shaken.quantity == "force":
            return tuple(self._too_much_force(shaken.peak, peak, ""))
        motion = shaken.largest_motion()
        texts = []
        if motion.acceleration > self.acceleration * (1.0 + 1e-9):
            texts.append(
                f"acceleration {numeral(motion.acceleration / STANDARD_GRAVITY)} g ({peak}) is "
                f"above the shaker's {numeral(self.acceleration / STANDARD_GRAVITY)} g"
            )
        if motion.velocity > self.velocity * (1.0 + 1e-9):
            texts.append(
                f"velocity {numeral(motion.velocity)} m/s ({peak}) is above the shaker's "
                f"{numeral(self.velocity)} m/s{self._from(shaken, 'velocity')}"
            )
        if motion.displacement > self.displacement * (1.0 + 1e-9):
            texts.append(
                f"displacement {numeral(1e3 * motion.displacement)} mm ({peak}) is above the "
                f"shaker's {numeral(1e3 * self.displacement)} mm"
                f"{self._from(shaken, 'displacement')}"
            )
        if self.moving_mass > 0.0:
            load = f" to move {numeral(self.moving_mass)} kg"
            texts += self._too_much_force(self.moving_mass * motion.acceleration, peak, load)
        return tuple(texts)

    def _too_much_force(self, force: float, peak: str, load: str) -> list[str]:
        if force <= self.force * (1.0 + 1e-9):
            return []
        most = f"the shaker's {numeral(self.force)} N"
        return [f"force {numeral(force)} N ({peak}){load} is above {most}"]

    def _from(self, shaken: AbstractInput, what: str) -> str:
        """Return from which frequency on a sine may be run."""
        if not isinstance(shaken, SineInput):
            return ""
        lowest = (
            shaken.amplitude / (2.0 * pi * self.velocity)
            if what == "velocity"
            else shaken.frequency_of_displacement(self.displacement)
        )
        return f"; possible from {numeral(lowest, 4)} Hz"
