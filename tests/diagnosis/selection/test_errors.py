"""The free-run error of a diagnosis counts the band that `compare` counts."""

from dataclasses import replace

import numpy as np
from tests.diagnosis.one_mass import BAND, arrays_of, one_mass

from shakerproc.diagnosis.data import prepared
from shakerproc.diagnosis.estimation.data_set import DataSet
from shakerproc.diagnosis.estimation.least_squares import fit
from shakerproc.diagnosis.estimation.windows import whole_tests
from shakerproc.diagnosis.hypotheses.hypothesis import hypothesis_of
from shakerproc.diagnosis.selection.errors import scored_tests

HEARD = (BAND[0], 4.0 * BAND[1])


def test_harmonics_beyond_what_is_excited_are_counted_where_they_are_heard():
    given, none = arrays_of(one_mass())
    data = DataSet(one_mass(), prepared([replace(given, error_band=HEARD), none]))
    windows = whole_tests(data, held_out=False)
    linear = fit(data, hypothesis_of(one_mass()), np.zeros(2), windows, rounds=0)
    bands = [test.band for test in scored_tests(data, linear, windows).values()]
    assert bands == [HEARD, BAND]
