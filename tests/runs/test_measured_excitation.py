"""`excitation: measured`: what drives the test stands in its recording alone."""

import re
from dataclasses import replace

import numpy as np
import pytest
from numpy.testing import assert_allclose
from tests.in_process import run
from tests.small_campaign import samples, write_campaign

from shakerproc.data import STANDARD_GRAVITY
from shakerproc.errors import ShakerprocError
from shakerproc.planning.drive import drive_of_test
from shakerproc.runs import open_test, process_recording
from shakerproc.testlog import read_testlog

LEVEL = "excitation: random, level: 0.0005 g^2/Hz"


def log_with(folder, said):
    log = write_campaign(folder, 1)
    log.write_text(log.read_text().replace(LEVEL, said))
    return log


def test_it_is_processed_as_random_excitation_but_no_level_is_demanded(tmp_path):
    log = read_testlog(log_with(tmp_path, "excitation: measured"))
    (test,) = log.tests
    with open_test(log, test) as recording:
        found = process_recording(recording, test)
        asked = replace(test, excitation="random")
        other = process_recording(recording, asked)
    assert_allclose(found.averages.psd, other.averages.psd, rtol=0.0)
    assert_allclose(found.averages.against.h1, other.averages.against.h1, rtol=0.0)
    base = samples(300.0)[0] / STANDARD_GRAVITY
    moving = base[int(0.5 * 2048) : -int(0.5 * 2048)]
    assert (found.averages.measured_level.kind, found.averages.measured_level.unit) == (
        "rms",
        "m/s^2",
    )
    assert_allclose(
        found.averages.measured_level.value / STANDARD_GRAVITY, np.std(moving), rtol=0.1
    )
    assert not [flag for flag in found.flags if flag.kind == "level"]


@pytest.mark.parametrize("key", ["level: 1 g", "frequency: 50 Hz", "rate: 1 oct/min"])
def test_keys_that_demand_something_are_refused(tmp_path, key):
    name = key.partition(":")[0]
    said = f"tests.1.{name}: means nothing for excitation: measured; take it out"
    with pytest.raises(ShakerprocError, match=re.escape(said)):
        read_testlog(log_with(tmp_path, f"excitation: measured, {key}"))


def test_there_is_nothing_to_play(tmp_path):
    (test,) = read_testlog(log_with(tmp_path, "excitation: measured")).tests
    with pytest.raises(ShakerprocError, match="what shakes it stands in its recording alone"):
        drive_of_test(test, 1.0, 2048.0, np.random.default_rng(1))


def test_process_takes_it_without_a_log_and_refuses_a_level(tmp_path, capsys):
    log_with(tmp_path, "excitation: measured")
    (path,) = (tmp_path / "recordings").rglob("*.tdms")
    how = ("process", path, "--no-figures", "--crop-threshold", "0.2 g")
    asked = ("--excitation", "measured", "--from-hz", "5", "--to-hz", "800")
    assert run(*how, *asked, "--out", tmp_path / "o") == 0
    assert "g rms" in capsys.readouterr().out
    assert run(*how, *asked, "--level", "1 g", "--out", tmp_path / "p") == 2
    assert "a measured excitation has none" in capsys.readouterr().err
    assert not (tmp_path / "p").exists()
