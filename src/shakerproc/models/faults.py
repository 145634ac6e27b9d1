"""Measurement faults: named, and never explained by physics."""

from abc import ABC, abstractmethod
from collections.abc import Mapping
from dataclasses import dataclass
from types import MappingProxyType
from typing import ClassVar, final

import numpy as np

from shakerproc.data import FloatArray
from shakerproc.models.effects.base import Parameter, check_parameters


class AbstractFault(ABC):
    """A fault of the measurement, which no physical effect explains.

    Attributes
    ----------
    kind : str
        Key in `FAULTS` and in model files.
    parameters : mapping of str to Parameter
        Every field, in order.
    formula : str
        What it does to the signal u, in one line.
    signature : str
        What betrays it in measurements, in one sentence.
    """

    __slots__ = ()

    kind: ClassVar[str]
    parameters: ClassVar[Mapping[str, Parameter]]
    formula: ClassVar[str]
    signature: ClassVar[str]

    def __post_init__(self) -> None:
        check_parameters(self, self.parameters)

    @abstractmethod
    def apply(self, samples: FloatArray, sample_rate: float) -> FloatArray:
        """Return the recorded signal in place of the true one.

        Parameters
        ----------
        samples : (n_samples,) array
            True signal in its SI unit.
        sample_rate : float
            Samples per second [Hz].

        Returns
        -------
        (n_samples,) array
            Recorded signal in the same unit.
        """


@final
@dataclass(frozen=True, slots=True)
class SensorDelay(AbstractFault):
    """Channel that is late against the others, as by a filter or a multiplexer.

    The delay is exact for a band-limited signal; the ends are treated as periodic.

    Attributes
    ----------
    delay : float
        Delay of the channel, below 0 where it is early [s].
    """

    kind: ClassVar[str] = "sensor_delay"
    formula: ClassVar[str] = "u(t - d)"
    signature: ClassVar[str] = (
        "The phase falls in proportion to frequency, the gain stays: a slope of the phase"
        " of every channel pair."
    )
    parameters: ClassVar[Mapping[str, Parameter]] = MappingProxyType({
        "delay": Parameter("s", "d", "delay of the channel", sign="any")
    })

    delay: float

    def apply(self, samples: FloatArray, sample_rate: float) -> FloatArray:
        frequency = np.fft.rfftfreq(samples.size, 1.0 / sample_rate)
        late = np.fft.rfft(samples) * np.exp(-2j * np.pi * frequency * self.delay)
        return np.fft.irfft(late, samples.size)


@final
@dataclass(frozen=True, slots=True)
class SensorGain(AbstractFault):
    """Channel whose sensitivity is not that of the log.

    Attributes
    ----------
    gain : float
        Recorded over true [-].
    """

    kind: ClassVar[str] = "sensor_gain"
    formula: ClassVar[str] = "g u"
    signature: ClassVar[str] = (
        "The gain is off by one factor at every frequency and level, where nothing should"
        " move against the table as well."
    )
    parameters: ClassVar[Mapping[str, Parameter]] = MappingProxyType({
        "gain": Parameter("1", "g", "recorded over true")
    })

    gain: float

    def apply(self, samples: FloatArray, sample_rate: float) -> FloatArray:
        return self.gain * samples


@final
@dataclass(frozen=True, slots=True)
class SensorPolarity(AbstractFault):
    """Channel with the wrong sign."""

    kind: ClassVar[str] = "sensor_polarity"
    formula: ClassVar[str] = "-u"
    signature: ClassVar[str] = (
        "The phase is 180 degrees at low frequency, where the coupon must follow the table."
    )
    parameters: ClassVar[Mapping[str, Parameter]] = MappingProxyType({})

    def apply(self, samples: FloatArray, sample_rate: float) -> FloatArray:
        return -samples


@final
@dataclass(frozen=True, slots=True)
class Clipping(AbstractFault):
    """Signal cut off where it exceeds the range of the amplifier.

    Attributes
    ----------
    level : float
        Largest value that is recorded, in the SI unit of the channel [m/s^2 or N].
    """

    kind: ClassVar[str] = "clipping"
    formula: ClassVar[str] = "u held to ±L"
    signature: ClassVar[str] = (
        "Flat tops at one value; odd harmonics at high level only, the same value in every run."
    )
    parameters: ClassVar[Mapping[str, Parameter]] = MappingProxyType({
        "level": Parameter("m/s^2", "L", "largest value recorded")
    })

    level: float

    def apply(self, samples: FloatArray, sample_rate: float) -> FloatArray:
        return np.clip(samples, -self.level, self.level)


@final
@dataclass(frozen=True, slots=True)
class MainsHum(AbstractFault):
    """Sine of the mains frequency, picked up by a ground loop; of phase 0 at the start.

    Attributes
    ----------
    frequency : float
        Frequency of the mains, or of a harmonic of it [Hz].
    amplitude : float
        Amplitude of the sine, in the SI unit of the channel [m/s^2 or N].
    """

    kind: ClassVar[str] = "mains_hum"
    formula: ClassVar[str] = "u + A sin 2π f t"
    signature: ClassVar[str] = (
        "A line at 50 or 60 Hz and its multiples that is there while nothing shakes."
    )
    parameters: ClassVar[Mapping[str, Parameter]] = MappingProxyType({
        "frequency": Parameter("Hz", "f", "frequency of the hum"),
        "amplitude": Parameter("m/s^2", "A", "amplitude of the hum"),
    })

    frequency: float
    amplitude: float

    def apply(self, samples: FloatArray, sample_rate: float) -> FloatArray:
        time = np.arange(samples.size) / sample_rate
        return samples + self.amplitude * np.sin(2.0 * np.pi * self.frequency * time)


FAULT_EXAMPLES: Mapping[str, AbstractFault] = MappingProxyType({
    example.kind: example
    for example in (
        SensorDelay(2e-5),
        SensorGain(1.1),
        SensorPolarity(),
        Clipping(50.0),
        MainsHum(50.0, 0.3),
    )
})
"""One fault of each kind, of a size that recordings have."""

FAULTS: Mapping[str, type[AbstractFault]] = MappingProxyType({
    kind: type(example) for kind, example in FAULT_EXAMPLES.items()
})
