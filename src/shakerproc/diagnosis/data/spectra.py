"""Cross-spectra of what was recorded in a test, for its coherence."""

from typing import Final

from shakerproc.data import FloatArray
from shakerproc.diagnosis.data.tests import Test
from shakerproc.spectra import CrossSpectra, cross_spectra

_SEGMENTS: Final = 24  # of a test, for its coherence
_FEWEST: Final = 2  # of a short one, which overlap by half


def spectra_of(test: Test, rows: FloatArray) -> CrossSpectra:
    """Return the cross-spectra of rows in the judged part of a test.

    Parameters
    ----------
    test : Test
        Which test.
    rows : (n_rows, n_samples) array
        As long as the test.
    """
    judged = rows[:, test.start : test.stop]
    length = judged.shape[1]
    segment = min(4096, max(256, length // _SEGMENTS), length // _FEWEST)
    return cross_spectra(judged, test.sample_rate, segment=segment)
