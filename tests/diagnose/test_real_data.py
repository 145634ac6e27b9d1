"""The whole way from files to the verdict: recordings of others, and the thesis' own case.

Recordings of others lie in ../shared/data and are never copied into the project; where the
folder is absent the tests skip. What they are held against was found by other means than the
diagnosis: each test says how.
"""

import json
import shutil
from dataclasses import replace
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest
import yaml
from blind.campaigns import draw
from blind.excitations import SAMPLE_RATE
from scipy.signal import find_peaks

from blind import folder
from shakerproc.diagnose import diagnose
from shakerproc.model_files import read_model
from shakerproc.testlog import read_testlog

SAMPLE = Path(__file__).resolve().parents[2] / "sample_data"
TABLE_RATE = 120.0


def diagnosis_of(place: Path, model: dict | str, log: dict | str):
    """Return the diagnosis of a model and a log, written into a folder and read from it."""
    for name, document in (("model.yaml", model), ("testlog.yaml", log)):
        text = document if isinstance(document, str) else yaml.safe_dump(document)
        (place / name).write_text(text, encoding="utf-8")
    return diagnose(read_model(place / "model.yaml"), read_testlog(place / "testlog.yaml"))


def sensor_export(path: Path) -> tuple[np.ndarray, float]:
    """Return accelerations along the table [m/s²] and the time of the first sample [s]."""
    lines = path.read_text(encoding="utf-8").splitlines()
    head = next(i for i, line in enumerate(lines) if line.startswith("PacketCounter"))
    rows = np.array([line.split(",") for line in lines[head + 1 :]], dtype=float)
    assert np.all(np.diff(rows[:, 0]) == 1)  # no packet was lost
    return rows[1:, 5], 1e-6 * rows[1, 1]


def later(samples: np.ndarray, shift: float) -> np.ndarray:
    """Return samples as a clock that started `shift` seconds earlier has them."""
    n = samples.size
    bridge = np.linspace(samples[-1], samples[0], 3 * n)
    turn = np.exp(-2j * np.pi * np.fft.rfftfreq(4 * n, 1.0 / TABLE_RATE) * shift)
    return np.fft.irfft(np.fft.rfft(np.concatenate([samples, bridge])) * turn, 4 * n)[:n]


def slope_of_phase(ground: np.ndarray, top: np.ndarray) -> float:
    """Return the delay [s] that the phase between 1 and 8 Hz shows.

    There the frame (22 Hz, hardly damped) moves with the table: a phase in proportion to the
    frequency is a delay, whatever the stiffness.
    """
    size = 256
    window, hop = np.hanning(size), size // 2
    cross = np.zeros(size // 2 + 1, complex)
    for start in range(0, min(ground.size, top.size) - size, hop):
        one, two = (np.fft.rfft(x[start : start + size] * window) for x in (ground, top))
        cross += two * np.conj(one)
    frequency = np.fft.rfftfreq(size, 1.0 / TABLE_RATE)
    rigid = (frequency > 1.0) & (frequency < 8.0)
    weight, phase = np.abs(cross[rigid]), np.unwrap(np.angle(cross[rigid]))
    line = np.sum(weight * phase * frequency[rigid]) / np.sum(weight * frequency[rigid] ** 2)
    return float(-line / (2.0 * np.pi))


@pytest.mark.shared
def test_the_delay_of_a_small_shaking_table_is_named(shared, tmp_path):
    """Two loose sensors, each on its own clock; the phase at 1-8 Hz is the oracle."""
    source, delays = shared / "data" / "mini_shaketable_brace2", []
    for run in ("El Centro", "Northridge"):
        (below,) = source.glob(f"*GroundFloor*{run}*")
        (above,) = source.glob(f"*TopFloor*{run}*")
        (ground, first), (top, second) = sensor_export(below), sensor_export(above)
        n = min(ground.size, top.size)
        ground, top = ground[:n], later(top[:n], second - first)
        delays.append(slope_of_phase(ground - ground.mean(), top - top.mean()))
        np.savetxt(
            tmp_path / f"{run[:2]}.csv", np.column_stack([ground, top]), delimiter=",",
            header="ground (m/s^2),top (m/s^2)", comments="", fmt="%.8f",
        )  # fmt: skip
    found = diagnosis_of(tmp_path, TABLE_MODEL, TABLE_LOG)
    named = {effect.kind: effect for effect in found.effects}
    assert "sensor_delay" in named
    assert set(named) <= {"sensor_delay", "sensor_gain"}  # no physics in its place
    delay = named["sensor_delay"].parameters["delay"]
    assert np.mean(delays) == pytest.approx(0.020, abs=0.001)
    assert delay.value == pytest.approx(np.mean(delays), abs=0.0005)
    assert found.errors.held_out.after < 0.2


TABLE_MODEL = """
model: 1
title: one storey on a small shaking table
masses: {roof: 1 kg}
elements:
  - {kind: spring, between: [base, roof], stiffness: 1.9e4 N/m}
  - {kind: damper, between: [base, roof], damping: 2 N s/m}
excitation: {base: acceleration}
sensors:
  top: {at: roof, measures: acceleration}
"""

TABLE_LOG = f"""
testlog: 1
title: small shaking table
recordings: ./
channels:
  ground: {{role: control}}
  top: {{role: response, at: roof}}
processing: {{crop: none, sample_rate: {TABLE_RATE:g} Hz}}
tests:
  - {{id: 1, recording: El.csv, excitation: random, from: 0.5 Hz, to: 40 Hz}}
  - {{id: 2, recording: No.csv, excitation: random, from: 0.5 Hz, to: 40 Hz}}
"""


def test_the_clearance_of_the_thesis_case_is_found(tmp_path):
    """367 Hz glued, near 250 Hz with 0.10 mm between hole and bushing: +-0.05 mm of play.

    The recordings are those of sample_data, from an integrator of its own, by what it was told:
    of the glued stiffness 40 % are always there and 60 % bear beyond the play.
    """
    log = yaml.safe_load((SAMPLE / "one_joint.yaml").read_text(encoding="utf-8"))
    model = yaml.safe_load((SAMPLE / "model.yaml").read_text(encoding="utf-8"))
    del model["sensors"]["ch4"], log["expect"]
    log["channels"]["response 2"] = {"role": "ignore"}
    log["tests"] = [test for test in log["tests"] if test["id"] in {3, 4, 5, 15}]
    for test in log["tests"]:
        shutil.copytree(
            SAMPLE / "recordings" / f"Test_{test['id']}",
            tmp_path / "recordings" / f"Test_{test['id']}",
        )
    found = diagnosis_of(tmp_path, model, log)
    assert found.verdict == "effect found"
    (gap,) = found.effects
    assert (gap.kind, gap.between) == ("gap", ("base", "coupon"))
    clearance, stiffness = gap.parameters["clearance"], gap.parameters["stiffness"]
    glued = 28.6e-3 * (2.0 * np.pi * 367.0) ** 2
    assert clearance.low < 0.05e-3 < clearance.high
    assert clearance.value == pytest.approx(0.05e-3, rel=0.01)
    assert stiffness.value == pytest.approx(0.6 * glued, rel=0.02)
    assert found.linear["stiffness base-coupon"].value == pytest.approx(0.4 * glued, rel=0.02)
    errors = found.errors
    assert errors.held_out.after < 1.5 * errors.noise_floor < 0.1 * errors.held_out.before


@pytest.mark.slow
@pytest.mark.long
def test_the_gap_of_a_chain_of_three_masses_is_found_in_its_joint(tmp_path):
    """A campaign of the truth generator of `blind`: 2.5 s each of two levels and one kept."""
    campaign = draw(0, "chain3:gap")
    seconds = round(2.5 * SAMPLE_RATE)
    kept = [test for test in campaign.tests if test.number in {1, 3, 4}]
    tests = tuple(
        replace(test, **{
            name: getattr(test, name)[:, :seconds] for name in ("control", "response", "clean")
        })
        for test in kept
    )  # fmt: skip
    log, model = folder.write(replace(campaign, tests=tests), tmp_path)
    found = diagnose(read_model(model), read_testlog(log))
    (truth,), (gap,) = campaign.truth["effects"], found.effects
    assert truth["between"] == ["m2", "m3"]
    assert (gap.kind, gap.between) == ("gap", ("m2", "m3"))
    clearance = gap.parameters["clearance"]
    assert clearance.low < truth["parameters"]["clearance"] < clearance.high
    assert clearance.value == pytest.approx(truth["parameters"]["clearance"], rel=0.01)
    assert found.errors.held_out.after < 1.5 * found.errors.noise_floor


@pytest.mark.shared
def test_the_silverbox_is_a_cubic_spring(shared, tmp_path):
    """An electronic circuit made to be x'' + c x' + k x + k3 x^3 = force [1]_.

    References
    ----------
    .. [1] T. Wigren and J. Schoukens, "Three free data sets for development and benchmarking
       in nonlinear system identification", European Control Conference, 2933-2938, 2013.
    """
    shutil.copy(next((shared / "data").rglob("SNLS80mV.mat")), tmp_path / "SNLS80mV.mat")
    found = diagnosis_of(tmp_path, BOX_MODEL, BOX_LOG)
    assert found.verdict == "effect found"
    (effect,) = found.effects
    assert effect.kind == "cubic_stiffness"
    linear = found.linear["stiffness base-box"].value
    assert effect.parameters["coefficient"].value / linear == pytest.approx(3.2, rel=0.15)


BOX_MODEL = """
model: 1
title: Silverbox, linear
masses: {box: 5.375 mg}
elements:
  - {kind: spring, between: [base, box], stiffness: 1.0 N/m}
  - {kind: damper, between: [base, box], damping: 0.00025 N s/m}
excitation: {force on: box}
sensors:
  V2: {at: box, measures: displacement}
"""

BOX_LOG = """
testlog: 1
title: Silverbox
recordings: .
channels:
  V1: {role: force, at: box, sensitivity: 1 V/N}
  V2: {role: displacement, at: box, sensitivity: 1 V/m}
processing:
  crop: none
  sample_rate: 610.35 Hz
tests:
  - {id: 1, recording: SNLS80mV.mat, excitation: random, from: 5 Hz, to: 200 Hz}
"""


def loop_readings(moved: np.ndarray, force: np.ndarray) -> tuple[float, float]:
    """Return the sliding force [N] and the width of the pause near zero force [m].

    Read from the full swings of a loop, by no model: the median of |force| beyond 15 mm from
    the turn; and the way within a quarter of it, on swings that go up, less the way on which
    the force falls from three quarters to one, which is as much of elastic way.
    """
    smooth = np.convolve(moved, np.ones(15) / 15.0, "same")
    smooth[:8], smooth[-8:] = smooth[8], smooth[-8]
    turns = [find_peaks(sign * smooth, prominence=0.003)[0] for sign in (1.0, -1.0)]
    turns = np.sort(np.concatenate(turns))
    swings = [
        (slice(a, b), smooth[b] > smooth[a])
        for a, b in pairwise(turns)
        if abs(smooth[b] - smooth[a]) > 0.04
    ]
    ways = [np.abs(smooth[own] - smooth[own][0]) for own, _ in swings]
    sliding = np.mean([
        np.median(np.abs(force[own][way > 0.015]))
        for (own, _), way in zip(swings, ways, strict=True)
    ])
    pauses = []
    for (own, up), way in zip(swings, ways, strict=True):
        if up:
            high, low, back = (
                way[np.argmax(force[own] > q * sliding)] for q in (-0.75, -0.25, 0.25)
            )
            pauses.append((back - low) - (low - high))
    assert len(pauses) >= 3
    return float(sliding), float(np.mean(pauses))


def damper_run(shared: Path, place: Path, name: str):
    """Return what the diagnosis finds in a run of the damper, and the readings of its loop."""
    source = shared / "data" / "friction_backlash_arts" / f"ds1_{name}.json"
    rows = np.array(json.loads(source.read_text(encoding="utf-8"))["data"], dtype=float)
    moved, force = 0.0254 * rows[:, 1], 4448.2216 * rows[:, 2]
    np.savetxt(
        place / "loop.csv", np.column_stack([force, moved]), delimiter=",",
        header="force (N),stroke (m)", comments="", fmt="%.8g",
    )  # fmt: skip
    return diagnosis_of(place, DAMPER_MODEL, DAMPER_LOG), loop_readings(moved, force)


def friction_and_play(found, readings):
    """Hold the diagnosis of a run against the readings; return the sliding force found."""
    assert found.verdict == "effect found"
    assert "in series" in found.sentence
    friction, gap = found.effects
    assert (friction.kind, gap.kind) == ("coulomb_friction", "gap")
    assert friction.between == gap.between == ("base", "rod")
    sliding, pause = readings
    limit, play = friction.parameters["sliding_force"], gap.parameters["clearance"]
    assert limit.value == pytest.approx(sliding, rel=0.1)
    assert 2.0 * play.value == pytest.approx(pause, rel=0.2)
    assert limit.low < limit.value < limit.high
    assert play.low < play.value < play.high
    errors = found.errors
    assert errors.noise_floor < errors.held_out.after < 0.5 * errors.held_out.before
    simple = [one for one in found.candidates if "gap" not in one.kind]
    assert all(
        one.held_out_error > errors.held_out.after for one in simple if one.held_out_error
    )
    return limit


@pytest.mark.shared
@pytest.mark.slow
def test_the_friction_damper_has_friction_and_play_in_series(shared, tmp_path):
    """A rig imposes the stroke; sliding force and pause are read off the loop as well."""
    friction_and_play(*damper_run(shared, tmp_path, "1Hz70lbtension"))


@pytest.mark.shared
@pytest.mark.slow
@pytest.mark.long
def test_the_friction_of_the_damper_grows_with_its_tension(shared, tmp_path):
    forces = {}
    for name in ("0.5Hz70lbtension", "1Hz20lbtension", "1Hz70lbtension", "1Hz80lbtension"):
        (tmp_path / name).mkdir()
        forces[name] = friction_and_play(*damper_run(shared, tmp_path / name, name))
    assert forces["1Hz20lbtension"].high < forces["1Hz70lbtension"].low
    assert forces["1Hz70lbtension"].value < forces["1Hz80lbtension"].value


DAMPER_MODEL = """
model: 1
title: friction damper, linear
masses: {rod: 1 kg}
elements:
  - {kind: spring, between: [base, rod], stiffness: 1 N/mm}
  - {kind: damper, between: [base, rod], damping: 10 N s/m}
excitation: {force on: rod}
sensors:
  stroke: {at: rod, measures: displacement}
"""

DAMPER_LOG = """
testlog: 1
title: friction damper
recordings: .
channels:
  force: {role: force, at: rod}
  stroke: {role: displacement, at: rod}
processing: {crop: none, sample_rate: 1024 Hz}
tests:
  - {id: 1, recording: loop.csv, excitation: sine, frequency: 1 Hz}
"""
