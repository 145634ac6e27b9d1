"""Values of parameters that are more than a number: numbers, rows of them, effects."""

import re
from typing import Any, Final

from shakerproc.models.effects.base import Parameter
from shakerproc.units import quoted, to_si

_NUMBERS: Final = re.compile(
    r"((?:[+-]?(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?(?:\s*,\s*|\s+|$))+)(.*)", re.DOTALL
)
MOST_NUMBERS: Final = 4096
"""Numbers that a table may have in all."""


def read_numbers(value: object, parameter: Parameter) -> tuple[float, ...]:
    """Return the numbers of a text such as ``-0.1 0 0.1 mm`` in SI.

    Raises
    ------
    ValueError
        If it is none, with what was expected.
    """
    text = repr(value) if isinstance(value, int | float) else value
    found = _NUMBERS.fullmatch(text.strip()) if isinstance(text, str) else None
    if found is None:
        raise ValueError(
            f"expected numbers with one unit at the end, such as {example(parameter)}, got "
            f"{quoted(value)}"
        )
    unit = found[2].strip()
    words = found[1].replace(",", " ").split()
    if len(words) > MOST_NUMBERS:
        raise ValueError(f"expected {MOST_NUMBERS} numbers at most, got {len(words)}")
    return tuple(to_si(f"{word} {unit}".strip(), parameter.unit) for word in words)


def read_rows(value: object, parameter: Parameter) -> tuple[tuple[float, ...], ...]:
    """Return rows of numbers, each a text.

    Raises
    ------
    ValueError
        If they are none, with what was expected.
    """
    if not isinstance(value, list) or not value:
        raise ValueError(f"expected a list of rows, such as [{example(parameter)}]")
    rows = []
    for i, row in enumerate(value, 1):
        try:
            rows.append(read_numbers(row, parameter))
        except ValueError as error:
            raise ValueError(f"row {i}: {error}") from error
    return tuple(rows)


def example(parameter: Parameter) -> str:
    """Return how numbers are written."""
    return f"-1 0 1 {parameter.unit}"


def is_list_of_mappings(value: Any) -> bool:
    """Return whether a value is a list of mappings, as effects within an effect are."""
    return isinstance(value, list) and all(isinstance(one, dict) for one in value)
