"""The bound that the benchmark prints, against its closed form for one mode that is alone."""

from math import erf, pi, sqrt

import numpy as np
import pytest
from benchmarks.modal_bounds import DRAWN, bound_of
from benchmarks.modal_signals import Structure

SECONDS, RATE = 20.0, 512.0


@pytest.mark.parametrize(("frequency", "damping"), [(100.0, 0.01), (60.0, 0.02)])
def test_damping_of_a_mode_that_is_alone_is_known_to_the_root_of_its_turns(frequency, damping):
    """1/sqrt(omega zeta T) of itself, whatever the number of sensors."""
    shape = np.sin(pi * np.arange(1, 9) / 9.0)[np.newaxis]
    samples = np.zeros((8, int(SECONDS * RATE)))
    structure = Structure(
        np.array([frequency]),
        np.array([damping]),
        shape,
        samples[:1],
        samples,
        RATE,
        (3,),
        np.full(8, 1e-2),
    )
    bound = bound_of(structure, (3.0, 205.0))
    share = erf(0.10 * sqrt(2.0 * pi * frequency * damping * SECONDS / 2.0))
    assert bound.loose == pytest.approx(share, abs=3.0 * sqrt(share * (1.0 - share) / DRAWN))
    assert bound.alike == 1.0
