r"""Modes of a hammer test, from the samples of the blows that are kept.

Force and responses of a block obey the equations of the structure whatever it did before: what
still rings of earlier blows, and what a block cuts off, is a free decay of the same modes,
which the fit takes up as the transient of a record (`lines_of_samples`). So does any sum of
blocks.
The sum weighted by the forces,

.. math:: f = \sum_b a_b f_b / \sum_b a_b^2, \quad x = \sum_b a_b x_b / \sum_b a_b^2,

holds all that blows of one shape tell of the structure, with the noise of one record.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from typing import Final, final

import numpy as np
import scipy  # its parts load when they are first used

from shakerproc import spectra
from shakerproc.data import FloatArray, Recording
from shakerproc.modal.analysis import Functions
from shakerproc.modal.identification import BLOWS, identify_records, with_scatter
from shakerproc.modal.lines import lines_of_samples
from shakerproc.modal.modal_model import ModeSet, Settings, response_functions
from shakerproc.numerals import numeral
from shakerproc.runs import averaged_blows
from shakerproc.spectra import Crop, CrossSpectra
from shakerproc.spectra.blows import LOUD, Blow, Setup, windowed
from shakerproc.testlog import Test

Record = tuple[FloatArray, FloatArray]

RINGS: Final = 0.01
"""Share of a response at the end of its block from which on it is told [-]: 40 dB."""


@final
@dataclass(frozen=True, slots=True, eq=False)
class Struck:
    """The blows of a test.

    Attributes
    ----------
    cross : CrossSpectra
        Of the force, then of the responses, over the blows that are kept.
    records : tuple of ((1, n) array, (n_responses, n) array)
        Force [N] and responses [unit of the channel] of the block of each.
    forces : (n_blows,) array
        Largest force of each, with its sign [N].
    end_share : float
        Mean share of a response that is left at the end of its block [-].
    kept : str
        How many of how many.
    """

    cross: CrossSpectra
    records: tuple[Record, ...]
    forces: FloatArray
    end_share: float
    kept: str

    @property
    def mean(self) -> Record:
        """Force and responses of all blows, weighted by their forces, for a force of 1 N."""
        share = self.forces / np.sum(self.forces**2)
        force = np.einsum("b,bif->if", share, np.array([one[0] for one in self.records]))
        response = np.einsum("b,bif->if", share, np.array([one[1] for one in self.records]))
        return force, response

    def differs(self, other: "Struck") -> str:
        """Return the reason why blows of two tests make no one fit, and the remedy; or ""."""
        if self.cross.segment != other.cross.segment:
            return "length; give processing: {hammer: {length: ...}} for all of them"
        if not np.isclose(self.cross.decay_rate or 0.0, other.cross.decay_rate or 0.0):
            return "exponential window; give processing: {hammer: {exponential: ...}} for all"
        return ""

    @property
    def notes(self) -> Iterator[str]:
        """Notes on the blows used, and on how the fit takes a truncated decay into account."""
        yield self.kept
        rate = self.cross.decay_rate
        if self.end_share > RINGS:
            yield (
                f"{self.end_share:.0%} of a response is left at the end of the blocks. The fit "
                "allows for it, and for the ringing of earlier blows; the measured functions "
                "that are drawn do not"
            )
        if rate:
            yield (
                f"the exponential window ({numeral(rate, 4)} 1/s) is in the response functions "
                "that are drawn, not in the fit"
            )


def struck_of(recording: Recording, crop: Crop, test: Test, rows: list[int]) -> Struck:
    """Return the blows of a hammer test.

    Parameters
    ----------
    recording : Recording
        With one channel of the role force.
    crop : Crop
        Where blows are looked for.
    test : Test
        How blows are cut and windowed.
    rows : list of int
        Rows of the responses.

    Raises
    ------
    SpectrumError
        If no blow can be used.
    """
    cross, blows = averaged_blows(recording, crop, test)
    setup, cut = blows.setup, blows.setup.cut
    records = []
    for blow in blows.kept:
        start = blow.sample - cut.before
        block = windowed(recording.samples(start, start + cut.length), setup)
        records.append((_in_contact(block[setup.force], blow, setup)[np.newaxis], block[rows]))
    chosen = [setup.force, *rows]
    return Struck(
        cross.of(chosen),
        tuple(records),
        np.array([blow.force for blow in blows.kept]),
        blows.end_share,
        f"{len(blows.kept)} of {len(blows.blows)} blows are averaged",
    )


def _in_contact(force: FloatArray, blow: Blow, setup: Setup) -> FloatArray:
    """Return the force of a block, 0 further than a width of the pulse from all that is loud.

    A hammer that does not touch has no force. Its noise there would be an input without a
    response, the worst at resonances; noise of the time of a pulse is as smooth over frequency
    as the pulse, and bends no resonance.
    """
    loud = np.abs(force) > LOUD * setup.strikes.noise
    width = max(round(blow.width * setup.cut.sample_rate), 1)
    near = scipy.ndimage.maximum_filter1d(loud, 2 * width + 1, mode="constant")
    return np.where(near, force, 0.0)


def identify_blows(
    tests: Sequence[Struck], sample_rate: float, settings: Settings
) -> tuple[ModeSet, Functions]:
    """Return the modes of hammer tests, in one fit, and their response functions.

    Parameters
    ----------
    tests : sequence of Struck
        With the same sensors; each has a force of its own.
    sample_rate : float
        Samples per second [Hz].
    settings : Settings
        Band, number of modes, highest order.

    Returns
    -------
    ModeSet
        With intervals that are wider where tests, or the blows of a single one, scatter more
        than the lines about the model.
    Functions
        Measured and synthesised, both with the damping of an exponential window; an input for
        each test.

    Raises
    ------
    ValueError
        If the band holds too few lines.
    """
    records = [
        (np.concatenate([one.mean[0] if i == k else np.zeros_like(one.mean[0])
                         for i in range(len(tests))]), one.mean[1])
        for k, one in enumerate(tests)
    ]  # fmt: skip
    fewest = min(one.records[0][0].shape[1] for one in tests) / sample_rate
    n_lines = len(tests) * int(fewest * (settings.band[1] - settings.band[0]))
    highest = n_lines // (2 * len(tests) + 1)
    settings = replace(settings, order=min(settings.order, highest - highest % 2))
    modes = identify_records(records, sample_rate, settings)
    blows = tests[0].records
    if len(tests) == 1 and len(blows) > 1:
        each = [lines_of_samples(*one, sample_rate, settings.band) for one in blows]
        modes = replace(with_scatter(modes, each, BLOWS), scatter=None)
    modes = replace(modes, notes=(*modes.notes, *(x for one in tests for x in one.notes)))
    return modes, _functions(tests, modes, settings.band)


def _functions(tests: Sequence[Struck], modes: ModeSet, band: tuple[float, float]) -> Functions:
    """Return the response functions of blows, and those of the model with their window.

    Raises
    ------
    ValueError
        If there is no model.
    """
    if modes.model is None:
        raise ValueError("blows were fitted without a model")
    first = tests[0].cross
    shown = (first.frequency >= max(band[0], first.bin_width)) & (first.frequency <= band[1])
    outputs = range(1, first.n_channels)
    measured = [spectra.h1(one.cross, [0], outputs)[:, shown] for one in tests]
    coherence = [spectra.multiple_coherence(one.cross, [0], outputs)[:, shown] for one in tests]
    windowed_model = replace(modes.model, poles=modes.poles - (first.decay_rate or 0.0))
    return Functions(
        first.frequency[shown],
        np.stack(measured, axis=1),
        response_functions(windowed_model, first.frequency[shown]),
        np.min(coherence, axis=0),
    )
