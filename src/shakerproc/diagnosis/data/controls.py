"""Controls that disagree as those of a table that rocks: what drives the joint is between."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final, final

import numpy as np

from shakerproc.data import FloatArray
from shakerproc.diagnosis.data.tests import PreparedTest
from shakerproc.spectra import CrossSpectra, cross_spectra, psd

_SEGMENTS: Final = 24  # of a test, for its coherence
_FEWEST: Final = 2  # of a short one, which overlap by half


def spectra_of(test: PreparedTest, rows: FloatArray) -> CrossSpectra:
    """Return the cross-spectra of rows in the judged part of a test.

    Parameters
    ----------
    test : PreparedTest
        Which test.
    rows : (n_rows, n_samples) array
        As long as the test.
    """
    judged = rows[:, test.start : test.stop]
    length = judged.shape[1]
    segment = min(4096, max(256, length // _SEGMENTS), length // _FEWEST)
    return cross_spectra(judged, test.sample_rate, segment=segment)


WEIGHT: Final = 0.25
"""Standard deviation of the weight of a control about 1/n: half a table's length between two
controls, in the middle of which the joint may stand or not [-]."""

CONTRAST: Final = WEIGHT * float(np.sqrt(2.0))
"""The same along a contrast of two controls (see `contrasts`) [-]."""

COHERENT: Final = 0.5
"""Share of the power by which controls disagree that comes with their mean, from which on the
table rocks: most of it is not noise [-]."""


@final
@dataclass(frozen=True, slots=True, eq=False)
class Sways:
    """How controls disagree.

    Attributes
    ----------
    signals : tuple of (n, n_samples) array
        Differences of the controls of each test, as large as their mean; none where the table
        does not rock [unit of the input].
    spread : (n,) array
        Standard deviation of what each adds to the input, over it [-].
    """

    signals: tuple[FloatArray, ...]
    spread: FloatArray

    def weights(self, shares: FloatArray) -> FloatArray:
        """Return the weights of the controls from what each difference adds, (n + 1,) [-]."""
        n = shares.size + 1
        apart = shares * CONTRAST / self.spread
        return np.asarray(1.0 / n + contrasts(n) @ apart)


NO_SWAYS: Final = Sways((), np.zeros(0))
"""Controls that are taken as one."""


def contrasts(n_controls: int) -> FloatArray:
    """Return how weights change while their sum stays 1, (n_controls, n_controls - 1) [-]."""
    mean = np.full((n_controls, 1), 1.0 / np.sqrt(n_controls))
    found: FloatArray = np.linalg.svd(np.eye(n_controls) - mean @ mean.T)[0][:, :-1]
    return found


def sways_of(tests: Sequence[PreparedTest]) -> Sways:
    """Return how the controls of tests disagree, where most of that comes with their mean."""
    controls = [test.arrays.controls for test in tests]
    turned = contrasts(len(controls[0])).T
    apart = [turned @ (rows - rows.mean(axis=1, keepdims=True)) for rows in controls]
    means = [rows.mean(axis=0) for rows in controls]
    size = _rms([mean[None] for mean in means])
    sizes = _rms(apart)
    differ = len(turned) > 0 and bool(np.all(sizes > 0.0))
    if not differ or _coherent(tests, means, apart) < COHERENT:
        return NO_SWAYS
    scale = (size / sizes)[:, None]
    return Sways(tuple(scale * rows for rows in apart), CONTRAST * sizes / size)


def _rms(rows: Sequence[FloatArray]) -> FloatArray:
    """Return the rms of each row over all tests."""
    squares = sum(np.sum(one**2, axis=1) for one in rows)
    return np.asarray(np.sqrt(squares / sum(one.shape[1] for one in rows)))


def _coherent(
    tests: Sequence[PreparedTest], means: Sequence[FloatArray], apart: Sequence[FloatArray]
) -> float:
    """Return the share of the power of differences that comes with the mean [-]."""
    part, whole = 0.0, 0.0
    for test, mean, rows in zip(tests, means, apart, strict=True):
        cross = spectra_of(test, np.concatenate([mean[np.newaxis], rows]))
        power = psd(cross)
        low, high = test.band
        inside = (cross.frequency >= low) & (cross.frequency <= high) & (power[0] > 0.0)
        part += float(np.sum(np.abs(cross.matrix[0, 1:, inside].T) ** 2 / power[0, inside]))
        whole += float(np.sum(power[1:, inside]))
    return part / whole if whole > 0.0 else 0.0
