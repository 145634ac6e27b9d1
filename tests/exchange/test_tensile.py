"""Tensile runs against the Octave reference, constructed springs and wrong exports."""

import json

import numpy as np
import pytest
from numpy.testing import assert_allclose

from shakerproc.errors import ExchangeError
from shakerproc.exchange.tensile import (
    TensileRun,
    indistinguishable,
    joint_stiffness,
    read_tensile,
    slope,
)


@pytest.mark.shared
def test_the_reference_is_reproduced(shared):
    folder = shared / "reference"
    runs = [read_tensile(folder / "recordings" / f"tensile_run{i}.csv") for i in range(1, 7)]
    expected = json.loads((folder / "thesis" / "tensile" / "tensile.json").read_text())
    found = joint_stiffness(runs)
    per_mm = 1e-3
    assert_allclose(found.thesis * per_mm, expected["k_est_n_per_mm"], rtol=1e-12)
    assert_allclose(
        np.array(found.secants) * per_mm, expected["k_each_run_secant_200"], rtol=1e-12
    )
    slopes = np.array([s.value for s in found.slopes]) * per_mm
    assert_allclose(slopes, expected["k_slope_20_80_each_run"], rtol=1e-9)
    assert_allclose(found.slope.value * per_mm, expected["k_slope_mean_last3"], rtol=1e-9)
    assert_allclose(np.mean(found.secants[-3:]) * per_mm, expected["k_mean_of_last3_ratios"])
    assert_allclose(
        joint_stiffness(runs, last=2).thesis * per_mm, expected["k_last2"], rtol=1e-12
    )


def spring(stiffness, *, name="run", specimen="one", noise=0.0, seed=1):
    displacement = np.linspace(0.0, 0.2e-3, 300)
    scatter = noise * np.random.default_rng(seed).standard_normal(300)
    return TensileRun(name, specimen, displacement, stiffness * displacement + scatter)


def test_bounds_hold_the_true_stiffness_95_times_in_100():
    inside = 0
    for seed in range(400):
        found = slope(spring(2.5e6, noise=1.0, seed=seed))
        inside += found.low <= 2.5e6 <= found.high
    assert (
        0.915 <= inside / 400 <= 0.98
    )  # 3 sigma of 400 draws is 3.3 %; ends of the range bias


def test_runs_that_still_stiffen_are_not_settled():
    rising = [spring(k, noise=0.1, seed=i) for i, k in enumerate((2.0e6, 2.3e6, 2.6e6))]
    steady = [spring(2.6e6, noise=0.1, seed=i) for i in range(3)]
    assert not joint_stiffness(rising).converged
    assert joint_stiffness(steady).converged


def test_specimens_that_all_give_the_same_stiffness_are_suspicious():
    def specimen(stiffness, seed):
        runs = [spring(stiffness * (1 + 0.01 * d), noise=0.1, seed=seed) for d in (-1, 0, 1)]
        return joint_stiffness(runs)

    assert indistinguishable([specimen(2.67e6, 1), specimen(2.68e6, 2)])
    assert not indistinguishable([specimen(2.67e6, 1), specimen(4.0e6, 2)])


def test_the_secant_can_be_taken_at_a_force():
    assert_allclose(joint_stiffness([spring(2e6)] * 3, force=150.0).thesis, 2e6)


def test_a_machine_export_with_units_below_the_heading_is_read(tmp_path):
    path = tmp_path / "zwick.txt"
    path.write_text(
        'Prüfer;x\n\n"Weg";"Standardkraft"\nmm;N\n0,010;25,0\n0,020;50,0\n', "cp1252"
    )
    run = read_tensile(path)
    assert_allclose(run.displacement, [1e-5, 2e-5])
    assert_allclose(run.force, [25.0, 50.0])


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("1,2\n3,4\n", r"run.csv: no line names a displacement and a force"),
        ("displacement,force_n\n1,2\n", r"run.csv:1: column 'displacement' has no unit"),
        ("displacement_furlong,force_n\n1,2\n", r"run.csv:1: .*furlong.*write one of m, mm"),
        ("displacement_mm,force_n\n1,2\n3,x\n", r"run.csv:3: column 2 holds 'x', a number"),
        ("displacement_mm,force_n\n1,2\n3\n", r"run.csv:3: column 2 holds '', a number"),
        ("displacement_mm,force_n\n1,2\n", r"run.csv: 1 rows of numbers"),
    ],
)
def test_a_wrong_export_is_refused_in_one_line(tmp_path, text, message):
    path = tmp_path / "run.csv"
    path.write_text(text)
    with pytest.raises(ExchangeError, match=message) as error:
        read_tensile(path)
    assert "\n" not in str(error.value)


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"last": 4}, "3 runs of one, the last 4 were wanted"),
        ({"sample": 400}, "run: 300 samples, a secant was wanted at 400"),
        ({"force": 1e6}, "run: the force reaches 400 N, the secant asks for 1000000 N"),
        ({"low_share": 0.79999, "high_share": 0.8}, "run: . samples between 80% and 80%"),
    ],
)
def test_what_the_runs_cannot_give_is_refused(options, message):
    with pytest.raises(ValueError, match=message):
        joint_stiffness([spring(2e6)] * 3, **options)
