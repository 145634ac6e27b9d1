"""Modes of a hammer test, from the response functions over the blows that are kept."""

from dataclasses import replace

import numpy as np

from shakerproc import spectra
from shakerproc.data import FloatArray, Recording
from shakerproc.modal.analysis import Functions
from shakerproc.modal.identification import identify_functions
from shakerproc.modal.modal_model import response_functions
from shakerproc.modal.mode_set import ModeSet, Settings
from shakerproc.modal.stabilisation import frequency_of
from shakerproc.runs import averaged_blows, find_crop
from shakerproc.spectra import CrossSpectra
from shakerproc.testlog import Test


def identify_blows(
    recording: Recording, test: Test, rows: list[int], settings: Settings
) -> tuple[ModeSet, CrossSpectra, Functions]:
    """Return the modes of a hammer test, its spectra, and what was fitted.

    Parameters
    ----------
    recording : Recording
        With one channel of the role force.
    test : Test
        How blows are cut and windowed.
    rows : list of int
        Rows of the responses.
    settings : Settings
        Band, number of modes, highest order.

    Returns
    -------
    ModeSet
        Without the damping that an exponential window adds.
    CrossSpectra
        Of the force, then of the responses.
    Functions
        Measured and synthesised, both with that damping.

    Raises
    ------
    SpectrumError
        If no blow can be used.
    ValueError
        If the band holds too few lines.
    """
    cross, blows = averaged_blows(recording, find_crop(recording, test), test)
    chosen = [blows.setup.force, *rows]
    cross = replace(cross, matrix=cross.matrix[np.ix_(chosen, chosen)])
    outputs = range(1, len(chosen))
    low, high = settings.band
    shown = (cross.frequency >= max(low, cross.bin_width)) & (cross.frequency <= high)
    frequency = cross.frequency[shown]
    measured = spectra.h1(cross, [0], outputs)[:, np.newaxis, shown]
    highest = frequency.size // (1 + len(rows))
    order = min(settings.order, highest - highest % 2)
    modes = identify_functions(frequency, measured, replace(settings, order=order))
    if modes.model is None:
        raise ValueError("response functions were fitted without a model")
    functions = Functions(
        frequency,
        measured,
        response_functions(modes.model, frequency),
        spectra.multiple_coherence(cross, [0], outputs)[:, shown],
    )
    kept = f"{len(blows.kept)} of {len(blows.blows)} blows are averaged"
    return _without_window(modes, cross.decay_rate or 0.0, kept), cross, functions


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
        notes=(*modes.notes, *notes),
    )
