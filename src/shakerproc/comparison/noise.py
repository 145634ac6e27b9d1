"""The noise of every channel of a test, from what was measured alone."""

from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import dataclass
from types import MappingProxyType
from typing import Final, final

import numpy as np
import scipy  # its parts load when they are first used

from shakerproc.comparison import noise_sources as sources
from shakerproc.data import FloatArray

UNKNOWN: Final = "unknown"
"""Source where nothing in the measurement tells its noise."""

LEFT: Final = "error that a model leaves"
"""Source of noise of the input where all others told too much: it makes no more than that."""

EXCESS: Final = 1.5
"""Error over the noise up to which it is taken for noise; to be calibrated [-]."""

AGREES: Final = 1.0 / EXCESS**2
"""Share of the last estimate of the noise of the input down to which it agrees with what a
model leaves [-]."""


@final
@dataclass(frozen=True, slots=True, eq=False)
class Noise:
    """Noise densities of one test.

    Attributes
    ----------
    frequency : (n_frequencies,) array
        From the first bin above 0 to half the sample rate [Hz].
    input : (n_frequencies,) array
        Of what drives the model: the mean of the controls, or the force
        [(m/s^2)^2/Hz or N^2/Hz].
    responses : (n_sensors, n_frequencies) array
        Of the responses [unit^2/Hz].
    source, input_source : str
        What told that of the responses and that of the input.
    """

    frequency: FloatArray
    input: FloatArray
    responses: FloatArray
    source: str
    input_source: str

    @property
    def known(self) -> bool:
        """Whether the noise of the responses is known."""
        return self.source != UNKNOWN

    @property
    def may_be_motion(self) -> bool:
        """Whether it was told beside what moves: harmonics and jumps of a motion count, too."""
        return bool({self.source, self.input_source} & {sources.ABOVE, sources.QUARTER})

    def responses_at(self, frequency: FloatArray) -> FloatArray:
        """Return the noise of the responses at other frequencies [Hz], [unit^2/Hz]."""
        return np.array([np.interp(frequency, self.frequency, row) for row in self.responses])

    def input_at(self, frequency: FloatArray) -> FloatArray:
        """Return the noise of the input at other frequencies [Hz], [(m/s^2)^2/Hz or N^2/Hz]."""
        return np.interp(frequency, self.frequency, self.input)

    def drawn(
        self, n_samples: int, sample_rate: float, generator: np.random.Generator
    ) -> FloatArray:
        """Return samples of noise with the density of the input, (n,) array [m/s^2 or N]."""
        return _drawn(self.input_at, n_samples, sample_rate, generator)

    def drawn_responses(
        self, n_samples: int, sample_rate: float, generator: np.random.Generator
    ) -> FloatArray:
        """Return samples with the densities of the responses, (n_sensors, n) array [unit]."""
        return _drawn(self.responses_at, n_samples, sample_rate, generator)


def _drawn(
    density_at: Callable[[FloatArray], FloatArray],
    n_samples: int,
    sample_rate: float,
    generator: np.random.Generator,
) -> FloatArray:
    length = scipy.fft.next_fast_len(n_samples, real=True)
    frequency = np.asarray(scipy.fft.rfftfreq(length, 1.0 / sample_rate), float)
    shape = np.sqrt(density_at(frequency) * sample_rate / 2.0)
    white = scipy.fft.rfft(generator.standard_normal((*shape.shape[:-1], length)))
    drawn: FloatArray = scipy.fft.irfft(white * shape, length)[..., :n_samples]
    return drawn


@final
@dataclass(frozen=True, slots=True)
class Refuted:
    """Sources of the noise of a test that told too much: a model leaves less.

    Attributes
    ----------
    responses, inputs : tuple of str
        Of the noise of the responses, and of that of the input.
    share : float
        Share of what the last one of the input told that the model leaves room for [-].
    """

    responses: tuple[str, ...] = ()
    inputs: tuple[str, ...] = ()
    share: float = 1.0

    @property
    def names(self) -> list[str]:
        """Every source once."""
        return list(dict.fromkeys((*self.responses, *self.inputs)))


NOT_REFUTED: Final = Refuted()
"""No source told too much."""


def noise_of(
    test: sources.Channels,
    twins: Sequence[sources.Channels] = (),
    refuted: Refuted = NOT_REFUTED,
) -> Noise:
    """Return the noise of a test, from what was measured alone, never from a model.

    That of the responses is what they hold at rest; where the recording has no rest, half of
    what differs between repeats of the test or of its period; else what a free decay holds
    beside its modes, or what is left above the excited band. That of several controls is what
    they do not have in common while they move.
    None is below what the recorder resolves.

    Parameters
    ----------
    test : Channels
        The test.
    twins : sequence of Channels
        Others of the campaign; those with the same drive are repeats.
    refuted : Refuted
        Sources that a model has beaten on what was held out; the next is taken. Where there is
        none, that of a rest or of a free decay stays: noise is no more than that, and so is
        what the model leaves. Of the input as much stays as makes what the model leaves.
    """
    frequency = sources.frequencies(test.sample_rate)
    resolved = sources.resolution(test)
    noise, source = _first(_RESPONSES, test, twins, refuted.responses)
    own = len(test.controls)
    drive, drive_source = _first(_INPUTS, test, twins, refuted.inputs)
    if refuted.inputs and (drive is None or drive_source in refuted.inputs):
        last, _ = _first({name: _INPUTS[name] for name in refuted.inputs[-1:]}, test, twins, ())
        drive = None if last is None or refuted.share == 0.0 else refuted.share * last
        drive_source = LEFT if refuted.share < AGREES else refuted.inputs[-1]
    if drive is None:
        drive, drive_source = np.zeros((1, frequency.size)), UNKNOWN
    least_drive = resolved[:own].sum() / own**2
    if least_drive > np.max(drive):
        drive_source = sources.RESOLUTION
    if noise is None:
        known = bool(np.all(resolved[own:] > 0.0))
        noise = np.zeros((len(test.responses), frequency.size))
        source = sources.RESOLUTION if known else UNKNOWN
    return Noise(
        frequency=frequency,
        input=np.maximum(drive[0], least_drive),
        responses=np.maximum(noise, resolved[own:, np.newaxis]),
        source=source,
        input_source=drive_source,
    )


EXCEEDS: Final = 4.0
"""A response stands out of its noise where its density is so many times as large [-]."""


def band_above(
    test: sources.Channels, noise: Noise, within: tuple[float, float]
) -> tuple[float, float] | None:
    """Return the band in which a response exceeds its noise, or None if nowhere [Hz]."""
    frequency = noise.frequency
    heard = sources.density(test.responses, test.sample_rate) > EXCEEDS * noise.responses
    inside = (frequency >= within[0]) & (frequency <= within[1]) & heard.any(axis=0)
    if not inside.any():
        return None
    width = float(frequency[0])
    low = max(within[0], float(frequency[inside].min()) - 0.5 * width)
    return low, min(within[1], float(frequency[inside].max()) + 0.5 * width)


_RESPONSES: Final = MappingProxyType({
    sources.QUIET: sources.responses_at_rest,
    sources.REPEATS: sources.responses_of_repeats,
    sources.QUARTER: sources.responses_of_decay,
    sources.ABOVE: sources.responses_above,
})
_UNDRIVEN: Final = (sources.QUARTER, sources.QUIET)
_INPUTS: Final = MappingProxyType({
    sources.DISAGREEMENT: sources.disagreement,
    sources.QUIET: sources.input_at_rest,
    sources.ABOVE: sources.input_above,
})


def _first(
    kinds: Mapping[str, sources.Source],
    test: sources.Channels,
    twins: Sequence[sources.Channels],
    refuted: Collection[str],
) -> tuple[FloatArray | None, str]:
    """Return the estimate of the first source that knows anything, and its name."""
    first = [name for name in kinds if name not in refuted]
    beaten = [name for name in _UNDRIVEN if name in kinds and name in refuted]
    for name in (*first, *beaten):
        density = kinds[name](test, twins)
        if density is not None:
            return density, name
    return None, UNKNOWN
