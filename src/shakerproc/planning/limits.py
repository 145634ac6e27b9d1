"""Limits of the shaker: straight lines of its envelope on double-log paper."""

from dataclasses import dataclass
from math import inf, pi
from typing import final

import numpy as np

from shakerproc.data import STANDARD_GRAVITY, FloatArray
from shakerproc.numerals import numeral
from shakerproc.planning.inputs import AbstractInput, SineInput


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
        """Largest acceleration, by itself and by what the force can move [m/s²]."""
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
        found = []
        if motion.acceleration > self.acceleration * (1.0 + 1e-9):
            found.append(
                f"acceleration {numeral(motion.acceleration / STANDARD_GRAVITY)} g ({peak}) is "
                f"above the shaker's {numeral(self.acceleration / STANDARD_GRAVITY)} g"
            )
        if motion.velocity > self.velocity * (1.0 + 1e-9):
            found.append(
                f"velocity {numeral(motion.velocity)} m/s ({peak}) is above the shaker's "
                f"{numeral(self.velocity)} m/s{self._from(shaken, 'velocity')}"
            )
        if motion.displacement > self.displacement * (1.0 + 1e-9):
            found.append(
                f"displacement {numeral(1e3 * motion.displacement)} mm ({peak}) is above the "
                f"shaker's {numeral(1e3 * self.displacement)} mm"
                f"{self._from(shaken, 'displacement')}"
            )
        if self.moving_mass > 0.0:
            carried = f" to move {numeral(self.moving_mass)} kg"
            found += self._too_much_force(self.moving_mass * motion.acceleration, peak, carried)
        return tuple(found)

    def _too_much_force(self, force: float, peak: str, carried: str) -> list[str]:
        if force <= self.force * (1.0 + 1e-9):
            return []
        most = f"the shaker's {numeral(self.force)} N"
        return [f"force {numeral(force)} N ({peak}){carried} is above {most}"]

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
