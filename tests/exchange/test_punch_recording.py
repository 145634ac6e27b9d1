"""Punch files as recordings, all the way through nastran read and process."""

import csv
import json

import numpy as np
import pytest
from numpy.testing import assert_allclose
from scipy import signal
from tests.exchange.punch_writer import moving_node, write_punch
from typer.testing import CliRunner

from shakerproc.cli import build_app
from shakerproc.errors import ExchangeError
from shakerproc.exchange.nastran_decks import TransientDeck, transient_deck
from shakerproc.exchange.nastran_punch import recording_of_punch

RATE, RESONANCE, DAMPING = 500.0, 37.0, 0.02


def shaken(count=15001):
    """Acceleration of 1 kg on a spring under white force, and the force."""
    time = np.arange(count) / RATE
    force = np.random.default_rng(5).standard_normal(count)
    omega = 2 * np.pi * RESONANCE
    system = signal.lti([1.0, 0.0, 0.0], [1.0, 2 * DAMPING * omega, omega**2])
    return time, force, signal.lsim(system, force, time)[1]


def test_a_punch_file_goes_through_process_like_any_other(tmp_path):
    time, force, acceleration = shaken()
    punch, deck = tmp_path / "run.pch", tmp_path / "run.dat"
    write_punch(punch, {"$ACCELERATION": moving_node(acceleration)}, [2], time)
    deck.write_text(
        transient_deck(
            TransientDeck("t", {"mass": 1.0}, [], [], time, {"mass": force}, {}, time.size - 1)
        )
    )
    run = CliRunner()
    tdms = tmp_path / "run.tdms"
    read = run.invoke(
        build_app(), ["nastran", "read", str(punch), str(tdms), "--deck", str(deck)]
    )
    assert read.exit_code == 0, read.output
    options = ["--no-crop", "--no-figures", "--out", str(tmp_path / "out"), "--json"]
    document = tmp_path / "result.json"
    done = run.invoke(build_app(), ["process", str(tdms), *options, str(document)])
    assert done.exit_code == 0, done.output
    found = json.loads(document.read_text())
    roles = {channel["name"]: channel["role"] for channel in found["channels"]}
    assert roles["control F/m node 2"] == "control"
    (moved,) = [one for one in found["channels"] if one["role"] == "response"]
    tallest = moved["response_peaks"][0]
    assert_allclose(tallest["natural_frequency_hz"], RESONANCE, rtol=2e-3)
    assert moved["coherence"] > 0.95


def test_channels_are_named_and_what_is_still_is_left_out(tmp_path):
    path = tmp_path / "run.pch"
    times = np.arange(50) * 0.002
    moving = np.concatenate([np.zeros((1, 6, 50)), moving_node(np.sin(times))])
    write_punch(path, {"$DISPLACEMENTS": moving, "$VELOCITY": moving}, [1, 2], times)
    recording = recording_of_punch(path)
    assert [(c.name, c.unit) for c in recording.channels] == [
        ("node 2 displacement x", "m"),
        ("node 2 velocity x", "m/s"),
    ]
    assert recording.sample_rate == 500.0
    assert recording.notes == ("22 components that are zero throughout are left out",)
    assert_allclose(recording.samples()[0], np.sin(times), rtol=1e-6)


def test_steps_that_differ_are_refused(tmp_path):
    path = tmp_path / "run.pch"
    times = np.array([0.0, 0.1, 0.2, 0.35])
    write_punch(path, {"$ACCELERATION": moving_node(np.ones(4))}, [2], times)
    with pytest.raises(ExchangeError, match=r"run\.pch: the time steps are not equal \(at 0\."):
        recording_of_punch(path)


def test_nothing_but_zeros_and_a_single_step_are_refused(tmp_path):
    path = tmp_path / "run.pch"
    write_punch(path, {"$ACCELERATION": moving_node(np.zeros(4))}, [2], np.arange(4.0))
    with pytest.raises(ExchangeError, match="every result is zero"):
        recording_of_punch(path)
    write_punch(path, {"$ACCELERATION": moving_node(np.ones(1))}, [2], np.arange(1.0))
    with pytest.raises(ExchangeError, match="1 time steps, at least 2 are needed"):
        recording_of_punch(path)


def test_a_foreign_deck_is_refused(tmp_path):
    path, deck = tmp_path / "run.pch", tmp_path / "run.dat"
    write_punch(path, {"$ACCELERATION": moving_node(np.ones(4))}, [2], np.arange(4.0))
    deck.write_text("SOL 101\nCEND\nBEGIN BULK\nGRID,1,,0.,0.,0.\nENDDATA\n")
    with pytest.raises(ExchangeError, match=r"run\.dat: the deck has no force over time"):
        recording_of_punch(path, deck)


def test_a_file_over_frequency_is_refused(tmp_path):
    path = tmp_path / "run.pch"
    write_punch(path, {"$ACCELERATION": moving_node(np.ones(4))}, [2], np.arange(4.0))
    path.write_text(path.read_text().replace("$TIME ", "$FREQUENCY "))
    with pytest.raises(ExchangeError, match="a recording runs over time"):
        recording_of_punch(path)


def test_csv_comes_out_too(tmp_path):
    path, out = tmp_path / "run.pch", tmp_path / "run.csv"
    write_punch(path, {"$ACCELERATION": moving_node(np.ones(20))}, [2], np.arange(20) * 0.01)
    done = CliRunner().invoke(build_app(), ["nastran", "read", str(path), str(out)])
    assert done.exit_code == 0, done.output
    with out.open(encoding="utf-8") as lines:
        assert sum(1 for _ in csv.reader(lines)) > 20
    wrong = CliRunner().invoke(build_app(), ["nastran", "read", str(path), "x.xlsx"])
    assert wrong.exit_code == 2
