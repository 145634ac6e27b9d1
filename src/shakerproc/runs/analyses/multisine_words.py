"""A multisine's response in words."""

from collections.abc import Iterator, Mapping
from typing import Final

import numpy as np

from shakerproc.numerals import numeral
from shakerproc.runs.multisines import MultisineReading
from shakerproc.spectra.multisines import LineGrid, Share
from shakerproc.spectra.multisines.distortion import Kind

NAMES: Final[Mapping[Kind, str]] = {
    "even": "even distortion",
    "odd": "odd distortion",
    "all": "distortion over the realisations",
}
"""What each kind is called."""

HINTS: Final[Mapping[Kind, str]] = {
    "even": "even: a law that differs between push and pull",
    "odd": "odd: a law that is the same both ways: a hardening spring, play, friction",
}
"""What a kind of distortion is a sign of."""


def sentence(
    name: str,
    shares: Mapping[Kind, Share],
    noise: float | None,
    band: tuple[float, float],
) -> str:
    """Return whether a response is linear, and within how much, else how it is distorted.

    Parameters
    ----------
    name : str
        The response.
    shares : mapping
        What is known of each kind of distortion.
    noise : float, optional
        Share of the response that does not repeat [-]; None where it is not known.
    band : (float, float)
        First and last excited line [Hz].
    """
    where = f"{name}, {numeral(band[0], 4)} to {numeral(band[1], 4)} Hz"
    if not shares:
        told = "is not known" if noise is None else f"{_percent(noise)} of the response"
        return f"{where}: noise {told}; distortion is not known."
    if noise is None:
        parts = [f"{NAMES[one.kind]} {_percent(one.value)}" for one in shares.values()]
        return f"{where}: {', '.join(parts)} of the response (rms), with the noise in them."
    found = [one for one in shares.values() if one.bands]
    beside = f"noise {_percent(noise)}"
    if not found:
        most = max(one.limit for one in shares.values())
        return f"{where}: linear within {_percent(most)} of the response; {beside}."
    rest = [one for one in shares.values() if not one.bands]
    parts = [
        f"{NAMES[one.kind]} of {_percent(one.value)} of the response (rms), out of the noise "
        f"{_bands(one)}, {_percent(one.largest)} at {numeral(one.at, 4)} Hz"
        for one in found
    ]
    parts += [f"{NAMES[one.kind]} below {_percent(one.limit)}" for one in rest]
    parts.append(beside)
    hints = [HINTS[one.kind] for one in found if one.kind in HINTS]
    return f"{where}: {'; '.join(parts)}.{f' {_first_upper(hints)}.' if hints else ''}"


def _first_upper(hints: list[str]) -> str:
    text = "; ".join(hints)
    return text[:1].upper() + text[1:]


def _percent(share: float) -> str:
    return f"{numeral(100.0 * share, 2)} %"


def _bands(share: Share) -> str:
    first = [
        f"from {numeral(low, 4)} to {numeral(high, 4)} Hz" for low, high in share.bands[:3]
    ]
    more = len(share.bands) - len(first)
    return " and ".join(first) + (f" and in {more} more bands" if more else "")


def about(reading: MultisineReading) -> Iterator[str]:
    """Yield what was used, and which figures are not available and why."""
    layout, grid = reading.layout, reading.grid
    used = layout.periods - layout.left_out
    spacing = grid.frequency[0] / grid.number[0]
    yield (
        f"{layout.realisations} realisation{'s' * (layout.realisations > 1)} of {used} "
        f"period{'s' * (used > 1)} of {1.0 / spacing:.6g} s; {int(grid.excited.sum())} of "
        f"{grid.number.size} lines from {numeral(grid.frequency[0], 4)} to "
        f"{numeral(grid.frequency[-1], 4)} Hz are excited, {numeral(spacing, 4)} Hz apart, "
        f"{int(grid.even.sum())} even and {int(grid.odd.sum())} odd ones detect distortion."
    )
    if not grid.common:
        yield _own_lines(grid)
    if layout.left_out:
        yield (
            f"The first {layout.left_out} of {layout.periods} periods do not repeat (a "
            "transient) and are left out."
        )
    elif layout.periods == 2:
        yield "Two periods do not tell whether the first still holds a transient."
    if layout.realisations == 1:
        yield (
            "One realisation: distortion at the excited lines is not known; two or more tell "
            "it, seven tell it within 3 dB."
        )
    if not grid.even.any():
        yield _no_detection(reading)


def problems(reading: MultisineReading) -> Iterator[str]:
    """Yield what keeps a measurement from telling noise or distortion."""
    if reading.layout.periods - reading.layout.left_out == 1:
        yield (
            "one period only: the noise is not known, and distortion holds it; record two "
            "periods or more of each realisation, better eight"
        )
    if reading.grid.even.any() or np.any(reading.grid.carried > 1):
        return
    alone = "one realisation" if reading.layout.realisations == 1 else "no line excited twice"
    yield (
        f"no detection lines and {alone}: noise is known and distortion is not; "
        "excite odd lines only and leave some of them out, or record several realisations of "
        "the same lines"
    )


def _own_lines(grid: LineGrid) -> str:
    """Return how far the realisations share their lines."""
    shared = int(np.sum(grid.carried > 1))
    each = grid.excited_in.sum(axis=1)
    told = (
        f"Each realisation excites lines of its own, {each.min()} to {each.max()} of them; "
        f"{shared} are excited in two or more"
    )
    if not shared:
        return f"{told}: distortion at the excited lines is not known."
    return f"{told} and tell the scatter. Each line is averaged over the realisations it has."


def _no_detection(reading: MultisineReading) -> str:
    if reading.grid.excited_in.all():
        return (
            "No detection lines: every line is excited, so that even and odd distortion are "
            "not told apart."
        )
    return (
        "No detection lines: even lines are excited too, so that even and odd distortion are "
        "not told apart."
    )
