"""Reciprocity of hammer and sensor that change places, in closed form."""

import json

import numpy as np
import pytest
import yaml
from benchmarks.modal_signals import draw
from tests.in_process import run
from tests.struck import RATE, struck

BLOWS = [(0.5 + 2.0 * k, 100.0 + 10.0 * k) for k in range(4)]
CORNER, MIDDLE = ["0 mm", "0 mm", "0 mm"], ["300 mm", "0 mm", "0 mm"]


def channel(role, position, direction="z"):
    return {"role": role, "position": position, "direction": direction}


def analysed(folder, *options, gain=1.0, direction="z", shift=0):
    """Strike the corner and then the middle, the sensor at the other; return the results."""
    for test in (1, 2):  # what a sensor at B answers to a blow at A is what A answers to B
        force, _, other = struck(BLOWS, 8.5, noise=(0.05, 0.002), seed=test)
        other = np.roll(other, shift) * gain if test == 2 else other
        np.savez(folder / f"{test}.npz", fs=RATE, hammer=force, plate=other)
    log = {
        "testlog": 1,
        "recordings": ".",
        "channels": {
            "hammer": channel("force", CORNER) | {"unit": "N"},
            "plate": channel("response", MIDDLE) | {"unit": "m/s^2"},
        },
        "processing": {"crop": "none", "hammer": {"length": "1.9 s"}},
        "tests": [
            {"id": i, "recording": f"{i}.npz", "excitation": "hammer",
             "from": "20 Hz", "to": "350 Hz"} for i in (1, 2)
        ],
    }  # fmt: skip
    log["tests"][1]["channels"] = {
        "hammer": channel("force", MIDDLE) | {"unit": "N"},
        "plate": channel("response", CORNER, direction) | {"unit": "m/s^2"},
    }
    path = folder / "testlog.yaml"
    path.write_text(yaml.safe_dump(log))
    out = folder / "out"
    assert run("modal", path, "--out", out, *options) == 0
    return json.loads((out / "report.json").read_text()), out


def test_a_hammer_and_a_sensor_that_change_places_agree(tmp_path):
    document, out = analysed(tmp_path)
    (pair,) = document["reciprocity"]
    assert pair["agrees"]
    assert pair["correlation"] > 0.999
    assert pair["size_ratio"] == pytest.approx(1.0, abs=0.01)
    assert pair["function"] == "test 1, plate / hammer"
    assert (out / "reciprocity.csv").is_file()
    assert (out / "reciprocity_1.png").stat().st_size > 10_000
    assert "Reciprocity" in (out / "report.html").read_text()


@pytest.mark.parametrize(
    ("how", "says"),
    [
        ({"gain": -1.0}, "opposite sign"),
        ({"gain": 1.3}, "check the sensitivities"),
        ({"shift": 9}, "Places or directions in the log are wrong"),
        ({"direction": "-z"}, "opposite sign"),
    ],
)
def test_what_is_not_reciprocal_is_named_with_the_reason(tmp_path, how, says):
    document, _ = analysed(tmp_path, "--no-figures", **how)
    assert any(says in note for note in document["notes"])


def test_a_sensor_that_measures_across_is_no_pair(tmp_path):
    document, _ = analysed(tmp_path, "--no-figures", direction="x")
    assert document["reciprocity"] == []


def test_two_shakers_at_once_are_reciprocal_too(tmp_path):
    structure = draw(np.random.default_rng(5), 3, n_inputs=2, noise_db=50.0, duration=10.0)
    rows = {f"f{k}": row for k, row in enumerate(structure.force)}
    rows |= {f"a{k}": row for k, row in enumerate(structure.response)}
    np.savez(tmp_path / "both.npz", fs=structure.sample_rate, **rows)
    places = [[f"{100 * k} mm", "0 mm", "0 mm"] for k in range(8)]
    channels = {
        f"f{k}": channel("force", places[at]) | {"unit": "N"}
        for k, at in enumerate(structure.driven)
    }
    channels |= {f"a{k}": channel("response", places[k]) | {"unit": "m/s^2"} for k in range(8)}
    path = tmp_path / "testlog.yaml"
    path.write_text(yaml.safe_dump({
        "testlog": 1, "recordings": ".", "channels": channels,
        "processing": {"crop": "none"}, "modal": {"order": 20},
        "tests": [{"id": 1, "recording": "both.npz", "excitation": "random",
                   "from": "3 Hz", "to": "205 Hz"}],
    }))  # fmt: skip
    assert run("modal", path, "--out", tmp_path / "out", "--no-figures") == 0
    (pair,) = json.loads((tmp_path / "out" / "report.json").read_text())["reciprocity"]
    assert pair["agrees"]
    assert pair["size_ratio"] == pytest.approx(1.0, abs=0.1)  # leakage of 1.2 s
