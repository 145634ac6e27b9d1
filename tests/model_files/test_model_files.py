# ruff: noqa: E501 - one mistake a row
"""Model files: what is read, what is refused and in which words, what a change leaves alone."""

import difflib
import re

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from shakerproc.errors import DocumentError
from shakerproc.model_files import (
    NewNumbers,
    Provenance,
    add_element,
    change_parameters,
    element_text,
    model_text,
    read_model,
    read_model_file,
    write_model,
)
from shakerproc.model_files.writing import mode_text, number, within
from shakerproc.models.effects import EFFECTS, EXAMPLES, Damper, Gap, Spring, Stop
from shakerproc.models.faults import FAULT_EXAMPLES, Clipping, SensorDelay
from shakerproc.models.model import Element, Excitation, Model, Sensor
from shakerproc.models.structure import Mode
from shakerproc.units import to_si

TEXT = """\
# The joint of the radial coupon.
model: 1
title: radial coupon, glued joint      # from the tensile test

masses: {coupon: 28.6 g}
elements:
  # what the tensile test gave
  - {kind: spring, between: [base, coupon], stiffness: 1.2e5 N/m}   # secant

  - kind: damper            # a guess
    between: [base, coupon]
    damping: 1.5 N s/m      # to be fitted
  # end of the elements
excitation: {base: acceleration}    # or {force on: coupon}
sensors:                            # which channel name measures what
  ch3: {at: coupon, measures: acceleration}
  z: {at: coupon, measures: relative displacement}
"""


def written(tmp_path, text, name="model.yaml"):
    path = tmp_path / name
    path.write_bytes(text.encode())
    return path


def test_the_example_of_the_design_is_read(tmp_path):
    model = read_model(written(tmp_path, TEXT))
    assert model.title == "radial coupon, glued joint"
    assert dict(model.masses) == {"coupon": 0.0286}
    assert model.elements == (
        Element(Spring(1.2e5), ("base", "coupon")),
        Element(Damper(damping=1.5), ("base", "coupon")),
    )
    assert model.excitation == Excitation("base acceleration")
    assert model.sensors["ch3"] == Sensor("coupon", "acceleration")
    assert model.sensors["z"].measures == "relative displacement"


REFUSED = [
    ("kind: spring", "kind: sprng", r':8:12: elements\.1\.kind: unknown kind "sprng"; did you mean "spring"'),
    ("stiffness: 1.2e5 N/m", "stifness: 1.2e5 N/m", r':8:\d+: elements\.1\.\w+: unknown parameter "stifness" of spring; did you mean "stiffness"'),
    (", stiffness: 1.2e5 N/m", "", r":8:5: elements\.1: spring needs stiffness, such as stiffness: 1\.2e5 N/m"),
    ("1.2e5 N/m", "1.2e5", r":8:\d+: elements\.1\.stiffness: expected a number with a unit of N/m"),
    ("1.2e5 N/m", "1.2e5 kg", r":8:\d+: elements\.1\.stiffness: expected"),
    ("1.5 N s/m", "-1.5 N s/m", r":12:14: elements\.2\.damping: expected at least 0, such as 1\.5 N s/m"),
    ("    damping: 1.5 N s/m      # to be fitted\n", "", r":10:5: elements\.2: damper needs damping or damping_ratio"),
    ("[base, coupon], stiff", "[base, cupon], stiff", r':8:\d+: elements\.1\.between\.2: no place "cupon"; did you mean "coupon"'),
    ("[base, coupon], stiff", "[coupon, coupon], stiff", r":8:\d+: elements\.1\.between: expected two different places, got coupon twice"),
    ("[base, coupon], stiff", "[coupon], stiff", r":8:\d+: elements\.1\.between: expected two different places, got 1"),
    ("between: [base, coupon], stiff", "stiff", r":8:5: elements\.1: spring needs between"),
    ("28.6 g}", "-28.6 g}", r":5:18: masses\.coupon: expected more than 0"),
    ("{base: acceleration}", "{}", r":14:13: excitation: expected \{base: acceleration\}"),
    ("{base: acceleration}", "{force on: coupn}", r':14:\d+: excitation\.force on: no place "coupn"'),
    ("excitation: {base: acceleration}    # or {force on: coupon}\n", "", r'expected the key "excitation"'),
    ("at: coupon, measures: acceleration", "at: rim, measures: acceleration", r':16:13: sensors\.ch3\.at: no place "rim"'),
    ("measures: acceleration", "measures: accelleration", r':16:\d+: sensors\.ch3\.measures: .*did you mean "acceleration"'),
    ("model: 1", "model: 2", r":2:8: model: expected 1"),
    ("masses: {coupon: 28.6 g}", "masses: {coupon: 28.6 g, rim: 3 g}", r":6:1: elements: .*no chain of elements leads from rim"),
    ("1.2e5 N/m", "-1.2e5 N/m", r":6:1: elements: .*drives the mass away"),
    ("kind: spring, ", "", r":8:5: elements\.1: expected a kind"),
]  # fmt: skip


@pytest.mark.parametrize(("old", "new", "message"), REFUSED)
def test_what_is_wrong_is_said_with_line_and_column(tmp_path, old, new, message):
    assert old in TEXT
    path = written(tmp_path, TEXT.replace(old, new, 1))
    with pytest.raises(DocumentError, match=message) as caught:
        read_model(path)
    assert str(caught.value).startswith(str(path))
    assert "\n" not in str(caught.value)


def test_the_side_of_a_stop_is_a_word(tmp_path):
    stop = "{kind: stop, between: [base, coupon], stiffness: 1 N/m, clearance: 1 mm, side: up}"
    path = written(tmp_path, TEXT.replace("  # end", f"  - {stop}\n  # end"))
    with pytest.raises(
        DocumentError, match=r"elements\.3\.side: expected positive or negative"
    ):
        read_model(path)


@pytest.mark.parametrize("kind", EFFECTS)
def test_every_effect_survives_being_written_and_read(tmp_path, kind):
    elements = (
        Element(Spring(1.2345678901234e5), ("base", "coupon")),
        Element(EXAMPLES[kind], ("base", "coupon")),
    )
    sensors = {"ch 3": Sensor("coupon", "acceleration", tuple(FAULT_EXAMPLES.values()))}
    model = Model(
        "a: b # c", {"coupon": 0.1 / 3}, elements, Excitation("force", "coupon"), sensors
    )
    path = tmp_path / "model.yaml"
    write_model(model, path, heading="two\nlines")
    assert read_model(path) == model
    assert path.read_text().startswith("# two\n# lines\nmodel: 1\n")


@pytest.mark.parametrize("value", [0.0286, 5.1e-5, 1 / 3, 1e-9, 123456.789, 0.0, 2e6, -4e-4])
@pytest.mark.parametrize("unit", ["m", "kg", "s", "N/m", "1", "Hz", "N s/m", "1/s"])
def test_a_number_reads_back_exactly(value, unit):
    assert to_si(number(value, unit), unit) == value


def test_a_length_is_shown_in_millimetres():
    assert number(5e-5, "m") == "50 um"
    assert number(1.5e-3, "m") == "1.5 mm"
    assert number(0.0286, "kg") == "28.6 g"


def test_adding_an_effect_changes_nothing_else(tmp_path):
    path, out = written(tmp_path, TEXT), tmp_path / "new.yaml"
    gap = Element(Gap(1e5, 5.1e-5), ("base", "coupon"))
    add_element(path, gap, out)
    assert read_model(out).elements == (*read_model(path).elements, gap)
    added = list(difflib.unified_diff(TEXT.splitlines(), out.read_text().splitlines(), n=0))[2:]
    assert [line for line in added if line[0] in "+-"] == [f"+  - {element_text(gap)}"]
    lines = out.read_text().splitlines()
    assert lines.index(f"  - {element_text(gap)}") == lines.index("  # end of the elements") - 1


def test_changing_parameters_keeps_comments(tmp_path):
    path, out = written(tmp_path, TEXT), tmp_path / "new.yaml"
    change_parameters(path, {0: {"stiffness": 1.3e5}, 1: {"damping": 2.25}}, out)
    text = TEXT.replace("1.2e5 N/m", "130000 N/m").replace("1.5 N s/m", "2.25 N s/m")
    assert out.read_text() == text


PROVENANCE = Provenance(
    tests=(1, 8, "7b"),
    hashes={"Test_1/Acceleration.tdms": "0" * 64, "radial.yaml": "1e5" + "0" * 61},
    intervals={"clearance": (4.9e-5, 5.3e-5), "stiffness": (0.9e5, 1.1e5)},
    program="shakerproc 0.1",
    date="2026-11-21",
)


def test_the_provenance_is_kept_and_grows(tmp_path):
    path, out = written(tmp_path, TEXT), tmp_path / "new.yaml"
    gap = Element(Gap(1e5, 5.1e-5), ("base", "coupon"))
    add_element(path, gap, out, PROVENANCE, numbers=NewNumbers({0: {"stiffness": 1e5}}))
    stop = Element(Stop(1e6, 1e-3, "negative"), ("base", "coupon"))
    add_element(out, stop, out, Provenance(tests=(2,)))
    first, second = read_model_file(out).provenance
    assert (first.added, second.added) == ("gap", "stop")
    assert first.tests == (1, 8, "7b")
    assert first.sha256 == dict(PROVENANCE.hashes)
    assert to_si(first.intervals["clearance"][0], "m") == 4.9e-5
    assert first.from_model == "model.yaml"
    assert read_model(out).elements[0].effect == Spring(1e5)
    assert "# secant" in out.read_text()


BENDING = Mode(512.0, 0.01, 1e-3, {"coupon": 1.0})
HEAVIER = {"coupon": 0.0301}


def test_masses_change_and_further_modes_are_appended(tmp_path):
    path, out = written(tmp_path, TEXT), tmp_path / "new.yaml"
    gap = Element(Gap(1e5, 5.1e-5), ("base", "coupon"))
    add_element(
        path, gap, out, PROVENANCE, numbers=NewNumbers(masses=HEAVIER), modes=(BENDING,)
    )
    model = read_model(out)
    assert model.masses["coupon"] == 0.0301
    assert model.modes == (BENDING,)
    add_element(out, gap, out, PROVENANCE, modes=(BENDING, BENDING))
    assert read_model(out).modes == (BENDING,) * 3
    assert len(read_model_file(out).provenance) == 2


def test_modes_are_appended_to_those_in_brackets(tmp_path):
    text = TEXT + "modes: [" + mode_text(BENDING) + "]\n"
    path, out = written(tmp_path, text), tmp_path / "new.yaml"
    gap = Element(Gap(1e5, 5.1e-5), ("base", "coupon"))
    add_element(path, gap, out, modes=(BENDING, BENDING))
    assert read_model(out).modes == (BENDING,) * 3


@pytest.mark.parametrize("line_end", ["\n", "\r\n"])
@pytest.mark.parametrize("last_end", [True, False])
@pytest.mark.parametrize(
    "elements",
    [
        "elements: [{kind: spring, between: [base, a], stiffness: 1 N/m}]  # x",
        "elements: [\n  {kind: spring, between: [base, a], stiffness: 1 N/m},  # x\n]",
        "elements:\n- {kind: spring, between: [base, a], stiffness: 1 N/m}  # x",
        "elements:\n-   kind: spring\n    between:\n    - base\n    - a\n    stiffness: 1 N/m # x",
        "elements:\n  -\n    kind: \"spring\"\n    stiffness: '1 N/m'\n    between: [base,\n      a]  # x",
    ],
)
def test_elements_are_added_to_any_layout(tmp_path, elements, line_end, last_end):
    text = f"model: 1\nmasses: {{a: 1 kg}}\nexcitation: {{base: acceleration}}\n{elements}"
    text = (text + "\n" * last_end).replace("\n", line_end)
    path, out = written(tmp_path, text), tmp_path / "new.yaml"
    title = "x, with gap (base to a)"
    add_element(path, Element(Gap(1e5, 1e-5), ("base", "a")), out, PROVENANCE, title=title)
    model = read_model(out)
    assert model.title == title
    assert [element.effect.kind for element in model.elements] == ["spring", "gap"]
    new = out.read_bytes().decode()
    assert "# x" in new
    assert ("\r\n" in new) == (line_end == "\r\n")
    assert new.count("\n") == new.count(line_end)
    change_parameters(out, {0: {"stiffness": 3.0}, 1: {"clearance": 2e-5}}, out)
    assert read_model(out).elements[1].effect == Gap(1e5, 2e-5)


@pytest.mark.parametrize(
    "head",
    [
        "model: 1\ntitle: glued  # by hand",
        "model: 1  # one",
        "title: >\n  glued\n  joint\nmodel: 1",
        'title: "glued"\nmodel: 1',
    ],
)
def test_a_model_with_an_effect_more_has_a_title_that_names_it(tmp_path, head):
    rest = "masses: {a: 1 kg}\nexcitation: {base: acceleration}\nelements:\n"
    text = f"{head}\n{rest}- {{kind: spring, between: [base, a], stiffness: 1 N/m}}\n"
    path, out = written(tmp_path, text), tmp_path / "new.yaml"
    title = "glued, with gap: (base to a)"
    add_element(path, Element(Gap(1e5, 1e-5), ("base", "a")), out, title=title)
    assert read_model(out).title == title
    assert out.read_text().count("title:") == 1
    assert ("# by hand" in out.read_text()) == ("# by hand" in head)


@given(
    value=st.floats(1e-9, 1e9),
    half=st.floats(1e-6, 2.0),
    unit=st.sampled_from(["m", "N/m", "N", "1", "N s/m"]),
)
def test_a_fitted_number_has_the_digits_that_its_interval_bears_out(value, half, unit):
    low, high = value * (1.0 - half), value * (1.0 + half)
    found = within(value, unit, low, high)
    assert abs(found - value) <= 1.01e-3 * half * value
    assert to_si(number(found, unit), unit) == found
    digits = sum(c.isdigit() for c in f"{found:.17g}".split("e")[0].strip("0."))
    written_digits = len(re.sub(r"e.*| .*|\D", "", number(found, unit)).strip("0"))
    assert written_digits <= min(digits, max(2.0, 5.0 - np.log10(half)))


def test_a_fitted_number_without_an_interval_keeps_six_digits():
    assert within(91207.2665684035, "N/m", None, None) == 91207.3
    assert within(91207.2665684035, "N/m", 90848.8, 91565.7) == 91207.0
    assert within(5.0019179e-05, "m", 4.982e-05, 5.022e-05) == 5.0019e-05


def test_a_parameter_that_the_file_does_not_hold_cannot_be_changed(tmp_path):
    path = written(tmp_path, TEXT)
    with pytest.raises(DocumentError, match="damping_ratio does not stand there"):
        change_parameters(path, {1: {"damping_ratio": 0.1}}, tmp_path / "new.yaml")
    assert not (tmp_path / "new.yaml").exists()


def test_an_alias_is_not_changed_behind_the_users_back(tmp_path):
    text = TEXT.replace("1.2e5 N/m}", "&k 1.2e5 N/m}").replace(
        "  # end", "  - {kind: spring, between: [base, coupon], stiffness: *k}\n  # end"
    )
    path = written(tmp_path, text)
    with pytest.raises(DocumentError, match=r"cannot be changed in place.*Change it by hand"):
        change_parameters(path, {2: {"stiffness": 5.0}}, tmp_path / "new.yaml")


def test_faults_are_read(tmp_path):
    faults = "faults: [{kind: sensor_delay, delay: 20 us}, {kind: clipping, level: 5 g}]"
    text = TEXT.replace("measures: acceleration}", f"measures: acceleration, {faults}}}")
    sensor = read_model(written(tmp_path, text)).sensors["ch3"]
    assert sensor.faults == (SensorDelay(2e-5), Clipping(5 * 9.80665))


def test_an_attached_mode_may_name_its_place_alone(tmp_path):
    mode = "{kind: attached_mode, between: [coupon], mass: 1 g, frequency: 200 Hz, damping_ratio: 1 %}"
    text = TEXT.replace("  # end", f"  - {mode}\n  # end")
    assert read_model(written(tmp_path, text)).elements[2].between == ("base", "coupon")


def test_the_text_of_a_model_is_short():
    model = Model(
        "x", {"a": 1.0}, (Element(Spring(5.0), ("base", "a")),), Excitation("base acceleration")
    )
    assert model_text(model) == (
        "model: 1\ntitle: x\nmasses: {a: 1 kg}\nelements:\n"
        "  - {kind: spring, between: [base, a], stiffness: 5 N/m}\n"
        "excitation: {base: acceleration}\n"
    )
