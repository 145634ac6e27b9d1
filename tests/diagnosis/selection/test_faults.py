"""Faults of sensors that only a model tells which leaves more than noise stay in doubt."""

from types import SimpleNamespace

import numpy as np
import pytest

from shakerproc.diagnosis.data.sensor_faults import Hum
from shakerproc.diagnosis.estimate import Estimate
from shakerproc.diagnosis.result import Finding
from shakerproc.diagnosis.selection import faults
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
    ("deviation", "taken_out", "kinds"),
    [
        (0.01, False, ["sensor_gain", "sensor_delay"]),
        (0.1, False, []),
        (0.1, True, ["sensor_gain", "sensor_delay"]),
    ],
    ids=["surely off", "may be perfect", "taken out of the tests"],
)
def test_a_gain_or_delay_that_may_be_none_is_no_fault(deviation, taken_out, kinds, monkeypatch):
    monkeypatch.setattr(faults, "applied_gain", lambda _: 1.0)
    monkeypatch.setattr(faults, "applied_delay", lambda _: 0.0)
    model = SimpleNamespace(sensors={"top": None})
    fit = SimpleNamespace(
        hypothesis=SimpleNamespace(size=0, model=model), gain=np.array([0.9]),
        delay=np.array([1e-3]),
        uncertainty=SimpleNamespace(total=np.diag([deviation, 1e-2 * deviation]) ** 2),
    )  # fmt: skip
    search = SimpleNamespace(
        corrected=taken_out, late=(), signs=(), rigid=(), hums=(), linear_model=None,
        data=SimpleNamespace(tests=(), model=model),
    )  # fmt: skip
    assert [one.kind for one in faults.faults_of(search, fit)] == kinds


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
