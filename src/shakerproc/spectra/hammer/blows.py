"""Blows of a hammer: how their blocks are cut and windowed, and what is known of each.

The blocks of all blows that are kept are the segments of which the spectra are averages. An
exponential window multiplies force and responses alike, which is exact: it moves every pole
to the left, so that the response functions are those of the structure with more damping,
known and taken away again where damping is read.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final, final

import numpy as np

from shakerproc.data import FloatArray
from shakerproc.spectra.hammer.strikes import Strikes

LEAST_QUIET: Final = 8
"""Samples before a blow from which on their standard deviation is taken for the noise [-]: that
of eight is known to a quarter, 1/sqrt(2 (n - 1)), the one of two to nothing."""


@final
@dataclass(frozen=True, slots=True)
class BlockCut:
    """How a block is cut around a blow and windowed.

    Attributes
    ----------
    before, length : int
        Samples of a block before the trigger, and all of them.
    force_window : int, optional
        Samples from the trigger on after which the force is set to 0.
    decay_rate : float
        Of the exponential window, the reciprocal of its time constant [1/s]; 0 without one.
    sample_rate : float
        Samples per second [Hz].
    """

    before: int
    length: int
    force_window: int | None
    decay_rate: float
    sample_rate: float

    @property
    def quiet(self) -> int:
        """Samples at the start of a block that the pulse, begun before the trigger, spares."""
        return self.before // 2

    @property
    def force_part(self) -> slice:
        """Samples of a block in which the force is kept."""
        if self.force_window is None:
            return slice(0, self.length)
        return slice(max(self.before - self.force_window, 0), self.before + self.force_window)

    @property
    def window(self) -> FloatArray:
        """Weights of every channel, (length,) array [-]."""
        steps = np.arange(self.length)
        return np.asarray(np.exp(-self.decay_rate / self.sample_rate * steps), dtype=float)


@final
@dataclass(frozen=True, slots=True, eq=False)
class Setup:
    """Facts of a whole hammer test, by which each of its blows is judged.

    Attributes
    ----------
    force : int
        Row of the force.
    names : tuple of str
        Of the channels.
    ends : (2, n_channels) array
        Low and high end of the range of each channel, as `range_ends` [unit of the channel].
    strikes : Strikes
        Where the force strikes.
    cut : BlockCut
        How blocks are cut.
    rest : (n_channels,) array
        Standard deviation of each channel where it is quietest before a blow, 0 where it is not
        known [unit of the channel].
    """

    force: int
    names: tuple[str, ...]
    ends: FloatArray
    strikes: Strikes
    cut: BlockCut
    rest: FloatArray


@final
@dataclass(frozen=True, slots=True)
class Blow:
    """One blow.

    Attributes
    ----------
    sample : int
        Where it reaches the trigger.
    force : float
        Largest force, with its sign [N].
    width : float
        Time for which the force is above half of that [s].
    reason : str
        Why it is rejected; empty where it is kept.
    left : float
        Rms of the response at the end of the block over its largest value, the largest of
        all responses [-].
    silent : tuple of str
        Channels that do not respond.
    """

    sample: int
    force: float
    width: float
    reason: str
    left: float
    silent: tuple[str, ...] = ()

    @property
    def kept(self) -> bool:
        """Whether it is averaged."""
        return not self.reason


@final
@dataclass(frozen=True, slots=True, eq=False)
class Blows:
    """The blows of a run.

    Attributes
    ----------
    setup : Setup
        How they were found and cut; `setup.force` is the row of the force.
    blows : tuple of Blow
        All of them; samples count from the start of the recording.
    pulses : (n_kept, n) array
        Force of the blows that are kept, around the trigger [N].
    noise : (n_channels,) array
        Rms before these blows, the mean taken away, as it was before any window [unit of the
        channel]; not a number where fewer than `LEAST_QUIET` samples lie there.
    """

    setup: Setup
    blows: tuple[Blow, ...]
    pulses: FloatArray
    noise: FloatArray

    @property
    def kept(self) -> list[Blow]:
        """Those that are averaged."""
        return [blow for blow in self.blows if blow.kept]

    @property
    def left(self) -> float:
        """Mean share of a response that is left at the end of the blocks that are kept [-]."""
        return float(np.mean([blow.left for blow in self.kept]))

    @property
    def noise_density(self) -> FloatArray:
        """Density of white noise in the windowed blocks, (n_channels,) array [unit²/Hz]."""
        cut, power = self.setup.cut, self.setup.cut.window**2
        density = 2.0 / cut.sample_rate * self.noise**2
        density[self.setup.force] *= power[cut.force_part].sum() / power.sum()
        return np.asarray(density)


def windowed(block: FloatArray, setup: Setup) -> FloatArray:
    """Return a block without offsets, its force windowed; not yet the exponential window.

    Parameters
    ----------
    block : (n_channels, length) array
        Samples of the block [unit of the channel].
    setup : Setup
        How it was cut, and where the force rests.

    Returns
    -------
    (n_channels, length) array
        The mean of the quiet part before the trigger taken away from every channel, where there
        is none the rest from the force alone; the force 0 outside its window.
    """
    cut, force = setup.cut, setup.force
    result = np.array(block, dtype=np.float64)
    if cut.quiet:
        result -= block[:, : cut.quiet].mean(axis=1, keepdims=True)
    else:
        result[force] -= setup.strikes.offset
    result[force, : cut.force_part.start] = 0.0
    result[force, cut.force_part.stop :] = 0.0
    return result


def noise_before(blocks: Sequence[FloatArray]) -> FloatArray:
    """Return the rms of every channel before blows, the mean of each taken away.

    Parameters
    ----------
    blocks : sequence of (n_channels, n_quiet) arrays
        The quiet part before each blow [unit of the channel].

    Returns
    -------
    (n_channels,) array
        Not a number where these are fewer than `LEAST_QUIET` samples each.
    """
    quiet = np.asarray(blocks)
    if quiet.shape[-1] < LEAST_QUIET:
        return np.full(quiet.shape[1], np.nan)
    return np.asarray(np.sqrt(quiet.var(axis=-1, ddof=1).mean(axis=0)))
