"""Several tests of one structure in one fit: repeats, and a force that moves."""

import json

import numpy as np
import pytest
from benchmarks.modal_signals import band_limited, superposition
from numpy.testing import assert_allclose
from tests.in_process import run

RATE = 512.0
FREQUENCY = np.array([31.0, 31.6, 90.0])
DAMPING = np.array([0.01, 0.006, 0.02])
SHAPES = np.array([[1.0, 0.6, 0.0, 0.5], [0.0, 0.7, 1.0, -0.4], [0.8, -1.0, 0.6, 0.9]])


def record(folder, number, place, shift=1.0, sensors=range(4)):
    """Write a record of 6 s of one force at a sensor's place; 40 dB of noise."""
    rng = np.random.default_rng(number)
    force = band_limited(rng, 1, int(6.0 * RATE))
    response = superposition(
        shift * FREQUENCY, DAMPING, SHAPES, SHAPES[:, [place]] @ force, RATE
    )
    response += 0.01 * response.std() * rng.standard_normal(response.shape)
    rows = {f"a{i}": response[i] for i in sensors}
    np.savez(folder / f"{number}.npz", f=force[0, ::8], fs=RATE, **rows)


def analysed(folder, tests, *options, status=0, modal="together: true"):
    sensors = "".join(
        f"  a{i}: {{role: response, unit: m/s^2, position: [{i} m, 0 m, 0 m]}}\n"
        for i in range(4)
    )
    lines = "".join(
        f"  - {{id: {number}, recording: {number}.npz, excitation: random, level: 1 N rms, "
        f"from: 3 Hz, to: 200 Hz{more}}}\n"
        for number, more in tests
    )
    log = folder / "log.yaml"
    log.write_text(
        f"testlog: 1\nrecordings: .\nprocessing: {{crop: none}}\nmodal: {{{modal}}}\n"
        f"channels:\n  f: {{role: force, unit: N}}\n{sensors}tests:\n{lines}"
    )
    out = folder / "out"
    assert run("modal", log, "--out", out, "--no-figures", *options) == status
    return json.loads((out / "report.json").read_text())


def at(place):
    return f", channels: {{f: {{role: force, unit: N, position: [{place} m, 0 m, 0 m]}}}}"


def test_a_force_that_moves_parts_two_modes_that_one_place_sees_badly(tmp_path):
    for number, place in enumerate((0, 2, 0), 1):
        record(tmp_path, number, place)
    document = analysed(tmp_path, [(1, at(0)), (2, at(2)), (3, at(0))])
    (found,) = document["tests"]
    assert found["test"] == "1 + 2 + 3"
    assert [one["test"] for one in found["recordings"]] == ["1", "2", "3"]
    assert found["inputs"] == ["f", "f of test 2"]
    modes = found["modes"]
    assert_allclose([m["frequency_hz"]["value"] for m in modes], FREQUENCY, rtol=5e-4)
    assert_allclose([m["damping"]["value"] for m in modes], DAMPING, rtol=0.04)
    for mode, damping in zip(modes, DAMPING, strict=True):
        assert mode["damping"]["low"] < damping < mode["damping"]["high"]
    scatter = [mode["frequency_scatter_percent"] for mode in modes]
    assert 0.0 < scatter[0] < 0.1
    assert scatter[1] is None  # one test shows it only
    driven = [m["participation"]["real"] for m in modes]
    assert_allclose(driven[2][1] / driven[2][0], SHAPES[2, 2] / SHAPES[2, 0], rtol=0.02)
    assert abs(driven[1][0]) < 0.05  # the second mode has a node where the first force acts


def test_a_structure_that_is_not_the_same_is_told_and_widens_the_intervals(tmp_path, capsys):
    record(tmp_path, 1, 1)
    record(tmp_path, 2, 1, shift=1.003)
    together = analysed(tmp_path, [(1, ""), (2, "")])["tests"][0]
    told = [line for line in capsys.readouterr().out.splitlines() if "scatters over" in line]
    assert told
    assert "analyse them apart" in told[0]
    third = together["modes"][-1]
    assert third["frequency_scatter_percent"] == pytest.approx(0.3 / np.sqrt(2.0), rel=0.2)
    assert third["frequency_hz"]["high"] / third["frequency_hz"]["low"] - 1.0 > 0.003


@pytest.mark.parametrize(
    ("second", "modal", "says"),
    [
        (", channels: {a3: {role: ignore}}", "together: true", "not the same sensors"),
        ("", "together: true, inputs: none", "no input was measured"),
        (
            ", channels: {a3: {role: response, unit: m/s^2, position: [9 m, 0 m, 0 m]}}",
            "together: true",
            "at the same places (a3)",
        ),
    ],
)
def test_what_one_fit_cannot_hold_is_one_line(tmp_path, capsys, second, modal, says):
    for number in (1, 2):
        record(tmp_path, number, 1)
    analysed(tmp_path, [(1, ""), (2, second)], status=1, modal=modal)
    lines = [line for line in capsys.readouterr().err.splitlines() if "left out" in line]
    assert len(lines) == 1
    assert says in lines[0]
    assert "tests 1 and 2 cannot be fitted together" in lines[0]
    assert "analyse them apart" in lines[0]


def test_the_option_does_what_the_log_does(tmp_path):
    for number in (1, 2):
        record(tmp_path, number, 1)
    found = analysed(tmp_path, [(1, ""), (2, "")], "--together", modal="order: 30")["tests"]
    assert [one["test"] for one in found] == ["1 + 2"]
