"""What is told of a test: rms, largest value and peak frequency of responses, joints, drive."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Final, Literal, TypeAlias, final

import numpy as np

from shakerproc.data import FloatArray
from shakerproc.forecast.extremes import largest_in
from shakerproc.forecast.motion import Motion
from shakerproc.models import BASE, Model
from shakerproc.spectra import cross_spectra, find_peaks, psd

Whose: TypeAlias = Literal["response", "joint", "force", "shaker"]
What: TypeAlias = Literal[
    "rms", "peak", "peak_frequency_hz", "displacement", "force", "velocity", "acceleration"
]

SEGMENTS: Final = 24
"""Welch segments at least of the density of a test, as `compare` keeps them [-]."""

LONGEST_SEGMENT: Final = 8192
"""Samples of a Welch segment at most."""


@final
@dataclass(frozen=True, slots=True)
class Quantity:
    """One number that is told of a test.

    Attributes
    ----------
    whose : {"response", "joint", "force", "shaker"}
        A sensor, a joint, the force into the specimen, or the table of the shaker.
    name : str
        Sensor, or the places of the joint as ``base-coupon``.
    what : str
        Which number; of joint, force and shaker the largest size in the whole duration.
    unit : str
        SI unit.
    """

    whose: Whose
    name: str
    what: What
    unit: str


Values: TypeAlias = Mapping[Quantity, float]


def values_of_response(
    name: str,
    unit: str,
    samples: FloatArray,
    spectrum: "Density",
    longer: float = 1.0,
    chance: float = 0.5,
) -> dict[Quantity, float]:
    """Return rms, largest value and peak frequency of a response.

    Parameters
    ----------
    name, unit : str
        Of the sensor.
    samples : (n,) array
        Within the compared band [unit].
    spectrum : Density
        Of the same samples.
    longer : float
        Duration that the largest value is of, over that of the samples [-].
    chance : float
        See `largest_in` [-].
    """
    return {
        Quantity("response", name, "rms", unit): float(np.std(samples)),
        Quantity("response", name, "peak", unit): largest_in(samples, longer, chance),
        Quantity("response", name, "peak_frequency_hz", "Hz"): spectrum.peak_frequency,
    }


@final
@dataclass(frozen=True, slots=True, eq=False)
class Density:
    """Power spectral density of one response.

    Attributes
    ----------
    frequency : (n_frequencies,) array
        From 0 [Hz].
    values : (n_frequencies,) array
        One-sided [unit^2/Hz].
    band : (float, float)
        What is excited [Hz].
    """

    frequency: FloatArray
    values: FloatArray
    band: tuple[float, float]

    @property
    def peak_frequency(self) -> float:
        """Frequency of the largest peak in the excited band [Hz]."""
        peaks = find_peaks(self.frequency, self.values, self.band, count=1)
        if peaks:
            return peaks[0].frequency
        inside = (self.frequency >= self.band[0]) & (self.frequency <= self.band[1])
        return float(self.frequency[np.argmax(np.where(inside, self.values, -1.0))])


def densities(
    rows: FloatArray, sample_rate: float, band: tuple[float, float]
) -> tuple[Density, ...]:
    """Return the density of each row.

    Parameters
    ----------
    rows : (n_rows, n) array
        Samples [any unit].
    sample_rate : float
        Samples per second [Hz].
    band : (float, float)
        What is excited [Hz].
    """
    n = rows.shape[1]
    segment = min(LONGEST_SEGMENT, 2 ** int(np.log2(max(n // SEGMENTS, 64))), n)
    found = cross_spectra(rows, sample_rate, segment=segment, window="hann", inputs=[0])
    return tuple(Density(found.frequency, one, band) for one in psd(found))


def values_of_motion(
    model: Model,
    motion: Motion,
    band: tuple[float, float],
    longer: float,
    generator: np.random.Generator,
    carried: float | None = None,
) -> tuple[dict[Quantity, float], tuple[Density, ...]]:
    """Return all quantities of a simulated test, and the densities of its responses.

    Parameters
    ----------
    model : Model
        What was shaken.
    motion : Motion
        What it did.
    band : (float, float)
        What is excited [Hz].
    longer : float
        Duration of the test over that of the motion [-].
    generator : numpy.random.Generator
        Where the largest value of what was not simulated comes from.
    carried : float, optional
        Mass that the shaker moves besides the model; None where it is not known [kg].
    """
    rows = np.array([motion.responses[name] for name in motion.responses])
    spectra = densities(rows, motion.sample_rate, band)
    found: dict[Quantity, float] = {}
    for (name, samples), spectrum in zip(motion.responses.items(), spectra, strict=True):
        unit = model.sensor_unit(model.sensors[name])
        own = values_of_response(name, unit, samples, spectrum, longer, generator.random())
        found |= own
    metre, newton = model.unit_of("m"), model.unit_of("N")
    into = np.zeros(motion.drive.size)
    for (first, second), joint in motion.joints.items():
        name = f"{first}-{second}"
        for what, samples, unit in (
            ("displacement", joint.displacement, metre), ("force", joint.force, newton)
        ):  # fmt: skip
            size = largest_in(samples, longer, generator.random())
            found[Quantity("joint", name, what, unit)] = size  # type: ignore[arg-type]
        into = into + joint.force * (float(first == BASE) - float(second == BASE))
    if not model.excitation.moves_base:
        into = motion.drive
    found[Quantity("force", "", "force", newton)] = largest_in(into, longer, generator.random())
    for what, samples, unit in motion.table:
        size = largest_in(samples, longer, generator.random())
        found[Quantity("shaker", "", what, unit)] = size  # type: ignore[arg-type]
        if what == "acceleration" and carried is not None:
            pushed = largest_in(carried * samples - into, longer, generator.random())
            found[Quantity("shaker", "", "force", newton)] = pushed
    return found, spectra
