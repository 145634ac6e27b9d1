"""Modes of a hammer test, from the response functions over the blows that are kept."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Final, final

import numpy as np
import scipy  # its parts load when they are first used
from numpy.typing import NDArray

from shakerproc import spectra
from shakerproc.data import FloatArray, Recording
from shakerproc.modal.analysis import Functions
from shakerproc.modal.identification import identify_functions
from shakerproc.modal.lines import Scatter, lines_of_functions
from shakerproc.modal.modal_model import response_functions
from shakerproc.modal.mode_set import ModeSet, Settings
from shakerproc.modal.scatter import with_scatter
from shakerproc.modal.stabilisation import frequency_of
from shakerproc.runs import averaged_blows
from shakerproc.spectra import Crop, CrossSpectra
from shakerproc.testlog import Test

FEWEST: Final = 3
"""Blows from which on their scatter tells the noise of a line."""

SMOOTHED: Final = 5
"""Lines over which that noise is smoothed: few blows tell it of one line badly."""


@final
@dataclass(frozen=True, slots=True, eq=False)
class Struck:
    """The blows of a test.

    Attributes
    ----------
    cross : CrossSpectra
        Of the force, then of the responses, over the blows that are kept.
    kept : str
        How many of how many.
    """

    cross: CrossSpectra
    kept: str

    @property
    def rate(self) -> float:
        """By how much the window makes all motion decay faster [1/s]."""
        return self.cross.decay_rate or 0.0

    def differs(self, other: "Struck") -> str:
        """Return what keeps blows of two tests from one fit, and the remedy; empty: nothing."""
        if self.cross.segment != other.cross.segment:
            return "length; give processing: {hammer: {length: ...}} for all of them"
        if not np.isclose(self.rate, other.rate):
            return "exponential window; give processing: {hammer: {exponential: ...}} for all"
        return ""


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
    chosen = [blows.setup.force, *rows]
    return Struck(
        cross.of(chosen),
        f"{len(blows.kept)} of {len(blows.blows)} blows are averaged",
    )


def identify_blows(tests: Sequence[Struck], settings: Settings) -> tuple[ModeSet, Functions]:
    """Return the modes of hammer tests, in one fit, and what was fitted.

    Parameters
    ----------
    tests : sequence of Struck
        With the same sensors and blocks; each has a force of its own.
    settings : Settings
        Band, number of modes, highest order.

    Returns
    -------
    ModeSet
        Without the damping that an exponential window adds.
    Functions
        Measured and synthesised, both with that damping; an input for each test.

    Raises
    ------
    ValueError
        If the band holds too few lines.
    """
    crosses = [test.cross for test in tests]
    first = crosses[0]
    outputs = range(1, first.n_channels)
    low, high = settings.band
    shown = (first.frequency >= max(low, first.bin_width)) & (first.frequency <= high)
    frequency = first.frequency[shown]
    measured = np.stack([spectra.h1(one, [0], outputs)[:, shown] for one in crosses], axis=1)
    highest = frequency.size // (len(tests) + len(outputs))
    order = min(settings.order, highest - highest % 2)
    settings = replace(settings, order=order)
    modes = identify_functions(frequency, measured, settings, _scatter(tests, shown))
    if len(tests) > 1:
        each = [
            lines_of_functions(frequency, measured[:, [k]], _scatter([one], shown))
            for k, one in enumerate(tests)
        ]
        modes = with_scatter(modes, each)
    if modes.model is None:
        raise ValueError("response functions were fitted without a model")
    synthesis = response_functions(modes.model, frequency).reshape(measured.shape)
    coherence = [spectra.multiple_coherence(one, [0], outputs)[:, shown] for one in crosses]
    functions = Functions(frequency, measured, synthesis, np.min(coherence, axis=0))
    kept = "; ".join(test.kept for test in tests)
    return _without_window(modes, tests[0].rate, kept), functions


def _scatter(tests: Sequence[Struck], shown: NDArray[np.bool_]) -> Scatter | None:
    """Return how functions scatter over the blows; None where there are too few of them.

    Their covariance is that of what the force does not explain, which sensors share where it
    is noise of the force; a window that takes most of a block ties neighbouring lines.
    """
    if min(test.cross.n_segments for test in tests) < FEWEST:
        return None
    n, n_lines = tests[0].cross.n_channels - 1, int(shown.sum())
    found = np.zeros((n, len(tests), n, len(tests), n_lines), dtype=np.complex128)
    for k, test in enumerate(tests):
        matrix = test.cross.matrix[..., shown]
        force = matrix[0, 0].real
        left = matrix[1:, 1:] - matrix[1:, :1] * matrix[:1, 1:] / force
        own = left.conj() / force / (test.cross.n_segments - 1)  # matrix is conj(X_i) X_j
        found[:, k, :, k] = scipy.ndimage.uniform_filter1d(own, SMOOTHED, axis=-1)
    square = tests[0].cross.window ** 2
    independent = float(square.sum() ** 2 / square.size / np.sum(square**2))
    size = n * len(tests)
    return Scatter(found.reshape(size, size, n_lines), independent)


def _without_window(modes: ModeSet, rate: float, kept: str) -> ModeSet:
    """Return modes that decay more slowly by the rate of a window [1/s]."""
    poles = modes.poles + rate
    share: FloatArray = np.abs(modes.poles.real / poles.real)
    notes = [kept]
    if rate:
        notes.append(
            f"the exponential window's {rate:.4g} 1/s are taken from the decay of every mode; "
            "the response functions that are drawn have them"
        )
    lost = ", ".join(f"{f:.4g} Hz" for f in frequency_of(poles[poles.real >= 0.0]))
    if lost:
        notes.append(
            f"no damping is left at {lost}: the exponential window adds all that was measured; "
            "take a longer block and a longer time constant"
        )
    return replace(
        modes,
        poles=poles,
        diagram=replace(modes.diagram, poles=modes.diagram.poles + rate),
        damping_error=modes.damping_error * share,
        scatter=(
            None
            if modes.scatter is None
            else modes.scatter * np.stack([np.ones_like(share), share])
        ),
        notes=(*modes.notes, *notes),
    )
