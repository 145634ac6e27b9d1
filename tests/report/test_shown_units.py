"""The units that a person chooses: labels, sentences and numbers of the page follow."""

import re

import pytest

from shakerproc.errors import DocumentError
from shakerproc.report.figures.units import ShownUnits
from shakerproc.report.page.page import EXAMPLE, Report, html
from shakerproc.report.runs.in_units import run_in
from shakerproc.testlog import chosen_units, read_testlog
from shakerproc.workflows.campaign import units_of


def shown(*words):
    return ShownUnits(chosen_units(words))


@pytest.mark.parametrize(
    ("words", "unit", "wanted", "factor"),
    [
        (["SI"], "g²/Hz", "(m/s²)²/Hz", 9.80665**2),
        (["SI"], "(m/s)²/Hz", "(m/s)²/Hz", 1.0),
        (["in/s"], "(m/s)^6.4", "(in/s)^6.4", (1 / 0.0254) ** 6.4),
        (["mil", "lbf"], "N/mm", "lbf/mil", 0.0254 / 4.4482216152605),
        (["SI"], "g/N", "(m/s²)/N", 9.80665),
        (["in/s^2"], "N/g", "N/(in/s²)", 0.0254 / 9.80665),
        (["mil"], "m/s", "m/s", 1.0),
        (["mil"], "mm", "mil", 1 / 0.0254),
        (["psi", "m/m"], "µm/m", "m/m", 1e-6),
    ],
)
def test_powers_and_ratios_of_units_follow(words, unit, wanted, factor):
    name, found = shown(*words).unit(unit)
    assert name == wanted
    assert found == pytest.approx(factor)
    again, none = shown(*words).unit(name)
    assert (again, none) == (wanted, 1.0)


def test_quantities_in_sentences_follow_and_the_words_of_the_log_stay():
    units = shown("SI", "mil")
    said = "at 0.05 mm and 0.01 to 0.02 g²/Hz 5 g sensor saw 1.234567 g rms for 3 ms, 7 min"
    assert units.text(said, ["5 g sensor"]) == (
        "at 1.969 mil and 0.9617 to 1.923 (m/s²)²/Hz 5 g sensor saw 12.10697 m/s² rms "
        "for 3 ms, 7 min"
    )
    assert ShownUnits().text(said) == said


def test_every_number_of_a_run_follows_its_unit():
    run = run_in(EXAMPLE, shown("SI"))
    (channel,) = run.channels
    gravity = 9.80665
    assert (channel.unit, channel.rms) == ("m/s²", gravity)
    assert channel.psd_peaks[0].height == pytest.approx(10.0 * gravity**2)
    assert channel.response_peaks[0].height == pytest.approx(10.0)  # no control: over itself
    assert run.curves[0].y[1] == pytest.approx(gravity**2)
    assert run.analyses[0].panels[0].y.label == "amplitude [m/s²]"
    assert run.analyses[0].panels[0].lines[0].y[1] == pytest.approx(gravity)
    assert run.analyses[0].rows[0] == {"channel": "response", "largest [m/s²]": 3.0 * gravity}
    page = html(Report("t", (EXAMPLE,), channel="response", units=shown("SI")))
    body = page.partition("<body")[2].partition('<section id="methods">')[0]
    assert not re.search(r"\d g\b|\[g|g²/Hz", body)
    assert "29.42 m/s²" in body


@pytest.mark.parametrize("word", ["furlong", "Hz", "", "mil/"])
def test_a_wrong_unit_is_one_line(word):
    with pytest.raises(ValueError, match="expected SI, or units of acceleration") as caught:
        chosen_units([word])
    assert "\n" not in str(caught.value)


def test_a_wrong_unit_in_a_log_is_told_with_its_place(tmp_path):
    log = tmp_path / "log.yaml"
    start = (
        "testlog: 1\ntitle: A\nreport:\n  units: {}\ntests: [{{id: 1, recording: a.tdms}}]\n"
    )
    log.write_text(start.format("g, furlong"))
    with pytest.raises(DocumentError, match=r"log\.yaml:4:\d+: .*got \"furlong\""):
        read_testlog(log)
    log.write_text(start.format("[SI, mil]"))
    assert units_of(read_testlog(log))["m"] == ("mil", pytest.approx(2.54e-5))
    assert units_of(read_testlog(log), "mm") == {"m": ("mm", pytest.approx(1e-3))}


def test_cells_in_a_unit_of_their_own_column_follow_it():
    """A tone of 2.5 g is one of 24.5 m/s²: the number changes with its unit."""
    from tests.runs.test_sine_on_random import floor_of, processed, tones_of

    from shakerproc.runs import summary_of

    summary = summary_of(processed(floor_of() + tones_of()), "1", {}, "run.tdms", "")
    (before,) = [one for one in summary.analyses if one.kind == "tones"]
    (after,) = [one for one in run_in(summary, shown("SI")).analyses if one.kind == "tones"]
    gravity = 9.80665
    for old, new in zip(before.rows, after.rows, strict=True):
        assert (old["unit"], new["unit"]) == ("g", "m/s²")
        for name in ("amplitude", "amplitude_error", "demanded_amplitude", "least_in_parts"):
            assert new[name] == pytest.approx(gravity * old[name])
