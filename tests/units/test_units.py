"""Text with a unit to SI: known conversions, and what is said about mistakes."""

import math
from typing import Annotated

import pytest
from hypothesis import given
from hypothesis import strategies as st
from pydantic import BaseModel, ValidationError

from shakerproc.data import STANDARD_GRAVITY
from shakerproc.units import (
    from_si,
    in_unit,
    is_same_unit,
    is_unit_of,
    near_miss,
    problem_of_unit,
    to_si,
)

G = 9.80665  # ISO 80000-3, written out: data.STANDARD_GRAVITY is checked against it below


@pytest.mark.parametrize(
    ("text", "unit", "value"),
    [
        ("0.05 mm", "m", 5e-5),
        ("5 µm", "m", 5e-6),  # micro sign
        ("5 μm", "m", 5e-6),  # Greek letter
        ("5 um", "m", 5e-6),
        ("2 in", "m", 0.0508),
        ("-1.5e-3mm", "m", -1.5e-6),
        ("0.5 g", "m/s^2", 0.5 * G),
        ("28.6 g", "kg", 0.0286),
        ("10 mg", "kg", 1e-5),
        ("10 mg", "m/s^2", 0.01 * G),
        ("9.81 m/s²", "m/s^2", 9.81),
        ("9.81 m s^-2", "m/s^2", 9.81),
        ("0.0002 g^2/Hz", "g^2/Hz", 0.0002 * G**2),
        ("0.0002 g²/Hz", "(m/s^2)^2/Hz", 0.0002 * G**2),
        ("1 (m/s^2)^2/Hz", "g^2/Hz", 1.0),
        ("1 oct/min", "oct/min", 1.0 / 60.0),
        ("60 oct/min", "oct/s", 1.0),
        ("2 dec/min", "oct/min", 2.0 * math.log2(10.0) / 60.0),
        ("1.5 N s/m", "N s/m", 1.5),
        ("1.5 N*s/m", "N s/m", 1.5),
        ("1.5 N·s/m", "N s/m", 1.5),
        ("1.5 Ns/m", "N s/m", 1.5),
        ("120 N/mm", "N/m", 1.2e5),
        ("1.2e5 N/m", "N/m", 1.2e5),
        ("3 kN/mm", "N/m", 3e6),
        ("1e8 N/m^3", "N/m^3", 1e8),
        ("1 N/(m/s)^2", "N s^2/m^2", 1.0),
        ("5.6889 kHz", "Hz", 5688.9),
        ("3000 rpm", "Hz", 50.0),
        ("2 Hz/s", "Hz/s", 2.0),
        ("6 min", "s", 360.0),
        ("0.001 1/s", "1/s", 0.001),
        ("100 mV/g", "V/(m/s^2)", 0.1 / G),
        ("2 %", "1", 0.02),
        ("2%", "%", 0.02),
        ("0.02", "1", 0.02),
        (0.02, "1", 0.02),
        (1, "1", 1.0),
        ("3 dB", "dB", 3.0),
        ("6 dB/oct", "dB/oct", 6.0),
        ("23 degC", "K", 296.15),
        ("23 °C", "degC", 296.15),
        ("23 deg C", "degC", 296.15),
        ("90 deg", "rad", math.pi / 2.0),
        ("2.8 GPa", "Pa", 2.8e9),
        ("1 lbf", "N", 4.4482216152605),
        ("1 kip", "N", 4448.2216152605),
        ("2.5 kip/in", "N/m", 2.5 * 4448.2216152605 / 0.0254),
        ("10 lbf/in", "N/m", 10.0 * 4.4482216152605 / 0.0254),
        ("1 lbf s/in", "N s/m", 4.4482216152605 / 0.0254),
        ("1 lbf s^2/in", "kg", 4.4482216152605 / 0.0254),
        ("1 slug", "kg", 4.4482216152605 / 0.3048),
        ("1 psi", "Pa", 4.4482216152605 / 0.0254**2),
        ("36 ksi", "Pa", 36e3 * 4.4482216152605 / 0.0254**2),
        ("5 mil", "m", 5 * 2.54e-5),
        ("5 mils", "m", 5 * 2.54e-5),
        ("1000 thou", "m", 0.0254),
        ("1 ips", "m/s", 0.0254),
        ("1 kgf", "N", G),
        ("16 oz", "kg", 0.45359237),
        ("16 ozf", "N", 4.4482216152605),
        ("10 microstrain", "1", 1e-5),
        ("3000 rpm", "rad/s", 100.0 * math.pi),  # a speed where one is wanted, else a frequency
        ("1 rev/s", "rad/s", 2.0 * math.pi),
        ("1 N m/deg", "N m/rad", 180.0 / math.pi),
        ("12 Nm", "N m", 12.0),
        ("2 kg m^2", "kg m^2", 2.0),
        ("10 pC/g", "C/(m/s^2)", 1e-11 / G),
        ("2 g/sqrt(Hz)", "(m/s^2)^2/Hz", 4.0 * G**2),  # the root of a density
        ("2 g/√Hz", "g^2/Hz", 4.0 * G**2),
        ("0 dB re 1 g", "m/s^2", G),
        ("120 dB re 1e-6 m/s^2", "m/s^2", 1.0),  # 20 dB a decade of amplitude
        ("60 dB re 1 µm/s", "m/s", 1e-3),
        ("10 dB re 1 (m/s^2)^2/Hz", "(m/s^2)^2/Hz", 10.0),  # 10 dB a decade of power
        ("1.41e3 kg/m^3", "kg/m^3", 1410.0),
        ("0.5\u00a0g", "m/s^2", 0.5 * G),  # a space that does not break, from a word processor
        ("\u22120.5 g", "m/s^2", -0.5 * G),  # a minus sign from there
    ],
)
def test_a_quantity_becomes_its_si_value(text, unit, value):
    assert to_si(text, unit) == pytest.approx(value, rel=1e-15)


@pytest.mark.parametrize(("text", "kelvin"), [("32 degF", 273.15), ("212 °F", 373.15)])
def test_water_freezes_and_boils_in_fahrenheit(text, kelvin):
    assert to_si(text, "K") == pytest.approx(kelvin, rel=1e-15)


@pytest.mark.parametrize(
    ("text", "unit", "match"),
    [
        ("3,2 g", "m/s^2", r"got \"3,2 g\"; use a decimal point: 3\.2 g$"),
        ("0,001 Hz", "Hz", r"use a decimal point: 0\.001 Hz$"),
        ("1,000 Hz", "Hz", r"use a decimal point: 1\.000 Hz, or 1000 Hz$"),
        ("0.5", "m/s^2", r"such as 0\.5 g, got \"0\.5\"; the unit is missing"),
        (0.5, "m/s^2", r"got 0\.5; write it with its unit, as 0\.5 g"),
        (None, "m", "got nothing"),
        (True, "m", "got true"),
        (True, "1", "got true"),
        ([1.0], "m", "got a list"),
        ({}, "m", "got a mapping"),
        ("abc", "m", r"a number with a unit of m, such as 0\.05 mm, got \"abc\"$"),
        ("", "m", 'got ""'),
        ("0.5 hz", "Hz", 'no unit "hz"; did you mean "Hz"'),
        ("0.5 KHz", "Hz", 'did you mean "kHz"'),
        ("0.5 G", "m/s^2", 'did you mean "g"'),
        ("500 lb/in", "N/m", '"lb/in" is not such a unit; of force, write lbf/in$'),
        ("0.5 Kg", "kg", 'did you mean "kg"'),
        ("0.5 mm", "Hz", '"mm" is not such a unit'),
        ("0.5 g", "N", '"g" is not such a unit'),
        ("0.5 rad/s", "Hz", '"rad/s" is not such a unit'),
        ("3 dB", "m/s^2", r"such as 120 dB re 1e-6 m/s\^2$"),
        ("20 dB re 1 N", "m/s^2", '"N" is not such a unit'),
        ("1 oct", "oct/min", '"oct" is not such a unit'),
        ("1 oct per min", "oct/min", 'no unit "per"'),
        ("5 - 500 Hz", "Hz", "not written as a unit"),
        ("5..500 Hz", "Hz", "is not a unit"),
        ("5 Hz.", "Hz", "is not a unit"),
        ("1 m/", "m", "not written as a unit"),
        ("1e999 m", "m", "the number is too large"),
        ("9" * 100 + " m", "m", "the number is too long"),
        ("nan m", "m", 'got "nan m"'),
        ("inf m", "m", 'got "inf m"'),
        ("1 m^99999999", "m", "not written as a unit"),
        ("1 m**9**9**9", "m", "not written as a unit"),
        ("1 ((((m))))", "m", "not written as a unit"),
        ("1 __import__('os')", "m", "is not a unit"),
        ("1 " + "m" * 100, "m", "is not a unit"),
        ("1 \x1b[31m", "m", r"\\x1b\[31m"),
        ("x" * 1000, "m", r"x\.\.\."),
    ],
)
def test_a_mistake_is_told_with_an_example(text, unit, match):
    with pytest.raises(ValueError, match=match) as caught:
        to_si(text, unit)
    assert "expected" in str(caught.value)
    assert len(str(caught.value)) < 250
    assert str(caught.value).isprintable()


def test_wanting_no_unit_is_the_callers_mistake():
    with pytest.raises(ValueError, match="cannot want the unit"):
        to_si("1 m", "furlong")


def test_gravity_is_the_standard_one():
    assert G == STANDARD_GRAVITY


@pytest.mark.parametrize(
    ("value", "unit", "shown", "number"),
    [
        (5e-5, "m", "mm", 0.05),
        (0.5 * G, "m/s^2", "g", 0.5),
        (0.0286, "kg", "g", 28.6),
        (1.0 / 60.0, "oct/min", "oct/min", 1.0),
        (296.15, "K", "degC", 23.0),
        (0.02, "1", "%", 2.0),
    ],
)
def test_from_si_is_how_people_write_it(value, unit, shown, number):
    assert from_si(value, unit, shown) == pytest.approx(number, rel=1e-14)


def test_from_si_refuses_another_quantity():
    with pytest.raises(ValueError, match='"mm" is not such a unit'):
        from_si(1.0, "Hz", "mm")


units = st.sampled_from([
    ("m", "mm"), ("m", "µm"), ("m/s^2", "g"), ("kg", "g"), ("Hz", "kHz"), ("N/m", "N/mm"),
    ("N s/m", "N s/mm"), ("oct/min", "oct/min"), ("g^2/Hz", "g^2/Hz"), ("1", "%"), ("s", "min"),
    ("K", "degC"),
])  # fmt: skip


@given(st.floats(1e-12, 1e12), units)
def test_what_is_written_is_read_back(number, unit):
    wanted, written = unit
    assert from_si(to_si(f"{number!r} {written}", wanted), wanted, written) == pytest.approx(
        number, rel=1e-14, abs=1e-12
    )


def said_about(text: str, unit: str) -> str:
    """Return the message of a ValueError, or what is said where there is none."""
    try:
        return "" if math.isfinite(to_si(text, unit)) else "not finite"
    except ValueError as error:
        return str(error)


@given(st.text(max_size=60), st.sampled_from(["m/s^2", "1", "K"]))
def test_any_text_is_a_quantity_or_is_told_what_was_expected(text, unit):
    said = said_about(text, unit)
    assert said == "" or said.startswith("expected")


@given(st.text("0123456789mgsHzNk/*^()- %°µ²", max_size=12))
def test_any_unit_is_understood_or_is_told_what_was_expected(unit):
    said = said_about(f"1 {unit}", "m/s^2")
    assert said == "" or said.startswith("expected")


def test_units_are_compared_by_what_they_measure():
    assert is_unit_of("mm", "m")
    assert not is_unit_of("mm", "Hz")
    assert is_same_unit("m/s²", "m/s^2")
    assert not is_same_unit("g", "m/s^2")
    assert not is_same_unit("", "g")
    assert not is_same_unit("blub", "blub")
    assert problem_of_unit("g") is None
    assert "missing" in (problem_of_unit(" ") or "")
    assert 'did you mean "Hz"' in (problem_of_unit("hz") or "")


def test_near_misses_prefer_what_differs_by_case_or_spaces():
    assert near_miss("Sine_Sweep", ("sine", "sine sweep")) == "sine sweep"
    assert near_miss("levl", ("level", "rate")) == "level"
    assert near_miss("gpa", ("damper", "gap", "spring")) == "gap"
    assert near_miss("ch9", ("ch3", "ch4")) is None
    assert near_miss("xyz", ("level", "rate")) is None


class Written(BaseModel):
    length: Annotated[float, in_unit("m")] = 0.0
    positive: Annotated[float, in_unit("m", positive=True)] = 1.0
    not_negative: Annotated[float, in_unit("m", not_negative=True)] = 1.0


def test_a_field_of_a_schema_is_written_with_its_unit():
    assert Written.model_validate({"length": "-2 mm"}).length == -0.002
    assert Written.model_validate({"not_negative": "0 mm"}).not_negative == 0.0


@pytest.mark.parametrize(
    ("field", "written", "match"),
    [
        ("positive", "0 mm", r"expected more than 0, such as 0\.05 mm, got \"0 mm\""),
        ("not_negative", "-1 mm", "expected at least 0"),
        ("length", 0.05, "write it with its unit"),
    ],
)
def test_a_field_refuses_what_is_out_of_bounds(field, written, match):
    with pytest.raises(ValidationError, match=match):
        Written.model_validate({field: written})
