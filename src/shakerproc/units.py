"""Text with a unit, to SI numbers (pint, loaded for the first unit that is no usual one).

SI means the base units: `to_si("1 oct/min", "oct/min")` is 1/60, in octaves per second, and
`to_si("23 degC", "K")` is 296.15. The unit that is wanted decides what `g` stands for: gravity
(9.80665 m/s²) where an acceleration is wanted, grams where a mass is.
"""

import difflib
import math
import re
from collections.abc import Mapping
from functools import lru_cache
from types import MappingProxyType
from typing import TYPE_CHECKING, Any, Final, TypeAlias

from shakerproc.data import STANDARD_GRAVITY

if TYPE_CHECKING:
    from pint import UnitRegistry
    from pydantic import BeforeValidator


Meaning: TypeAlias = tuple[float, dict[str, float]]
"""Scale to SI, and powers of the dimensions."""

_LENGTH: Final = "[length]"
_TIME: Final = "[time]"
_MASS: Final = "[mass]"
_CURRENT: Final = "[current]"

_VOLTAGE: Final = {_MASS: 1.0, _LENGTH: 2.0, _TIME: -3.0, _CURRENT: -1.0}
_SENSITIVITY: Final = {_MASS: 1.0, _LENGTH: 1.0, _TIME: -1.0, _CURRENT: -1.0}
_ACCELERATION: Final = {_LENGTH: 1.0, _TIME: -2.0}
_FORCE: Final = {_MASS: 1.0, _LENGTH: 1.0, _TIME: -2.0}
_DENSITY: Final = {_LENGTH: 2.0, _TIME: -3.0}

_ANYHOW: Final[Mapping[str, Meaning]] = MappingProxyType({
    "1": (1.0, {}),
    "%": (0.01, {}),
    "Hz": (1.0, {_TIME: -1.0}),
    "kHz": (1000.0, {_TIME: -1.0}),
    "Hz/s": (1.0, {_TIME: -2.0}),
    "s": (1.0, {_TIME: 1.0}),
    "ms": (0.001, {_TIME: 1.0}),
    "min": (60.0, {_TIME: 1.0}),
    "oct/min": (1.0 / 60.0, {"[octave]": 1.0, _TIME: -1.0}),
    "dB": (1.0, {"[level]": 1.0}),
    "m": (1.0, {_LENGTH: 1.0}),
    "mm": (0.001, {_LENGTH: 1.0}),
    "m/s": (1.0, {_LENGTH: 1.0, _TIME: -1.0}),
    "m/s^2": (1.0, _ACCELERATION),
    "(m/s^2)^2/Hz": (1.0, _DENSITY),
    "N": (1.0, _FORCE),
    "kN": (1000.0, _FORCE),
    "N/m": (1.0, {_MASS: 1.0, _TIME: -2.0}),
    "N s/m": (1.0, {_MASS: 1.0, _TIME: -1.0}),
    "kg": (1.0, {_MASS: 1.0}),
    "Pa": (1.0, {_MASS: 1.0, _LENGTH: -1.0, _TIME: -2.0}),
    "V": (1.0, _VOLTAGE),
    "V/(m/s^2)": (1.0, _SENSITIVITY),
})

_BY_GRAVITY: Final[Mapping[tuple[str, str], Meaning]] = MappingProxyType({
    ("g", "g_n"): (9.80665, _ACCELERATION),
    ("g", "gram"): (0.001, {_MASS: 1.0}),
    ("g^2/Hz", "g_n"): (96.17038422249999, _DENSITY),
    ("g^2/Hz", "gram"): (1e-6, {_MASS: 2.0, _TIME: 1.0}),
})

USUAL: Final[Mapping[tuple[str, str], Meaning]] = MappingProxyType({
    **{(unit, g): meaning for unit, meaning in _ANYHOW.items() for g in ("g_n", "gram")},
    **_BY_GRAVITY,
})
"""Meaning of a unit, by its text and by what g means in it: ``g_n`` or ``gram``."""


_DEFINITIONS: Final = f"""
pico- = 1e-12 = p-
nano- = 1e-9 = n-
micro- = 1e-6 = µ- = u-
milli- = 1e-3 = m-
kilo- = 1e3 = k-
mega- = 1e6 = M-
giga- = 1e9 = G-
metre = [length] = m = meter
second = [time] = s = sec
gram = [mass]
ampere = [current] = A
kelvin = [temperature] = K
radian = [angle] = rad
octave = [octave] = oct
decade = 3.321928094887362 * octave = dec
decibel = [level] = dB
minute = 60 * second = min
hour = 3600 * second = h
hertz = 1 / second = Hz
rpm = hertz / 60
degree = 0.017453292519943295 * radian = deg
revolution = 6.283185307179586 * radian = rev
newton = 1000 * gram * metre / second**2 = N
newton_metre = newton * metre = Nm
newton_second = newton * second = Ns
pascal = newton / metre**2 = Pa
joule = newton * metre = J
watt = joule / second = W
volt = watt / ampere = V
coulomb = ampere * second = C
centimetre = 0.01 * metre = cm
inch = 0.0254 * metre = in
foot = 0.3048 * metre = ft
tonne = 1e6 * gram = t
pound = 453.59237 * gram = lb
pound_force = 4.4482216152605 * newton = lbf
kilopound_force = 1000 * pound_force = kip
pound_per_square_inch = pound_force / inch**2 = psi
kilopound_per_square_inch = 1000 * pound_per_square_inch = ksi
slug = pound_force * second**2 / foot
thousandth_of_an_inch = 0.001 * inch = mil = mils = thou
inch_per_second = inch / second = ips
kilogram_force = 9.80665 * newton = kgf
gram_force = 0.00980665 * newton = gf
ounce = 28.349523125 * gram = oz
ounce_force = 0.27801385095378125 * newton = ozf
strain = 1
microstrain = 1e-6 = ustrain
gravity = {STANDARD_GRAVITY!r} * metre / second**2 = g_n = gn = g0
"""

_EXAMPLES: Final = {
    "m": "0.05 mm",
    "m/s^2": "0.5 g",
    "kg": "28.6 g",
    "s": "2 s",
    "Hz": "500 Hz",
    "1/s": "0.001 1/s",
    "N": "20 N",
    "N/m": "1.2e5 N/m",
    "N s/m": "1.5 N s/m",
    "oct/min": "1 oct/min",
    "oct/s": "1 oct/min",
    "(m/s^2)^2/Hz": "0.01 g^2/Hz",
    "g^2/Hz": "0.01 g^2/Hz",
    "1": "2 %",
    "%": "2 %",
    "K": "23 degC",
    "degC": "23 degC",
    "rad": "0.5 deg",
    "rad/s": "3000 rpm",
    "N m": "12 N m",
    "kg m^2": "0.02 kg m^2",
    "N m/rad": "1.2e4 N m/rad",
}

_SMALLEST, _LARGEST = 1e-21, 1e21
"""Sizes that are read, in SI: far beyond any test, and far within what can be computed with."""

_SYMBOLS: Final = (
    "m", "mm", "µm", "um", "nm", "cm", "km", "in", "ft", "s", "ms", "µs", "us", "min", "h",
    "Hz", "kHz", "MHz", "g", "kg", "mg", "lb", "t", "N", "kN", "mN", "MN", "lbf", "kip", "Pa",
    "kPa", "MPa", "GPa", "psi", "ksi", "slug", "mil", "J", "W", "V", "mV", "C", "pC",
    "A", "K", "degC", "degF", "rad", "deg", "rev", "rpm", "oct", "dec", "dB", "%", "m/s",
    "mm/s", "ips", "thou", "kgf", "oz", "ozf", "microstrain", "rad/s", "rad/s^2", "N m",
    "N m/rad", "kg m^2",
    "m/s^2", "mm/s^2", "g^2/Hz", "(m/s^2)^2/Hz", "N/m", "N/mm",
    "N s/m", "N s/mm", "lbf/in", "kip/in", "lbf s/in", "oct/min",
    "oct/s", "Hz/s", "dB/oct", "1/s", "mV/g",
)  # fmt: skip

_SPELLINGS: Final = {
    "volt": "V", "volts": "V", "millivolts": "mV", "g's": "g", "gs": "g", "gn": "g", "g_n": "g",
    "gravity": "g", "newton": "N", "newtons": "N", "metre": "m", "meter": "m", "meters": "m",
    "m/s/s": "m/s^2", "m/s2": "m/s^2", "m/s**2": "m/s^2", "m/sec^2": "m/s^2",
    "mm/s2": "mm/s^2", "inch": "in", "inches": "in", "pascal": "Pa", "pascals": "Pa",
    "in/sec": "in/s", "rad/s2": "rad/s^2", "deg/s2": "deg/s^2",
    "degrees": "deg", "degree": "deg", "radian": "rad", "radians": "rad",
    "n.m": "N m", "n-m": "N m", "newton metre": "N m", "newton meter": "N m",
    "°f": "degF", "deg f": "degF", "fahrenheit": "degF", "°c": "degC", "celsius": "degC",
    "strain": "m/m", "microstrain": "µm/m", "ustrain": "µm/m", "µstrain": "µm/m", "µε": "µm/m",
}  # fmt: skip
"""What measuring programs and people write for a unit, in small letters."""

_PREFIXED: Final = ("m", "s", "N", "Pa", "J", "W", "V", "C", "A", "Hz", "Nm", "Ns")
_ALONE: Final = (
    "metre", "meter", "second", "sec", "minute", "hour", "gram", "tonne", "kelvin", "radian",
    "degree", "octave", "decade", "decibel", "hertz", "newton", "pascal", "volt", "inch",
    "foot", "gravity", "cm", "in", "ft", "min", "h", "g_n", "gn", "g0", "g", "kg", "mg", "lb",
    "t", "lbf", "kip", "psi", "ksi", "slug", "mil", "mils", "thou", "ips", "kgf", "gf", "oz",
    "ozf", "K", "degC", "degF", "rad", "deg", "rev", "rpm", "oct", "dec", "dB", "%", "strain",
    "microstrain", "ustrain",
)  # fmt: skip
_KNOWN: Final = frozenset(_ALONE) | {p + u for p in ("", *"pnµumkMG") for u in _PREFIXED}
"""Symbols that are read; pint alone would take Min for a million inches."""

_NUMBER: Final = re.compile(r"[+-]?(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?")
_COMMA: Final = re.compile(r"[+-]?\d+,\d+(?:[eE][+-]?\d+)?")
_WRITABLE: Final = re.compile(r"[A-Za-zµΩ0-9_%/*^()\- ]{0,40}")
_SYMBOL: Final = re.compile(r"[A-Za-zµΩ_%]+")
_ROOT: Final = re.compile(
    r"(?P<amplitude>.+?)\s*(?:rms)?\s*/\s*"
    r"(?:√\s*\(?Hz\)?|sqrt\(Hz\)|rtHz|Hz\^0\.5|Hz\^\(1/2\))"
)
"""The root of a spectral density, as in ``g/sqrt(Hz)``."""
_DECIBELS: Final = re.compile(r"dB\s*\(?re\.?:?\s*(?P<reference>[^()]+|.+\^.+/.+)\)?", re.I)
"""A level with its reference, as in ``dB re 1 µm/s``."""
_TEMPERATURES: Final = {"K": (1.0, 0.0), "degC": (1.0, 273.15), "degF": (5.0 / 9.0, 459.67)}
"""Size of a degree [K], and the degrees from absolute zero to its zero."""
_HALF_POWER: Final = re.compile(r"(\^-?[0-9])\.5(?![0-9])")
"""A power of a half, as in ``N/m^1.5``; the only ones that are not whole."""
_POWER: Final = re.compile(r"(?<=[A-Za-z)])([23])(?![0-9.])")
"""A power without its sign, as in ``g2/Hz``."""
_SUPERSCRIPT: Final = str.maketrans("⁻⁰¹²³⁴⁵⁶⁷⁸⁹", "-0123456789")
_LOOK_ALIKE: Final = str.maketrans({"μ": "µ", "·": "*", "×": "*", "−": "-", "\u00a0": " "})


def to_si(text: object, unit: str) -> float:
    """Return the SI value of a number with a unit.

    Parameters
    ----------
    text : str
        Such as ``0.05 mm``; what is no text is refused in the same words, for schemas.
    unit : str
        Any unit of the quantity that is wanted, such as ``m``; ``1`` wants a ratio, which may
        be written as a bare number or in ``%``.

    Raises
    ------
    ValueError
        If the text is no number with a unit of this quantity. The message says what was
        expected, what was found, and gives an example.

    Examples
    --------
    >>> to_si("0.05 mm", "m")
    5e-05
    >>> to_si("28.6 g", "kg"), to_si("0.5 g", "m/s^2")
    (0.0286, 4.903325)
    """
    if unit in {"1", "%"} and isinstance(text, int | float) and not isinstance(text, bool):
        text = repr(text)
    if not isinstance(text, str):
        raise ValueError(_expected(unit, text) + _advice_for_number(text, unit))
    return _to_si(text, unit)


@lru_cache(maxsize=4096)
def _to_si(text: str, unit: str) -> float:
    """Do as `to_si`; a log sheet says the same thing many times.

    Raises
    ------
    ValueError
        As `to_si` does.
    """
    number, rest = _split(text, unit)
    if not rest and unit not in {"1", "%"}:
        raise ValueError(_expected(unit, text) + "; the unit is missing")
    scale, offset = _factor_or_error(rest, unit, text)
    if level := _DECIBELS.fullmatch(rest):
        return _to_si(_with_number(level["reference"]), unit) * _ratio(number, unit)
    if _ROOT.fullmatch(rest):
        number = number**2
    value = (number + offset) * scale if offset else _scaled(number, scale)
    if value and not _SMALLEST <= abs(value) <= _LARGEST:
        raise ValueError(
            _expected(unit, text)
            + f"; the number is too {'large' if abs(value) > 1.0 else 'small'}: sizes from "
            f"{_SMALLEST:g} to {_LARGEST:g} {unit} are read"
        )
    return value


def _with_number(reference: str) -> str:
    """Return the reference of a level with its number: ``dB re g`` means 1 g."""
    return reference if _NUMBER.match(reference.strip()) else f"1 {reference}"


def _ratio(decibels: float, unit: str) -> float:
    """Return the ratio that a level stands for: of powers in a density, else of amplitudes.

    Raises
    ------
    ValueError
        If it is larger than any ratio of a test.
    """
    if abs(decibels) > 400.0:
        raise ValueError(f"expected a level within 400 dB of its reference, got {decibels:g}")
    return float(10.0 ** (decibels / (10.0 if "^2/Hz" in unit else 20.0)))


def is_linear(unit: str) -> bool:
    """Return whether numbers in a unit may be scaled: not so decibels and temperatures."""
    return not (unit.strip().casefold().startswith("db") or _is_temperature(unit))


def sensitivity(text: str, unit: str) -> tuple[str, float]:
    """Return the electrical unit of a sensor's output, and how many of it make an SI unit.

    Parameters
    ----------
    text : str
        Such as ``100 mV/g`` or ``25 pC/N``.
    unit : str
        SI unit of what the sensor measures.

    Returns
    -------
    str
        ``V``, or ``C`` of a charge.
    float
        Output per `unit` [V or C].

    Raises
    ------
    ValueError
        If it is neither.

    Examples
    --------
    >>> sensitivity("2 V/N", "N"), sensitivity("50 pC/N", "N")
    (('V', 2.0), ('C', 5e-11))
    """
    try:
        return "C", to_si(text, f"C/({unit})")
    except ValueError:
        return "V", to_si(text, f"V/({unit})")


def fits_sensitivity(text: str, unit: str) -> bool:
    """Return whether a text is a sensitivity of a sensor that measures an SI unit."""
    try:
        return "/" in text and sensitivity(text, unit)[1] != 0.0
    except ValueError:
        return False


def from_si(value: float, unit: str, shown: str) -> float:
    """Return an SI value in the unit that it is shown in.

    Parameters
    ----------
    value : float
        In SI base units.
    unit : str
        Any unit of the quantity, as for `to_si`.
    shown : str
        Unit of the number that is returned.

    Raises
    ------
    ValueError
        If `shown` is no unit of that quantity.

    Examples
    --------
    >>> from_si(5e-5, "m", "mm")
    0.05
    """
    scale, offset = _factor_or_error(shown, unit, shown)
    return (value / scale if scale >= 1.0 else value * _reciprocal(scale)) - offset


def in_unit(
    unit: str, *, positive: bool = False, not_negative: bool = False
) -> "BeforeValidator":
    """Return the validator by which a pydantic float field is written with a unit."""
    from pydantic import BeforeValidator  # a worker that reads no log needs none of it

    def parsed(value: object) -> float:
        number = to_si(value, unit)
        if (positive and number <= 0.0) or (not_negative and number < 0.0):
            bound = "more than 0" if positive else "at least 0"
            raise ValueError(f"expected {bound}, such as {example(unit)}, got {quoted(value)}")
        return number

    return BeforeValidator(parsed)


def is_unit_of(unit: str, wanted: str) -> bool:
    """Return whether a unit measures the same quantity as another."""
    return not isinstance(_factor(unit, wanted), str)


def spelled(unit: str) -> str:
    """Return a unit as it is written here: ``m/s^2`` for ``m/s2``, ``V`` for ``Volts``."""
    return _SPELLINGS.get(unit.strip().casefold(), unit.strip())


def numbered(unit: str) -> tuple[float, str]:
    """Return how many of a unit one count stands for, and the unit: ``10 V`` is 10 of ``V``.

    Examples
    --------
    >>> numbered("10 V"), numbered("m/s^2"), numbered("1e-3g")
    ((10.0, 'V'), (1.0, 'm/s^2'), (0.001, 'g'))
    """
    plain = unit.translate(_LOOK_ALIKE).strip()
    match = _NUMBER.match(plain)
    if match is None or match.end() in {len(plain), plain.find("/")}:
        return 1.0, unit
    return float(match[0]), plain[match.end() :].strip()


def any_quantity(written: object) -> tuple[float, str]:
    """Return a quantity of any kind [SI], and the unit that it is written in.

    Raises
    ------
    ValueError
        If it is no number with a unit.
    """
    wanted = f"expected a quantity with its unit, such as 2 V, got {quoted(written)}"
    if not isinstance(written, str):
        raise ValueError(wanted)
    unit = spelled(numbered(written)[1])
    if unit == written or problem_of_unit(unit) is not None:
        raise ValueError(wanted)
    return to_si(written, unit), unit


def is_same_unit(unit: str, other: str) -> bool:
    """Return whether two units are the same, however written: ``m/s²`` is ``m/s^2``."""
    parsed = _parsed(spelled(unit), "g_n") if unit.strip() else unit
    return parsed == _parsed(spelled(other), "g_n") and not isinstance(parsed, str)


def problem_of_unit(unit: str) -> str | None:
    """Return the error in a unit that stands alone, or None."""
    parsed = _parsed(unit, "g_n") if unit.strip() else "the unit is missing"
    return parsed if isinstance(parsed, str) else None


def example(unit: str) -> str:
    """Return how a quantity may be written, such as ``0.05 mm`` for ``m``."""
    return _EXAMPLES.get(unit, f"1.5 {unit}")


def near_miss(word: str, known: tuple[str, ...] | list[str]) -> str | None:
    """Return the known word that was most likely meant, if one is near."""
    by_folded = {_folded(name): name for name in reversed(known)}
    folded = _folded(word)
    if folded in by_folded:
        return by_folded[folded]
    exchanged = [name for name in by_folded if sorted(name) == sorted(folded)]
    matches = [*difflib.get_close_matches(folded, by_folded, n=1, cutoff=0.7), *exchanged]
    return by_folded[matches[0]] if matches else None


def _folded(word: str) -> str:
    return re.sub(r"[\s_-]+", " ", word.casefold()).strip()


def _expected(unit: str, value: object) -> str:
    if unit in {"1", "%"}:
        kind = "a number, or one with %,"
    else:
        kind = f"a number with a unit of {unit},"
    return f"expected {kind} such as {example(unit)}, got {quoted(value)}"


def quoted(value: object) -> str:
    """Return how a message shows a value of a file: short and without control characters."""
    if isinstance(value, str):
        text = value if len(value) <= 60 else value[:57] + "..."
        return '"' + "".join(c if c.isprintable() else f"\\x{ord(c):02x}" for c in text) + '"'
    if value is None:
        return "nothing"
    if isinstance(value, bool):
        return str(value).lower()
    if isinstance(value, dict):
        return "a mapping"
    return "a list" if isinstance(value, list) else str(value)


def _advice_for_number(value: object, unit: str) -> str:
    if isinstance(value, bool) or not isinstance(value, int | float):
        return ""
    return f"; write it with its unit, as {value} {example(unit).partition(' ')[2]}"


def _split(text: str, unit: str) -> tuple[float, str]:
    """Return the number that opens a text, and the text of its unit.

    Raises
    ------
    ValueError
        If the text opens with no number, or with one that has a decimal comma.
    """
    plain = text.translate(_LOOK_ALIKE).strip()
    if comma := _COMMA.match(plain):
        pointed = comma[0].replace(",", ".") + plain[comma.end() :]
        if re.fullmatch(r"[+-]?[1-9]\d*,\d\d\d", comma[0]):
            pointed += ", or " + comma[0].replace(",", "") + plain[comma.end() :]
        raise ValueError(_expected(unit, text) + f"; use a decimal point: {pointed}")
    match = _NUMBER.match(plain)
    if match is None:
        raise ValueError(_expected(unit, text))
    if len(match[0]) > 60:
        raise ValueError(_expected(unit, text) + "; the number is too long")
    return float(match[0]), plain[match.end() :].strip()


def _factor_or_error(written: str, wanted: str, text: str) -> tuple[float, float]:
    factor = _factor(written, wanted)
    if isinstance(factor, str):
        raise ValueError(f"{_expected(wanted, text)}; {factor}")
    return factor


def _reciprocal(scale: float) -> float:
    """Return 1/scale, exact where that is a whole number (1e-3 is not, 1000 is)."""
    inverse = 1.0 / scale
    whole = round(inverse)
    return float(whole) if math.isclose(inverse, whole, rel_tol=1e-15) else inverse


def _scaled(number: float, scale: float) -> float:
    """Return number times scale, dividing where that is the exact way: 0.05 mm is 5e-05 m."""
    if 0.0 < scale < 1.0:
        return number / _reciprocal(scale)
    return number * scale


@lru_cache(maxsize=512)
def _factor(written: str, wanted: str) -> tuple[float, float] | str:
    """Return scale and offset from a unit to SI, or the fault of the unit.

    Raises
    ------
    ValueError
        If the wanted unit is none: the caller's mistake.
    """
    if _is_temperature(wanted) and _is_temperature(written):
        return _TEMPERATURES[_degrees(written)]
    if root := _ROOT.fullmatch(written):
        return _factor(f"({root['amplitude']})^2/Hz", wanted)
    if level := _DECIBELS.fullmatch(written):
        reference = _with_number(level["reference"]).translate(_LOOK_ALIKE).strip()
        number = _NUMBER.match(reference)
        return _factor(reference[number.end() if number else 0 :].strip(), wanted)
    target = _parsed("K" if _is_temperature(wanted) else wanted, "g_n")
    if isinstance(target, str):
        raise ValueError(f'cannot want the unit "{wanted}": {target}')
    # A wanted unit that itself says g, such as g^2/Hz, means gravity.
    readings = ("g_n", "gram", "turning") if "rpm" in written else ("g_n", "gram")
    meanings = [_parsed(written, meaning) for meaning in readings]
    for meaning in meanings:
        if not isinstance(meaning, str) and meaning[1] == target[1]:
            return meaning[0], 0.0
    first = meanings[0]
    if isinstance(first, str):
        return first
    force = re.sub(r"\blb\b", "lbf", written)
    meant = _parsed(force, "g_n")
    hint = not isinstance(meant, str) and meant[1] == target[1]
    advice = f"; of force, write {force}" if hint else ""
    if written.strip() == "dB":
        advice = f"; say the reference, such as 120 dB re 1e-6 {wanted}"
    return f'"{written}" is not such a unit{advice}'


def _is_temperature(unit: str) -> bool:
    return _degrees(unit) in _TEMPERATURES


def _degrees(unit: str) -> str:
    return unit.strip().replace("°", "deg").replace(" ", "")


def _parsed(written: str, reading: str) -> tuple[float, dict[str, float]] | str:
    """Return the scale to SI and the dimensions of a unit, or its fault."""
    return USUAL.get((written, reading)) or _read(written, reading)


def _read(written: str, reading: str) -> tuple[float, dict[str, float]] | str:
    """Do as `_parsed`, by the registry."""
    plain = re.sub(r"[⁻⁰¹²³⁴⁵⁶⁷⁸⁹]+", lambda m: "^" + m[0].translate(_SUPERSCRIPT), written)
    plain = plain.translate(_LOOK_ALIKE).replace("°", "deg")
    if problem := _problem_of(plain):
        return problem
    expression = _SYMBOL.sub(lambda m: _name_of(m[0], reading), plain).replace("^", "**")
    expression = re.sub(r"(?<=[\w)])\s+(?=[\w(])", "*", expression.strip()) or "1"
    try:
        # The text holds known symbols, digits and operators only.
        parsed = _registry().parse_expression(expression)
    except Exception:  # noqa: BLE001  pint passes on whatever its parser stumbles over
        return _not_written(written)
    return _scale_and_dimensions(parsed)


def _scale_and_dimensions(parsed: Any) -> tuple[float, dict[str, float]]:
    if not hasattr(parsed, "to_base_units"):
        return float(parsed), {}
    base = parsed.to_base_units()
    dimensions = {str(name): float(power) for name, power in base.dimensionality.items()}
    # pint's base unit of mass is the gram here, that of SI the kilogram.
    return float(base.magnitude) * 1e-3 ** dimensions.get("[mass]", 0.0), dimensions


def _name_of(symbol: str, reading: str) -> str:
    """Return the registry's name of a symbol that means one thing here and another there."""
    gravity = "gram" if reading == "gram" else "g_n"
    names = {"g": gravity, "mg": f"(0.001*{gravity})", "kg": "(1000*gram)", "%": "0.01"}
    if reading == "turning":  # a speed of rotation, where rpm else is a frequency
        names["rpm"] = "(revolution/minute)"
    return names.get(symbol, symbol)


def _not_written(unit: str) -> str:
    """Return that a text is no unit, and how it is written where a power lacks its sign."""
    meant = _POWER.sub(r"^\1", unit)
    advice = "" if meant == unit or isinstance(_parsed(meant, "g_n"), str) else meant
    return f'"{unit}" is not written as a unit' + (f"; write {advice}" if advice else "")


def _problem_of(unit: str) -> str | None:
    """Return the error in the spelling of a unit, before pint sees it."""
    whole = _HALF_POWER.sub(r"\1", unit)
    if _WRITABLE.fullmatch(whole) is None:
        return f"{quoted(unit)} is not a unit"
    if re.search(r"\d\d|\d\.|\.\d|\*\*.*\*\*|\^[^-\d]|(?<!\^)-|--|\^-?\d*\^|\(\(\(", whole):
        return _not_written(unit)
    for symbol in _SYMBOL.findall(unit):
        if symbol not in _KNOWN:
            meant = near_miss(symbol, _SYMBOLS)
            return f'no unit "{symbol}"' + (f'; did you mean "{meant}"?' if meant else "")
    return None


@lru_cache(maxsize=1)
def _registry() -> "UnitRegistry[Any]":
    """Return a small registry: every unit of a test sheet and no furlongs."""
    import pint

    registry: UnitRegistry[Any] = pint.UnitRegistry(None)
    for line in _DEFINITIONS.strip().splitlines():
        registry.define(line)
    return registry
