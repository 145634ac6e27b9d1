"""Checks of arguments: a ValueError that names the value and the range."""

import math


def positive(name: str, value: float, unit: str) -> None:
    """Pass a value that is finite and above 0.

    `value` is in `unit`, such as [Hz].

    Raises
    ------
    ValueError
        If it is not.
    """
    if not (math.isfinite(value) and value > 0.0):
        raise ValueError(f"{name} must be above 0 {unit}, not {value:g}")


def not_negative(name: str, value: float, unit: str) -> None:
    """Pass a value that is finite and 0 or above.

    `value` is in `unit`, such as [Hz].

    Raises
    ------
    ValueError
        If it is not.
    """
    if not (math.isfinite(value) and value >= 0.0):
        raise ValueError(f"{name} must be 0 {unit} or above, not {value:g}")


def finite(name: str, value: float, unit: str) -> None:
    """Pass a finite value.

    `value` is in `unit`, such as [Hz].

    Raises
    ------
    ValueError
        If it is not.
    """
    if not math.isfinite(value):
        raise ValueError(f"{name} must be a finite number [{unit}], not {value:g}")
