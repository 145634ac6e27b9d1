"""Cards of a Nastran deck in fields of 16 columns, 10 digits and more."""

from collections.abc import Iterable, Iterator

Field = str | int | float | None


def card(name: str, *fields: Field) -> str:
    """Return one card in large fields, continued as often as needed.

    Raises
    ------
    ValueError
        If a text does not fit its field.
    """
    columns = [_large(field) for field in fields]
    rows = [columns[i : i + 4] for i in range(0, len(columns), 4)] or [[]]
    if len(rows) % 2:
        rows.append([])  # a large-field card comes in pairs of lines
    lines = [f"{name + '*':<8}{''.join(rows[0])}"]
    lines += [f"{'*':<8}{''.join(row)}" for row in rows[1:]]
    return "\n".join(line.rstrip() for line in lines)


def table(identity: int, points: Iterable[tuple[float, float]]) -> str:
    """Return a TABLED1 card of (x, y) points, closed by ENDT.

    x in [s] or [Hz], y in any unit.
    """
    fields: list[Field] = [identity, None, None, None, None, None, None, None]
    for x, y in points:
        fields += [float(x), float(y)]
    return card("TABLED1", *fields, "ENDT")


def _large(field: Field) -> str:
    if field is None:
        return " " * 16
    if isinstance(field, float):
        return f"{real16(field):>16}"
    text = str(field)
    if len(text) > 16:
        raise ValueError(f"{text!r} does not fit a field of 16 columns")
    return f"{text:<16}" if isinstance(field, str) else f"{text:>16}"


def real16(value: float) -> str:
    """Return a number with as many digits as 16 columns hold, with its decimal point.

    `value` may be in any unit.

    Raises
    ------
    ValueError
        If no form fits, as of infinity.
    """
    for digits in range(13, 5, -1):
        text = f"{value:.{digits}E}"
        if "." in text and len(text) <= 16:
            return text
    raise ValueError(f"{value!r} does not fit a field of 16 columns")


def deck(executive: Iterable[str], case: Iterable[str], bulk: Iterable[str]) -> str:
    """Return a whole deck, from its first line to ENDDATA."""
    return "\n".join(_sections(executive, case, bulk)) + "\n"


def _sections(
    executive: Iterable[str], case: Iterable[str], bulk: Iterable[str]
) -> Iterator[str]:
    yield from executive
    yield "CEND"
    yield from case
    yield "BEGIN BULK"
    yield from bulk
    yield "ENDDATA"


def cards_of(text: str) -> list[list[str]]:
    """Return the large-field cards of a deck, each its name and its fields."""
    found: list[list[str]] = []
    for line in text.partition("BEGIN BULK\n")[2].splitlines():
        fields = [line[8 + 16 * i : 24 + 16 * i].strip() for i in range(4)]
        if line.startswith("*"):
            found[-1] += fields
        elif line[:8].rstrip().endswith("*"):
            found.append([line[:8].rstrip(" *"), *fields])
    return found
