"""Drops of the control at a resonance: a mass on a table that a force drives, in closed form.

The acceleration of the table is that without the mass over |1 + mu T|, T the transmissibility
(J. P. Den Hartog, "Mechanical Vibrations", 4th ed., 1956, ch. 3: the absorber).
"""

from dataclasses import replace

import numpy as np
import pytest
from tests.runs.test_control import swept
from tests.small_campaign import CHANNELS, HEAD, RATE

from shakerproc.data import STANDARD_GRAVITY, recording_of_arrays
from shakerproc.recordings import write_tdms
from shakerproc.runs import process_test
from shakerproc.runs.flags import control_drops
from shakerproc.runs.tracking import SweptReading
from shakerproc.testlog import read_testlog

RESONANCE, DAMPING = 200.0, 0.03
KIND = "control at resonance"
RANDOM = "excitation: random, level: 0.0005 g^2/Hz, from: 20 Hz, to: 800 Hz"


def transmissibility(frequency):
    r = frequency / RESONANCE
    return (1.0 + 2j * DAMPING * r) / (1.0 - r**2 + 2j * DAMPING * r)


def run(folder, ratio, *, test=RANDOM, seed=1, slope=0.0, seconds=20.0):
    """Process a random test of a mass `ratio` times that of the table, with a level that rises
    by `slope` dB per octave."""
    rng = np.random.default_rng(seed)
    n = int(seconds * RATE)
    frequency = np.fft.rfftfreq(n, 1.0 / RATE)
    white = rng.standard_normal(frequency.size) + 1j * rng.standard_normal(frequency.size)
    white *= (frequency >= 20.0) & (frequency <= 800.0)
    white *= np.maximum(frequency / RESONANCE, 1e-3) ** (slope / 20.0 / np.log10(2.0))
    scale = np.sqrt(0.0005 * RATE / 2.0) * np.sqrt(n / 2.0) * STANDARD_GRAVITY
    base = white * scale / (1.0 + ratio * transmissibility(frequency))
    base[0] = 0.0
    rows = [base, base, base * transmissibility(frequency), 0.8 * base]
    samples = np.fft.irfft(rows, n) + 1e-3 * rng.standard_normal((4, n))
    (folder / "recordings").mkdir(exist_ok=True)
    write_tdms(
        folder / "recordings" / "a.tdms", recording_of_arrays("a", CHANNELS, samples, RATE)
    )
    head = HEAD.format(title="drops").replace("{channel: control 2, threshold: 0.2 g}", "none")
    head = head.replace("segment: 512, overlap: 256", "segment: 2048, overlap: 1024")
    (folder / "log.yaml").write_text(f"{head}  - {{id: 1, recording: a.tdms, {test}}}\n")
    log = read_testlog(folder / "log.yaml")
    return process_test(log, log.tests[0])


@pytest.mark.parametrize(("ratio", "slope"), [(0.15, 0.0), (0.3, -6.0)])
def test_a_specimen_that_pulls_is_told_with_its_resonance_and_drop(tmp_path, ratio, slope):
    """The closed form at the resonance, to 15 %: half an octave beside it the table is lower,
    too."""
    result = run(tmp_path, ratio, slope=slope)
    drops = control_drops(result)
    form = -20.0 * np.log10(np.abs(1.0 + ratio * transmissibility(RESONANCE)))
    assert len(drops) == 1
    assert result.channels[drops[0].channel].name == "ch3"
    assert drops[0].frequency == pytest.approx(RESONANCE, rel=0.01)
    assert drops[0].decibels == pytest.approx(form, rel=0.15)
    told = [flag for flag in result.flags if flag.kind == KIND]
    assert len(told) == 1
    assert "Hz, a resonance of ch3. The specimen pulls at the shaker" in told[0].message


@pytest.mark.parametrize(
    ("ratio", "slope", "seconds", "seed"),
    [(0.0, 0.0, 4.0, 1), (0.0, 6.0, 4.0, 2), (0.03, 0.0, 20.0, 3)],
)
def test_a_light_specimen_and_chance_are_silent(tmp_path, ratio, slope, seconds, seed):
    """Without a drop, and with one of 1 dB where the alarm is at 3."""
    assert not control_drops(run(tmp_path, ratio, seed=seed, slope=slope, seconds=seconds))


PROFILE = (
    "profiles: {flat: {breakpoints: [[20 Hz, 0.0005 g^2/Hz], [800 Hz, 0.0005 g^2/Hz]]NOTCH}}\n"
    "tests:\n  - {id: 1, recording: a.tdms, excitation: random, profile: flat}\n"
)
NOTCH = ", notches: [{from: 170 Hz, to: 206 Hz, depth: 9 dB}]"


def test_a_notch_that_the_profile_states_is_no_drop(tmp_path):
    """A table of 0.2 drops by 11 dB at most."""
    result = run(tmp_path, 0.2)
    assert control_drops(result)
    for notch, drops in (("", 1), (NOTCH, 0)):
        text = (tmp_path / "log.yaml").read_text().partition("tests:")[0]
        (tmp_path / "notched.yaml").write_text(text + PROFILE.replace("NOTCH", notch))
        test = read_testlog(tmp_path / "notched.yaml").tests[0]
        assert len(control_drops(replace(result, test=test))) == drops


def test_a_band_that_is_too_low_as_a_whole_is_no_drop(tmp_path):
    quiet = RANDOM.replace("0.0005 g^2/Hz", "0.005 g^2/Hz")
    result = run(tmp_path, 0.0, test=quiet)
    assert not control_drops(result)
    assert any(flag.kind == "level" for flag in result.flags)


def test_measured_motions_have_no_drop(tmp_path):
    assert not control_drops(run(tmp_path, 0.15, test="excitation: measured"))


@pytest.mark.parametrize(("drop", "told"), [(-2.5, 0), (-5.0, 1)])
def test_along_a_sweep_a_drop_at_the_tallest_response_counts_beyond_the_alarm(
    tmp_path, drop, told
):
    """Both sides rise by 2 dB over the octave around, which is no drop."""
    result = run(tmp_path, 0.0, seconds=4.0)
    lines = np.linspace(10.0, 500.0, 2001)
    hole = drop / (1.0 + ((lines - RESONANCE) / 6.0) ** 2)
    found = swept(result, hole + 2.0 * np.log2(lines / RESONANCE))
    reading = SweptReading(2, "up", RESONANCE, 20.0, None)
    drops = control_drops(replace(found, over_time=replace(found.over_time, swept=(reading,))))
    assert len(drops) == told
    assert [one.decibels for one in drops] == pytest.approx([drop] * told, abs=0.3)
