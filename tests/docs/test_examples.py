"""Each example runs, and what it exposes is what an oracle says."""

import runpy
import time
from pathlib import Path

import numpy as np
import pytest
from tests.few_effects import seek_few

FOLDER = Path(__file__).parents[2] / "examples"
NAMES = sorted(path.stem for path in FOLDER.glob("*.py"))


@pytest.fixture(scope="module")
def example():
    """Run an example once; return what it exposes."""
    ran = {}

    def run(name):
        if name not in ran:
            ran[name] = runpy.run_path(str(FOLDER / f"{name}.py"))
        return ran[name]

    return run


def test_every_example_has_a_test_here():
    text = Path(__file__).read_text(encoding="utf-8")
    for name in NAMES:
        assert f'example("{name}")' in text


def test_a_response_function_from_arrays_has_the_mode_that_was_put_in(example):
    shown = example("response_of_arrays")
    assert shown["found"].frequency == pytest.approx(shown["NATURAL"], rel=1e-3)
    assert shown["found"].ratio == pytest.approx(shown["RATIO"], rel=0.05)


def test_a_recording_is_the_arrays_that_nptdms_reads(example):
    from nptdms import TdmsFile

    shown = example("read_and_convert")
    channels = TdmsFile.read(shown["SAMPLE"]).groups()[0].channels()
    raw = {c.name: c[:].astype(float) for c in channels}
    for name, rms in shown["rms"].items():
        assert rms == pytest.approx(9.80665 * np.sqrt(np.mean(raw[name] ** 2)), rel=1e-9)
    assert shown["header"].startswith("time [s],control 1 [g],")


@pytest.mark.slow
def test_decays_have_the_signatures_of_their_laws(example):
    """Oracle: means over a cycle: 2 F / (pi k A) of friction, 4 c A / (3 pi m) of c v |v|."""
    shown = example("decay_signatures")
    curves, trends = shown["curves"], shown["trends"]
    assert not (trends["linear"].shifts)
    assert not (trends["linear"].damps)
    assert (trends["dry friction"].law, trends["quadratic damping"].law) == (-1, 1)
    damper = shown["DAMPING"] / (2.0 * np.sqrt(shown["MASS"] * shown["STIFFNESS"]))
    for one in curves["dry friction"].fitted[:6]:
        friction = 2.0 * 0.2 / (np.pi * shown["STIFFNESS"] * one.amplitude)
        assert one.damping == pytest.approx(damper + friction, rel=0.03)
    for one in curves["quadratic damping"].charted[3:9]:
        quadratic = 4.0 * 30.0 * one.amplitude / (3.0 * np.pi)
        assert one.damping == pytest.approx(damper + quadratic, rel=0.03)
    linear = np.sqrt(shown["STIFFNESS"]) / (2.0 * np.pi)
    for one in curves["cubic spring"].fitted[3:]:
        cubic = 0.375 * 2e10 * one.amplitude**2 / shown["STIFFNESS"]
        assert one.frequency == pytest.approx(linear * (1.0 + cubic), rel=2e-3)
    closed = np.sqrt(1.3 * shown["STIFFNESS"]) / (2.0 * np.pi)
    shifted = [one.frequency for one in curves["gap of 0.1 mm"].fitted]
    assert np.diff(shifted).max() < 0.01
    assert linear * 0.999 < shifted[-1] < shifted[0] < closed
    assert trends["slip in a joint"].shift < -0.03


@pytest.mark.slow
def test_the_backbone_of_a_gap_is_that_of_free_flights_and_half_periods(example):
    """Oracle: f = f0 / (1 + 2 a / (π (A - a))), two contacts and two flights a period."""
    shown = example("gap_backbone")
    play, amplitude = shown["CLEARANCE"], shown["free"].amplitude
    exact = shown["closed"] / (1.0 + 2.0 * play / (np.pi * (amplitude - play)))
    beyond = amplitude > 1.5 * play
    assert shown["free"].frequency[beyond] == pytest.approx(exact[beyond], rel=1e-3)
    jumps = [fold.frequency for fold in shown["folds"]]
    assert max(jumps) < shown["closed"]
    assert len(jumps) >= 2


@pytest.mark.slow
def test_a_breathing_crack_swings_half_a_period_on_each_stiffness(example):
    """Oracle: f = 2 fo fc / (fo + fc); what swings out by A comes back to A √(ko / kc)."""
    shown = example("own_effect")
    opened, closed = (
        np.sqrt(shown[k] / shown["MASS"]) / (2.0 * np.pi) for k in ("OPEN", "CLOSED")
    )
    assert shown["frequency"] == pytest.approx(
        2.0 * opened * closed / (opened + closed), rel=1e-4
    )
    depth = -shown["START"] * np.sqrt(shown["OPEN"] / shown["CLOSED"])
    assert shown["motion"].min() == pytest.approx(depth, rel=1e-3)


def test_an_effect_in_a_file_of_ones_own_repeats_with_its_pitch(example):
    detent = example("my_effects")["Detent"](2.0, 1e-4)
    z = np.linspace(-3e-5, 3e-5, 7)
    assert detent.force_at(z + 1e-4, 0.0 * z) == pytest.approx(detent.force_at(z, 0.0 * z))


def finds_the_gap(example):
    shown = example("hidden_gap")
    (effect,) = shown["diagnosis"]().effects
    assert effect.kind == "gap"
    found = effect.parameters["clearance"]
    assert found.value == pytest.approx(shown["CLEARANCE"], rel=0.01)
    assert found.low < shown["CLEARANCE"] < found.high


@pytest.mark.slow
@pytest.mark.long  # the demo finds it in make test, too
def test_the_hidden_gap_is_found(example, monkeypatch):
    """Of two effects; of all of them below, of five on the pages of the manual."""
    seek_few(monkeypatch, {"gap", "cubic_stiffness"})
    finds_the_gap(example)


@pytest.mark.slow
@pytest.mark.long
@pytest.mark.timeout(300)
def test_the_hidden_gap_is_found_among_all_effects(example):
    started = time.process_time()
    finds_the_gap(example)
    assert time.process_time() - started < 120.0  # of the processor
