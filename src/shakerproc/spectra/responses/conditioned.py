"""Spectra without what some of the channels cause, so that inputs that act at once part."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from shakerproc.numerals import numeral
from shakerproc.spectra.responses.estimators import scaled_inputs
from shakerproc.spectra.welch.cross import CrossSpectra


def conditioned(spectra: CrossSpectra, given: Sequence[int]) -> CrossSpectra:
    r"""Return the spectra of all channels without what is linear in some of them.

    .. math:: S_{yz \cdot x} = S_{yz} - S_{yx} S_{xx}^{+} S_{xz}

    With all inputs but one given, H1 of what is left is that of several inputs at once
    (`h1_of_inputs`), and its coherence the partial coherence; H2 and Hv follow in the same way.

    Parameters
    ----------
    spectra : CrossSpectra
        Matrix of cross spectra.
    given : sequence of int
        Rows of the channels whose effects are taken away, from 0.

    Returns
    -------
    CrossSpectra
        Of the same channels, with an average less for each that is given; 0 for those.

    Raises
    ------
    ValueError
        If there are not more averages than channels that are given, and one.

    References
    ----------
    .. [1] J. S. Bendat and A. G. Piersol, "Random Data", 4th ed., Wiley, 2010, ch. 7.3.
    """
    averages = spectra.effective_averages - len(given)
    if not averages > 1.0:
        raise ValueError(
            f"{numeral(spectra.effective_averages)} averages do not tell {len(given) + 1} "
            "inputs apart"
        )
    s_xy, inverse, _ = scaled_inputs(spectra, given, range(spectra.n_channels))
    gains, rows = np.einsum("fgh,hjf->gjf", inverse, s_xy), list(spectra.inputs)
    left = spectra.matrix - np.einsum("gif,gjf->ijf", s_xy[:, rows].conj(), gains)
    density = spectra.density - np.einsum("gjf,gjf->jf", s_xy.conj(), gains).real
    left[[rows.index(i) for i in given]] = 0.0
    left[:, list(given)] = 0.0
    density[list(given)] = 0.0
    left[range(len(rows)), rows] = density[rows]
    return replace(spectra, matrix=left, density=density, effective_averages=averages)
