"""Faults of sensors that only a model tells which leaves more than noise stay in doubt."""

from types import SimpleNamespace

import pytest

from shakerproc.diagnosis.data.sensor_faults import Hum
from shakerproc.diagnosis.estimate import Estimate
from shakerproc.diagnosis.result import Finding
from shakerproc.diagnosis.selection.faults import doubted

GAIN = Finding("sensor_gain", ("top",), {"gain": Estimate(0.9, 0.89, 0.91, "1")})
DELAY = Finding("sensor_delay", ("top",), {"delay": Estimate(5e-5, 4e-5, 6e-5, "s")})
CLIPPED = Finding("clipping", ("top",), {})
FAULTS = [GAIN, DELAY, CLIPPED]


def found(left, late=(), floor=0.01):
    return SimpleNamespace(
        data=SimpleNamespace(model=SimpleNamespace(sensors={"top": None})),
        late=late,
        floor_under=lambda _: floor,
        is_explained_by=lambda _: left <= 1.5 * floor,
    )


@pytest.mark.parametrize(
    ("of", "in_doubt"),
    [
        (found(0.01), []),
        (found(0.05), [GAIN, DELAY]),
        (found(0.05, late=(0.0,)), [GAIN, DELAY]),
        (found(0.05, late=(2e-2,)), [GAIN]),
        (found(0.05, floor=float("nan")), []),
    ],
    ids=["explained", "of a decay", "in time", "late before all else", "noise unknown"],
)
def test_what_is_left_doubts_gains_and_delays_that_were_not_seen_before(of, in_doubt):
    assert doubted(of, None, FAULTS) == in_doubt


@pytest.mark.parametrize(
    ("band", "counts"),
    [
        ((2.0, 15.0), False),
        ((20.0, 2000.0), True),
        ((80.0, 120.0), True),
        ((110.0, 140.0), False),
    ],
)
def test_hum_counts_where_the_mains_or_a_harmonic_lies_in_the_band(band, counts):
    assert Hum(0, 50.0).is_in(band) is counts
