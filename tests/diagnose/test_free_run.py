"""Dry friction by free runs: runs against the exact engine, the search against its truth."""

from dataclasses import replace

import numpy as np
import pytest
from blind.campaigns import draw
from blind.excitations import SAMPLE_RATE
from numpy.testing import assert_array_equal

from blind import folder
from shakerproc.diagnose.arrays import no_correction, prepare
from shakerproc.diagnose.candidates import COULOMB
from shakerproc.diagnose.fit import Priors
from shakerproc.diagnose.free_run import friction_fits
from shakerproc.diagnose.pipeline import fit_base, screened
from shakerproc.diagnose.problem import (
    Hypothesis,
    Parameters,
    Term,
    assemble,
    law_table,
    run,
    unaided_tuning,
)
from shakerproc.diagnose.search import make_bench
from shakerproc.diagnose.structure import Joint, Sensing, Structure
from shakerproc.diagnose.translate import skeleton, start_parameters
from shakerproc.diagnosis.data import TestArrays
from shakerproc.model_files import read_model
from shakerproc.models import EFFECTS, Element, Excitation, Model, Sensor
from shakerproc.simulate import simulate

RATE = 5688.9
FORCE = 0.5
STRUCTURE = Structure(np.array([0.1]), (Joint(-1, 0, 4e4, 3.0),), (Sensing(0, 2, True),))
JOINT = ("base", "mass")


def shaken(seconds: float) -> np.ndarray:
    """Base acceleration [m/s²]: noise below 400 Hz."""
    n = int(seconds * RATE)
    rng = np.random.default_rng(8)
    spectrum = np.fft.rfft(rng.standard_normal(n))
    spectrum[np.fft.rfftfreq(n, 1.0 / RATE) > 400.0] = 0.0
    wave = np.fft.irfft(spectrum, n)
    ends = np.minimum(1.0, np.minimum(np.arange(n), np.arange(n)[::-1]) / 500.0)
    return 6.0 * ends * wave / np.std(wave)


def bench_of(control: np.ndarray, response: np.ndarray, fine: int):
    test = TestArrays("1", RATE, control[None], response[None])
    prepared, _ = prepare(test, 0, no_correction(1), fine)
    return make_bench(STRUCTURE, (prepared,), fine, Priors())


def test_a_run_that_nothing_corrects_is_the_motion_of_the_exact_engine():
    control = shaken(2.0)
    model = Model(
        "slider", {"mass": 0.1},
        (
            Element(EFFECTS["spring"](4e4), JOINT), Element(EFFECTS["damper"](3.0), JOINT),
            Element(EFFECTS["coulomb_friction"](FORCE), JOINT),
        ),
        Excitation("base acceleration"), {"a": Sensor("mass", "acceleration")},
    )  # fmt: skip
    exact = simulate(model, control, RATE).outputs["a"]
    bench = bench_of(control, exact, 8)
    hypothesis = Hypothesis((Term(COULOMB, 0, 0.1),))
    p = Parameters(np.array([4e4]), np.array([3.0]), np.ones(1), np.zeros(1), ((FORCE,),))
    whole = assemble(STRUCTURE, hypothesis, p)
    table = law_table(STRUCTURE, hypothesis, p, 1)
    seen = run(
        whole, table, bench.whole[0], unaided_tuning(STRUCTURE, np.ones(1)), p, keep=True
    )
    away = np.cumsum(seen.expected[0] - exact) / RATE  # as velocity: jumps last no time
    motion = np.cumsum(exact - control) / RATE
    assert np.std(away) < 2e-3 * np.std(motion)
    stuck = np.mean(np.abs(exact - control) < 1e-3)
    assert 0.2 < stuck < 0.9  # it sticks and slips


def test_blocks_kept_aside_and_fitted_blocks_share_a_test_in_free_runs():
    control = shaken(8.0)
    bench = replace(bench_of(control, control, 4), free=True)
    (fitted,), (kept,) = bench.fitted(), bench.kept()
    assert_array_equal(fitted.weight + kept.weight, bench.whole[0].weight)
    assert np.mean(kept.weight) == pytest.approx(1.0 / 3.0, abs=0.1)


@pytest.mark.slow
@pytest.mark.long
def test_the_friction_of_a_joint_that_sticks_almost_always_is_found(tmp_path):
    """Of this campaign's sweeps only the loudest slips, beside the resonance."""
    campaign = draw(310001, "coulomb_friction")
    _, path = folder.write(campaign, tmp_path)
    model = read_model(path)
    known = skeleton(model, tuple(model.sensors))
    tests = tuple(
        TestArrays(str(t.number), SAMPLE_RATE, t.control, t.response, t.hold_out)
        for t in campaign.tests
    )
    base, start = start_parameters(known)
    stage = screened(known.structure, tests, no_correction(1), start)
    left = stage.sheet.regression.left.size
    _, linear = fit_base(stage.bench, stage.at, stage.p, base, stage.linear_cost, left)
    _, fits = friction_fits(stage.bench, start, linear, [])
    (truth,) = campaign.truth["effects"]
    coulomb = next(f for f in fits if f.hypothesis.terms[0].candidate is COULOMB)
    force = coulomb.parameters.values[0][0]
    assert force == pytest.approx(truth["parameters"]["sliding_force"], rel=5e-3)
