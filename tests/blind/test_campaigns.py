"""What is drawn, and how it is handed over."""

import json

import numpy as np
import pytest
import yaml
from blind.excitations import N_SAMPLES, SAMPLE_RATE
from nptdms import TdmsFile
from numpy.testing import assert_allclose

from blind import campaigns, folder, judging, ranges, structures, trial


@pytest.fixture(scope="module")
def gap():
    return campaigns.draw(11, "gap")


@pytest.mark.slow
def test_the_same_seed_draws_the_same(gap):
    again = campaigns.draw(11, "gap")
    assert again.truth == gap.truth
    assert np.array_equal(again.tests[3].response, gap.tests[3].response)


def test_a_campaign_is_what_the_issue_describes(gap):
    assert [test.hold_out for test in gap.tests] == [False, False, False, True]
    assert len({test.drive.level for test in gap.tests[:3]}) == 3
    for test in gap.tests:
        assert test.control.shape == (2, N_SAMPLES)
        assert pytest.approx(20.0, abs=1e-3) == N_SAMPLES / SAMPLE_RATE
        quiet = slice(0, int(0.7 * SAMPLE_RATE))
        assert np.max(np.abs(test.clean[:, quiet])) == 0.0
        assert 0.0 < np.std(test.response[:, quiet]) < 0.1 * np.std(test.response)
    joint, nominal = gap.structure.joints[0], gap.nominal.joints[0]
    assert abs(nominal.stiffness / joint.stiffness - 1.0) == pytest.approx(0.05)
    assert abs(nominal.damping / joint.damping - 1.0) == pytest.approx(0.25)
    assert gap.nominal.masses == gap.structure.masses


def test_the_two_controls_have_noise_of_their_own(gap):
    first, second = gap.tests[0].control[:, :4000]
    assert abs(np.corrcoef(first, second)[0, 1]) < 0.1


def test_the_folder_holds_what_was_drawn_in_the_laboratorys_units(gap, tmp_path):
    log, model = folder.write(gap, tmp_path)
    text = yaml.safe_load(log.read_text())
    assert [test.get("hold_out", False) for test in text["tests"]] == [False] * 3 + [True]
    tdms = TdmsFile.read(tmp_path / "recordings" / text["tests"][1]["recording"])
    channel = tdms["Acceleration"]["response 1"]
    assert channel.properties["unit_string"] == "g"
    assert_allclose(channel[:] * 9.80665, gap.tests[1].response[0], rtol=1e-12)
    written = yaml.safe_load(model.read_text())
    stiffness = float(written["elements"][0]["stiffness"].removesuffix(" N/m"))
    assert stiffness == pytest.approx(gap.nominal.joints[0].stiffness)
    assert "gap" not in model.read_text() + log.read_text()


@pytest.mark.slow
def test_the_gap_of_an_unexercised_campaign_never_closes():
    campaign = campaigns.draw(12, "unexercised")
    clearance = campaign.truth["effects"][0]["parameters"]["clearance"]
    joint = campaign.structure.joints[0]
    for test in campaign.tests:
        stretch = structures.linear_stretch(campaign.structure, test.control.mean(axis=0))
        assert np.max(np.abs(stretch[:, 3000:-3000])) < clearance
    assert joint.first == -1


@pytest.mark.slow
@pytest.mark.parametrize("fault", ranges.FAULTS)
def test_a_fault_spoils_the_record_as_it_says(fault):
    campaign = campaigns.draw(13, fault)
    numbers = campaign.truth["fault"]
    clean, spoilt = campaign.tests[2].clean[0], campaign.tests[2].response[0]
    if fault in {"sensor_gain", "sensor_polarity"}:
        gain = np.dot(clean, spoilt) / np.dot(clean, clean)
        assert gain == pytest.approx(numbers.get("gain", -1.0), rel=1e-3)
    elif fault == "sensor_delay":
        lag = np.argmax(np.fft.irfft(np.fft.rfft(spoilt) * np.fft.rfft(clean).conj()))
        assert lag / SAMPLE_RATE == pytest.approx(numbers["delay"], abs=1.0 / SAMPLE_RATE)
    elif fault == "clipping":
        assert np.max(np.abs(spoilt)) == pytest.approx(numbers["level"])
        assert np.sum(np.abs(spoilt) == np.max(np.abs(spoilt))) > 10
    else:
        t = np.arange(N_SAMPLES) / SAMPLE_RATE
        line = np.exp(-2j * np.pi * numbers["frequency"] * t)
        heard = 2.0 * abs(np.mean((spoilt - clean) * line))
        assert heard == pytest.approx(numbers["amplitude"], rel=0.05)


def test_a_class_that_does_not_exist_is_told():
    with pytest.raises(ValueError, match="no class 'gasp'; there are gap, offset_gap"):
        campaigns.draw(1, "gasp")


def test_a_diagnosis_that_fails_is_a_miss_with_its_reason(monkeypatch, gap):
    monkeypatch.setattr(trial, "draw", lambda *_: gap)

    def judge(log, model, seed):
        raise RuntimeError("no idea")

    outcome = trial.attempt(11, "gap", judge)
    assert not judging.exact(outcome)
    assert outcome.problem == "RuntimeError: no idea"
    assert json.dumps(outcome.as_json())
