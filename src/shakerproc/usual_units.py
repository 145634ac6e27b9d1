"""Units that most files say, as the registry of units reads them: without loading it."""

from collections.abc import Mapping
from types import MappingProxyType
from typing import Final, TypeAlias

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
